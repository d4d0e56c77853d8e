#pragma once

#include <doctest/doctest.h>

#include <initializer_list>

#include "ccvt/problem.h"
#include "support/generate.h"

namespace ccvt::test {

/// Calls visit(problem, points, layout) for points of each layout, in the box and on the torus.
template <class Scalar, class Visit>
void for_problems(std::initializer_list<int> dimensions, Index count, Index sites,
                  const Visit& visit) {
  for (const int dimension : dimensions) {
    for (const Layout layout : all_layouts) {
      for (const bool periodic : {false, true}) {
        CAPTURE(dimension);
        CAPTURE(name_of(layout));
        CAPTURE(periodic);
        const Box box = uneven_box(dimension);
        const auto points = make_points<Scalar>(layout, box, count);
        Problem<Scalar> problem(points, sites);
        if (periodic) problem.set_domain(Domain::periodic(box));
        visit(problem, points, layout);
      }
    }
  }
}

}  // namespace ccvt::test
