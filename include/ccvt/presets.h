#pragma once

#include <span>
#include <string>
#include <string_view>

#include "ccvt/export.h"
#include "ccvt/options.h"

namespace ccvt {

/// A named set of options.
struct Preset {
  std::string name;
  std::string description;
  /// `threads` is 1, except where all processors are the point of it (0).
  Options options;
};

/// The rows of Table 1 of the paper, top to bottom, but for Lloyd relaxation, which is lloyd().
/// From "uncached" on each row adds one idea to the row before:
///
///     balzer2009          original CCVT [Program 1]
///     balzer2009-pruned   + bounding circle + coherent initialization [5.1]
///     section4            our method (in Section 4)
///     uncached            section4 without the site-pair cache, which the table adds last
///     pruned              + bounding circle + coherent initialization [5.1]
///     median-cut          + median cut pruning [5.2], which has no row of its own in the table
///     point-distance      + point distance pruning [5.2]
///     multilevel          + multi-level [5.2]
///     parallel            + OpenMP: all threads
///     fast-ccvt           + 2-stage pair caching [4.2]: Options::fast_ccvt()
CCVT_EXPORT std::span<const Preset> paper_presets();

/// The default, and the default with one of its ideas replaced by what it replaced, or one of the
/// paper's added.
CCVT_EXPORT std::span<const Preset> ablation_presets();

/// The preset of that name. Throws InvalidInput, with all names, when there is none.
CCVT_EXPORT const Preset& find_preset(std::string_view name);

}  // namespace ccvt
