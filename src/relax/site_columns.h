#pragma once

#include "ccvt/problem.h"
#include "geometry/metric.h"
#include "relax/site_state.h"

namespace ccvt {

/// Positions as the caller counts sites, number_of(site).
template <class Scalar, class NumberOf>
Columns<Scalar> site_columns(const Metric& metric, const SiteState& sites, NumberOf number_of) {
  Columns<Scalar> columns(metric.dimension(), static_cast<std::ptrdiff_t>(sites.count()));
  for (const SiteNumber s : sites.all()) {
    for (int d = 0; d < metric.dimension(); ++d) {
      columns(d, number_of(s).index()) = metric.template as<Scalar>(sites.at(s)[d], d);
    }
  }
  return columns;
}

/// The same, fixed ones as they were given, where that is in the box, whose faces are rounded as
/// coordinates are: on a torus its upper face is at the place of the lower one.
template <class Scalar, class NumberOf>
Columns<Scalar> site_columns(const Problem<Scalar>& problem, const Metric& metric,
                             const SiteState& sites, NumberOf number_of) {
  Columns<Scalar> columns = site_columns<Scalar>(metric, sites, number_of);
  if (!metric.periodic()) return columns;
  const Columns<Scalar>& fixed = problem.fixed_sites();
  const Box& box = problem.domain().box();
  for (std::ptrdiff_t f = 0; f < fixed.cols(); ++f) {
    for (std::ptrdiff_t d = 0; d < fixed.rows(); ++d) {
      const Scalar given = fixed(d, f);
      const auto lower = static_cast<Scalar>(box.lower[d]);
      const auto upper = static_cast<Scalar>(box.upper[d]);
      if (given >= lower && given <= upper) columns(d, f) = given;
    }
  }
  return columns;
}

}  // namespace ccvt
