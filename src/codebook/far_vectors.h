#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ccvt/ranks.h"
#include "ccvt/types.h"

namespace ccvt {

/// A warning where some vectors are so far from their codewords that what the cells of half of the
/// codewords cost is hardly seen in the sum of all, so that training ends before these are in
/// place; empty otherwise. `own`: this rank's vectors, or all, from number `first` on; `sites`: the
/// codewords, one after the other. O(m D), and messages to all ranks.
template <class Scalar>
std::string far_vectors(Ranks* ranks, PointsView<Scalar> own, std::int64_t first,
                        std::span<const Index> codes, const std::vector<double>& sites);

}  // namespace ccvt
