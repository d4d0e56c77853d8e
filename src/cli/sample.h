#pragma once

#include <string>

#include "ccvt/types.h"
#include "cli/arguments.h"
#include "number_text.h"

/// What `sample` does whatever runs it.
namespace ccvt::cli {

/// Throws InvalidInput unless the files can be written.
void check_outputs(const SampleArguments& arguments);

/// That of the fixed sites, which stay to the bit, unless the user says which.
ScalarType scalar_of(const SampleArguments& arguments);

/// Throws InvalidInput for a site outside the unit box: it would own a share of it all the same.
template <class Scalar>
void check_inside(const Points<Scalar>& sites) {
  for (Eigen::Index s = 0; s < sites.cols(); ++s) {
    for (Eigen::Index d = 0; d < sites.rows(); ++d) {
      if (sites(d, s) >= 0 && sites(d, s) <= 1) continue;
      throw InvalidInput("coordinate " + std::to_string(d) + " of sites[" + std::to_string(s) +
                         "] is " + text(double{sites(d, s)}) + "; it must be in the unit box");
    }
  }
}

}  // namespace ccvt::cli
