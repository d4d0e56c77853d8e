#include "codebook/reseat.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "cell_sizes.h"
#include "codebook/mergers.h"
#include "exact/distances.h"
#include "exact/grouping.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

constexpr int kSplitIterations = 4;
constexpr std::size_t kPointsPerGrain = 256;

struct Split {
  double gain = 0;
  Eigen::VectorXd a, b;  ///< the two sites
};

Eigen::VectorXd centroid(PointsView<float> points, std::span<const PointNumber> members) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(points.dimension);
  const Eigen::VectorXd origin = sum;
  add_points(points, members, origin.data(), sum.data());
  const auto size = static_cast<double>(members.size());
  for (double& x : sum) x /= size;
  return sum;
}

std::vector<double> distances(PointsView<float> points, std::span<const PointNumber> members,
                              const Eigen::VectorXd& from) {
  std::vector<double> squared;
  squared_distances(points, members, from.data(), squared);
  return squared;
}

double energy(PointsView<float> points, std::span<const PointNumber> members,
              const Eigen::VectorXd& site) {
  const std::vector<double> squared = distances(points, members, site);
  return std::accumulate(squared.begin(), squared.end(), 0.0);
}

/// 2-means in a cell, from the point farthest from the centroid and the one farthest from that.
Split split(PointsView<float> points, std::span<const PointNumber> members) {
  Split result;
  if (members.size() < 2) return result;
  const Eigen::VectorXd middle = centroid(points, members);
  const auto farthest = [&](const Eigen::VectorXd& from) -> Eigen::VectorXd {
    const std::vector<double> squared = distances(points, members, from);
    const auto far = std::max_element(squared.begin(), squared.end()) - squared.begin();
    const float* const x = points[members[static_cast<std::size_t>(far)].index()];
    return Eigen::Map<const Eigen::VectorXf>(x, points.dimension).cast<double>();
  };
  result.a = farthest(middle);
  result.b = farthest(result.a);
  std::vector<PointNumber> left, right;
  for (int i = 0; i < kSplitIterations; ++i) {
    left.clear();
    right.clear();
    const std::vector<double> to_a = distances(points, members, result.a);
    const std::vector<double> to_b = distances(points, members, result.b);
    for (std::size_t k = 0; k < members.size(); ++k) {
      (to_a[k] <= to_b[k] ? left : right).push_back(members[k]);
    }
    if (left.empty() || right.empty()) return {};
    result.a = centroid(points, left);
    result.b = centroid(points, right);
  }
  result.gain = energy(points, members, middle) - energy(points, left, result.a) -
                energy(points, right, result.b);
  return result;
}

/// Each rank has found some of them; then all have all.
void share_splits(Ranks* ranks, std::vector<Split>& splits, const RankRange& own,
                  std::size_t dimension) {
  if (ranks == nullptr) return;
  std::vector<double> found;  // of those that gain: which it is, what it gains, two sites
  for (std::size_t s = own.begin; s < own.end; ++s) {
    const Split& split = splits[s];
    if (split.gain <= 0) continue;
    found.insert(found.end(), {static_cast<double>(s), split.gain});
    found.insert(found.end(), split.a.begin(), split.a.end());
    found.insert(found.end(), split.b.begin(), split.b.end());
  }
  found = joined(ranks, std::move(found));
  const auto width = static_cast<Eigen::Index>(dimension);
  for (std::size_t k = 0; k < found.size(); k += 2 + 2 * dimension) {
    Split& split = splits[static_cast<std::size_t>(found[k])];
    split.gain = found[k + 1];
    split.a = Eigen::Map<const Eigen::VectorXd>(found.data() + k + 2, width);
    split.b = Eigen::Map<const Eigen::VectorXd>(found.data() + k + 2 + dimension, width);
  }
}

}  // namespace

bool reseat_sites(PointsView<float> points, std::vector<Index>& owners, std::vector<double>& sites,
                  const Arena& arena) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const std::size_t n = sites.size() / dimension;
  const Grouping groups(owners, n, arena);
  std::vector<Split> splits(n);
  const std::vector<Index> sizes = cell_sizes(owners, n);
  const std::vector<double> size(sizes.begin(), sizes.end());
  const auto at = [&](SiteNumber s) { return sites.data() + s * dimension; };
  const RankRange own(arena.ranks(), n, 1);
  arena.for_each(own.end - own.begin, 1 + kPointsPerGrain * n / owners.size(), [&](std::size_t k) {
    const SiteNumber i(own.begin + k);
    splits[i] = split(points, groups.of(i));
  });
  share_splits(arena.ranks(), splits, own, dimension);
  std::vector<Merger> mergers = cheapest_mergers(sites, dimension, size, arena);
  std::sort(mergers.begin(), mergers.end(), [](const Merger& a, const Merger& b) {
    return a.cost != b.cost ? a.cost < b.cost : a.i < b.i;
  });
  std::vector<SiteNumber> by_gain(n);
  std::iota(by_gain.begin(), by_gain.end(), SiteNumber(0));
  std::stable_sort(by_gain.begin(), by_gain.end(),
                   [&](SiteNumber a, SiteNumber b) { return splits[a].gain > splits[b].gain; });
  std::vector<std::uint8_t> taken(n, 0);
  std::size_t next = 0;
  bool changed = false;
  for (const auto& [cost, i, j] : mergers) {
    if (i == j) break;
    if (taken[i] != 0 || taken[j] != 0) continue;
    while (next < n && taken[by_gain[next]] != 0) ++next;
    std::size_t k = next;
    while (k < n && (taken[by_gain[k]] != 0 || by_gain[k] == i || by_gain[k] == j)) ++k;
    if (k == n) break;
    const SiteNumber from = by_gain[k];
    const Split& halves = splits[from];
    if (halves.gain <= cost) break;
    const double both = size[i] + size[j];
    for (std::size_t d = 0; both > 0 && d < dimension; ++d) {
      at(j)[d] = (size[i] * at(i)[d] + size[j] * at(j)[d]) / both;
    }
    std::copy(halves.a.begin(), halves.a.end(), at(from));
    std::copy(halves.b.begin(), halves.b.end(), at(i));
    for (const PointNumber p : groups.of(i)) owners[p] = j.index();
    for (const PointNumber p : groups.of(from)) {
      const float* const x = points[p.index()];
      const double first = squared_distance(x, halves.a.data(), points.dimension);
      const double second = squared_distance(x, halves.b.data(), points.dimension);
      if (second < first) owners[p] = i.index();
    }
    taken[i] = taken[j] = taken[from] = 1;
    changed = true;
  }
  return changed;
}

}  // namespace ccvt
