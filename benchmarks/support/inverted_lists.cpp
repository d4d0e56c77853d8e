#include "support/inverted_lists.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "cell_sizes.h"
#include "geometry/squares.h"
#include "parallel/arena.h"

namespace ccvt::bench {
namespace {

/// Candidates for the nearest, by float products, of which distances in double choose.
constexpr std::size_t kRough = 4 * kNeighbours;
constexpr Eigen::Index kBlockQueries = 64;
constexpr std::size_t kQueriesPerGrain = 1;

std::vector<Index> nearest_of(const Points<float>& vectors, const Points<float>& queries,
                              Eigen::Index query, const Eigen::VectorXf& rough) {
  std::vector<Index> order(static_cast<std::size_t>(vectors.cols()));
  std::iota(order.begin(), order.end(), 0);
  const auto least = [&](std::size_t count, const auto& key) {
    const std::size_t kept = std::min(count, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                      [&](Index a, Index b) {
                        const auto x = key(a);
                        const auto y = key(b);
                        return x != y ? x < y : a < b;
                      });
    order.resize(kept);
  };
  least(kRough, [&](Index p) { return rough[p]; });
  least(kNeighbours, [&](Index p) {
    return squared_difference(queries.col(query).data(), vectors.col(p).data(),
                              static_cast<int>(vectors.rows()));
  });
  return order;
}

}  // namespace

std::vector<std::vector<Index>> true_neighbours(const Points<float>& vectors,
                                                const Points<float>& queries, int threads) {
  // Relative to the mean, in units in which squares do not overflow: products in float then lose no
  // more than the candidates make up for.
  const Eigen::VectorXd mean = vectors.cast<double>().rowwise().mean();
  const double largest = std::max((vectors.cast<double>().colwise() - mean).cwiseAbs().maxCoeff(),
                                  (queries.cast<double>().colwise() - mean).cwiseAbs().maxCoeff());
  const double scale = largest > 0 ? 1 / largest : 1;
  const auto centred = [&](const Points<float>& points) -> Points<float> {
    return ((points.cast<double>().colwise() - mean) * scale).cast<float>();
  };
  const Points<float> near = centred(vectors);
  const Points<float> near_queries = centred(queries);
  const Eigen::VectorXf norms = near.colwise().squaredNorm();
  std::vector<std::vector<Index>> neighbours(static_cast<std::size_t>(queries.cols()));
  const Arena arena(threads);
  for (Eigen::Index first = 0; first < queries.cols(); first += kBlockQueries) {
    const Eigen::Index count = std::min(kBlockQueries, queries.cols() - first);
    Eigen::MatrixXf rough = -2 * near.transpose() * near_queries.middleCols(first, count);
    rough.colwise() += norms;
    arena.for_each(static_cast<std::size_t>(count), kQueriesPerGrain, [&](std::size_t k) {
      const auto column = static_cast<Eigen::Index>(k);
      neighbours[static_cast<std::size_t>(first) + k] =
          nearest_of(vectors, queries, first + column, rough.col(column));
    });
  }
  return neighbours;
}

std::vector<Probe> probe_lists(const Codebook& codebook, std::span<const Index> codes,
                               const Points<float>& queries,
                               const std::vector<std::vector<Index>>& neighbours, Coding coding) {
  const auto n = static_cast<std::size_t>(codebook.size());
  const std::vector<Index> length = cell_sizes(codes, n);
  std::vector<Probe> probes;
  for (std::size_t lists = 1;; lists = std::min(2 * lists, n)) {
    probes.push_back({static_cast<Index>(lists), 0, 0, 0, 0});
    if (lists == n) break;
  }
  std::vector<std::vector<double>> scanned(probes.size());
  const auto words = codebook.codewords();
  const auto weights = codebook.weights();
  std::vector<std::size_t> order(n);
  std::vector<std::size_t> rank(n);
  Eigen::VectorXd cost(codebook.size());
  for (std::size_t q = 0; q < neighbours.size(); ++q) {
    cost = (words.colwise() - queries.col(static_cast<Eigen::Index>(q)).cast<double>())
               .colwise()
               .squaredNorm();
    if (coding == Coding::weighted) cost -= weights;
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const double x = cost[static_cast<Eigen::Index>(a)];
      const double y = cost[static_cast<Eigen::Index>(b)];
      return x != y ? x < y : a < b;
    });
    for (std::size_t k = 0; k < n; ++k) rank[order[k]] = k;
    std::size_t looked_at = 0;
    double vectors = 0;
    for (std::size_t k = 0; k < probes.size(); ++k) {
      const auto lists = static_cast<std::size_t>(probes[k].lists);
      for (; looked_at < lists; ++looked_at) vectors += length[order[looked_at]];
      scanned[k].push_back(vectors);
      const auto found = [&](Index p) {
        return rank[static_cast<std::size_t>(codes[static_cast<std::size_t>(p)])] < lists;
      };
      probes[k].recall_1 += found(neighbours[q].front()) ? 1 : 0;
      probes[k].recall_10 +=
          static_cast<double>(std::count_if(neighbours[q].begin(), neighbours[q].end(), found)) /
          static_cast<double>(neighbours[q].size());
    }
  }
  const auto queried = static_cast<double>(neighbours.size());
  for (std::size_t k = 0; k < probes.size(); ++k) {
    probes[k].recall_1 /= queried;
    probes[k].recall_10 /= queried;
    std::sort(scanned[k].begin(), scanned[k].end());
    probes[k].scanned_mean = std::accumulate(scanned[k].begin(), scanned[k].end(), 0.0) / queried;
    const auto at = static_cast<std::size_t>(std::ceil(0.99 * queried)) - 1;
    probes[k].scanned_99 = scanned[k][at];
  }
  return probes;
}

}  // namespace ccvt::bench
