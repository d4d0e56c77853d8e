#pragma once

#include "ccvt/domain.h"
#include "ccvt/io.h"
#include "cli/arguments.h"

namespace ccvt::cli {

/// Whether the points have masses. Throws InvalidInput when what is said of masses does not fit the
/// rest.
bool check_masses(const TessellateArguments& arguments);

/// A file of points, and which of its columns are their coordinates.
struct PointsToRead {
  ReadOptions reading;
  PointsHeader header;
};

/// Looks at the file of points once. Coordinates are as --columns says, or else as the file has it,
/// but for the column of masses. Throws InvalidInput when that is a coordinate, or is not there.
PointsToRead inspect_beside_masses(const TessellateArguments& arguments);

/// `ccvt tessellate` of points with masses.
int run_with_masses(const TessellateArguments& arguments, const PointsHeader& header,
                    const Domain& domain);

}  // namespace ccvt::cli
