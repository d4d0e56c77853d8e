#include "codebook/reseat.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "exact/pricing.h"
#include "geometry/squares.h"

namespace ccvt {
namespace {

constexpr int kSplitIterations = 4;

struct Split {
  double gain = 0;
  std::vector<double> a, b;  ///< the two sites
};

struct Merger {
  double cost = std::numeric_limits<double>::infinity();
  Index i = -1, j = -1;
};

std::vector<double> centroid(PointsView<float> points, const std::vector<Index>& members) {
  std::vector<double> sum(static_cast<std::size_t>(points.dimension), 0.0);
  for (const Index p : members) {
    for (std::size_t d = 0; d < sum.size(); ++d) sum[d] += static_cast<double>(points[p][d]);
  }
  for (double& x : sum) x /= static_cast<double>(members.size());
  return sum;
}

double energy(PointsView<float> points, const std::vector<Index>& members,
              const std::vector<double>& site) {
  double sum = 0;
  for (const Index p : members) {
    sum += squared_difference(points[p], site.data(), points.dimension);
  }
  return sum;
}

/// 2-means in a cell, from the point farthest from the centroid and the one farthest from that.
Split split(PointsView<float> points, const std::vector<Index>& members) {
  Split result;
  if (members.size() < 2) return result;
  const std::vector<double> middle = centroid(points, members);
  const auto farthest = [&](const auto* from) {
    return *std::max_element(members.begin(), members.end(), [&](Index p, Index q) {
      return squared_difference(points[p], from, points.dimension) <
             squared_difference(points[q], from, points.dimension);
    });
  };
  const Index first = farthest(middle.data());
  const Index second = farthest(points[first]);
  result.a.assign(points[first], points[first] + points.dimension);
  result.b.assign(points[second], points[second] + points.dimension);
  std::vector<Index> left, right;
  for (int i = 0; i < kSplitIterations; ++i) {
    left.clear();
    right.clear();
    for (const Index p : members) {
      const bool nearer = squared_difference(points[p], result.a.data(), points.dimension) <=
                          squared_difference(points[p], result.b.data(), points.dimension);
      (nearer ? left : right).push_back(p);
    }
    if (left.empty() || right.empty()) return {};
    result.a = centroid(points, left);
    result.b = centroid(points, right);
  }
  result.gain = energy(points, members, middle) - energy(points, left, result.a) -
                energy(points, right, result.b);
  return result;
}

}  // namespace

bool reseat_sites(PointsView<float> points, const std::vector<Index>& owners,
                  std::vector<double>& sites, const Arena& arena) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const auto n = static_cast<Index>(sites.size() / dimension);
  const Grouping groups(owners, n);
  std::vector<Split> splits(static_cast<std::size_t>(n));
  std::vector<Merger> mergers(static_cast<std::size_t>(n));
  const auto at = [&](Index s) { return sites.data() + static_cast<std::size_t>(s) * dimension; };
  for (Index i = 0; i < n; ++i) {
    arena.check();
    const auto members = groups.of(i);
    splits[static_cast<std::size_t>(i)] = split(points, {members.begin(), members.end()});
    Merger& merger = mergers[static_cast<std::size_t>(i)];
    const auto own = static_cast<double>(members.size());
    for (Index j = 0; j < n; ++j) {
      if (j == i) continue;
      const auto other = static_cast<double>(groups.of(j).size());
      const double cost = own * other == 0 ? 0
                                           : own * other / (own + other) *
                                                 squared_difference(at(i), at(j), points.dimension);
      if (cost < merger.cost) merger = {cost, i, j};
    }
  }
  std::sort(mergers.begin(), mergers.end(), [](const Merger& a, const Merger& b) {
    return a.cost != b.cost ? a.cost < b.cost : a.i < b.i;
  });
  std::vector<Index> by_gain(static_cast<std::size_t>(n));
  std::iota(by_gain.begin(), by_gain.end(), 0);
  std::stable_sort(by_gain.begin(), by_gain.end(), [&](Index a, Index b) {
    return splits[static_cast<std::size_t>(a)].gain > splits[static_cast<std::size_t>(b)].gain;
  });
  std::vector<std::uint8_t> taken(static_cast<std::size_t>(n), 0);
  std::size_t next = 0;
  bool changed = false;
  for (const Merger& merger : mergers) {
    if (merger.i < 0) break;
    auto& i = taken[static_cast<std::size_t>(merger.i)];
    auto& j = taken[static_cast<std::size_t>(merger.j)];
    if (i != 0 || j != 0) continue;
    const auto free = [&](Index s) {
      return taken[static_cast<std::size_t>(s)] == 0 && s != merger.i && s != merger.j;
    };
    while (next < by_gain.size() && taken[static_cast<std::size_t>(by_gain[next])] != 0) ++next;
    std::size_t k = next;
    while (k < by_gain.size() && !free(by_gain[k])) ++k;
    if (k == by_gain.size()) break;
    const Index from = by_gain[k];
    const Split& halves = splits[static_cast<std::size_t>(from)];
    if (halves.gain <= merger.cost) break;
    const auto own = static_cast<double>(groups.of(merger.i).size());
    const auto other = static_cast<double>(groups.of(merger.j).size());
    for (std::size_t d = 0; own + other > 0 && d < dimension; ++d) {
      at(merger.j)[d] = (own * at(merger.i)[d] + other * at(merger.j)[d]) / (own + other);
    }
    std::copy(halves.a.begin(), halves.a.end(), at(from));
    std::copy(halves.b.begin(), halves.b.end(), at(merger.i));
    i = j = taken[static_cast<std::size_t>(from)] = 1;
    changed = true;
  }
  return changed;
}

}  // namespace ccvt
