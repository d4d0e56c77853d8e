#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/types.h"

/// Searches of vectors that lie in lists, one for each codeword of a codebook.
namespace ccvt::bench {

/// Of a query that recall is counted for.
constexpr std::size_t kNeighbours = 10;

/// The kNeighbours nearest vectors of each query, or all if there are fewer, nearest first. By
/// float products, of which distances in double choose.
std::vector<std::vector<Index>> true_neighbours(const Points<float>& vectors,
                                                const Points<float>& queries, int threads);

/// Searches that look at so many lists each.
struct Probe {
  Index lists = 0;
  double recall_1 = 0;      ///< share of queries whose nearest vector is in a list looked at
  double recall_10 = 0;     ///< share of the kNeighbours nearest, on average
  double scanned_mean = 0;  ///< vectors in the lists looked at
  double scanned_99 = 0;    ///< no more of them for 99 of 100 queries
};

/// For 1, 2, 4, … lists, and all. A query looks at the lists whose codewords are nearest, or cost
/// least with weights.
std::vector<Probe> probe_lists(const Codebook& codebook, std::span<const Index> codes,
                               const Points<float>& queries,
                               const std::vector<std::vector<Index>>& neighbours, Coding coding);

}  // namespace ccvt::bench
