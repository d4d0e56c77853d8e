#pragma once

#include <span>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// The least weight of the normals with which cells become full; see tessellate_in_turns().
constexpr double kFirstWeight = 2;

/// What a tessellation comes to.
template <class Scalar>
struct Outcome {
  Points<Scalar> sites;
  std::vector<Index> owners;
  Summary summary;  ///< of the last turn, but for seconds_total
};

/// Tessellates points on a surface: in the order of their line, with positions, and under these
/// normals, if there are any. `groups`: of sheets, one for each point, those of one in a row.
///
/// With normals, in two turns. First each group by itself, with normals as they are given, which
/// should be large: else points flow from side to side of a thin sheet while cells become full,
/// which exchanges between two cells do not take back. Then all together, from there, with normals
/// that are `shrink` times as large, as large ones stretch the metric where the surface is bent.
/// The points are left with those.
template <class Scalar>
Outcome<Scalar> tessellate_in_turns(Points<Scalar>& points, std::span<const Index> groups,
                                    Index sites, double shrink, const Options& options);

}  // namespace ccvt
