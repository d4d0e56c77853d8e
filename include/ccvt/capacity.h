#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/export.h"
#include "ccvt/types.h"

namespace ccvt {

/// Capacities for `sites` sites that sum to `points` and differ by at most one, the larger ones
/// first. Throws InvalidInput unless 1 <= sites <= points, and no site gets more than Index counts.
CCVT_EXPORT std::vector<Index> equal_capacities(std::int64_t points, Index sites);

/// Throws InvalidInput unless there is at least one capacity, all are positive, and they sum to
/// `points`.
CCVT_EXPORT void validate_capacities(std::span<const Index> capacities, std::int64_t points);

/// The capacity error of Balzer et al. 2009: the mean over sites of (size / mean size - 1)^2, where
/// size is the number of points that a site owns in `owners`. Zero for equal cells.
CCVT_EXPORT double capacity_error(std::span<const Index> owners, Index sites);

}  // namespace ccvt
