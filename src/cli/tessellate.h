#pragma once

#include <Eigen/Core>
#include <optional>

#include "ccvt/domain.h"
#include "ccvt/io.h"
#include "ccvt/linear_map.h"
#include "ccvt/types.h"
#include "cli/arguments.h"

/// What `tessellate` does whatever runs it.
namespace ccvt::cli {

/// Throws InvalidInput where arguments do not go together.
void check_arguments(const TessellateArguments& arguments);
/// That of --sites or, without, of --capacities; 0 where initial sites are given.
Index number_of_sites(const TessellateArguments& arguments);
/// Throws InvalidInput unless the files can be written.
void check_outputs(const TessellateArguments& arguments);

/// What the options say of the domain of points, with the file's box where they do not say which.
Domain make_domain(const TessellateArguments& arguments, const PointsHeader& header);

/// How distances are measured by --units; none without. Of points of so many dimensions.
std::optional<LinearMap> units_of(const TessellateArguments& arguments, int dimension);

/// Sites where they are in the coordinates of the points; fixed ones to the bit, but for images in
/// a box.
template <class Scalar>
Points<Scalar> mapped_back(const LinearMap& map, const Points<Scalar>& mapped_sites,
                           const Points<Scalar>& fixed_sites,
                           const Points<Scalar>& mapped_fixed_sites) {
  Points<Scalar> sites = map.inverse(mapped_sites);
  for (Eigen::Index s = 0; s < fixed_sites.cols(); ++s) {
    if (mapped_sites.col(s) == mapped_fixed_sites.col(s)) sites.col(s) = fixed_sites.col(s);
  }
  return sites;
}

}  // namespace ccvt::cli
