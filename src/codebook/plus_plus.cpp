#include "codebook/plus_plus.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>

#include "exact/centroids.h"
#include "exact/distances.h"
#include "geometry/metric.h"
#include "kernels/products.h"
#include "random.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = 1024;
/// Points whose coordinates lie together have about so many, and are a multiple of so many.
constexpr std::size_t kTileValues = 8192;
constexpr std::size_t kTilePoints = kernels::kSumPoints;
/// Coordinates that a task looks at, about.
constexpr std::size_t kTaskValues = std::size_t{1} << 17;

/// Sites drawn from some points, for several streams of random numbers at once.
class PlusPlus {
 public:
  PlusPlus(PointsView<float> points, Index sites, std::uint64_t seed,
           std::span<const std::uint64_t> streams, const Arena& arena)
      : points_(points),
        arena_(arena),
        tile_(kTilePoints * std::max<std::size_t>(1, kTileValues / (kTilePoints * width()))),
        tiles_((static_cast<std::size_t>(points.count) + tile_ - 1) / tile_),
        grain_(1 + kTaskValues / (tile_ * width() * streams.size())),
        draws_(points.dimension <= kGreedyDimensions ? 2 + static_cast<int>(std::log(sites)) : 1) {
    block_.assign(tiles_ * tile_ * width(), 0.0F);
    for_tiles([&](std::size_t tile) { copy(tile); });
    for (const std::uint64_t stream : streams) seedings_.emplace_back(seed, stream, tiles_ * tile_);
    for (Seeding& seeding : seedings_) {
      std::fill_n(seeding.squared.begin(), points.count, std::numeric_limits<float>::max());
      seeding.sum.resize(static_cast<std::size_t>(points.count));
    }
  }

  std::vector<std::vector<double>> draw(Index sites) {
    for (Index s = 0; s < sites; ++s) {
      arena_.check();
      arena_.for_each(seedings_.size(), 1, [&](std::size_t k) { draw_some(seedings_[k], s == 0); });
      if (draws_ > 1) choose();
      for (Seeding& seeding : seedings_) {
        const float* const x = points_[seeding.chosen];
        seeding.sites.insert(seeding.sites.end(), x, x + points_.dimension);
      }
      for_tiles([&](std::size_t tile) {
        for (Seeding& seeding : seedings_) {
          kernels::lower_squares(at(tile), static_cast<Index>(tile_), points_.dimension,
                                 points_[seeding.chosen], seeding.squared.data() + tile * tile_);
        }
      });
    }
    std::vector<std::vector<double>> sites_of_each;
    for (Seeding& seeding : seedings_) sites_of_each.push_back(std::move(seeding.sites));
    return sites_of_each;
  }

 private:
  struct Seeding {
    Seeding(std::uint64_t seed, std::uint64_t stream, std::size_t points)
        : random(seed, stream), squared(points, 0.0F) {}
    Random random;
    std::vector<float> squared;  ///< distances to the nearest site so far
    std::vector<double> sum;     ///< of those up to each point
    std::vector<Index> drawn;
    std::vector<double> left;  ///< of each draw, and some points of a tile after the other
    Index chosen = 0;
    std::vector<double> sites;
  };

  [[nodiscard]] std::size_t width() const { return static_cast<std::size_t>(points_.dimension); }
  [[nodiscard]] float* at(std::size_t tile) { return block_.data() + tile * tile_ * width(); }
  [[nodiscard]] std::size_t points_in(std::size_t tile) const {
    return std::min(tile_, static_cast<std::size_t>(points_.count) - tile * tile_);
  }

  template <class Visit>
  void for_tiles(const Visit& visit) {
    arena_.for_each(tiles_, grain_, visit);
  }

  /// Coordinates one after the other, of the points of a tile each.
  void copy(std::size_t tile) {
    float* const block = at(tile);
    for (std::size_t k = 0; k < points_in(tile); ++k) {
      const float* const x = points_[static_cast<Index>(tile * tile_ + k)];
      for (std::size_t d = 0; d < width(); ++d) block[d * tile_ + k] = x[d];
    }
  }

  void draw_some(Seeding& seeding, bool first) const {
    seeding.drawn.clear();
    seeding.chosen = seeding.random.index_below(points_.count);
    if (first) return;
    std::vector<double>& sum = seeding.sum;
    std::transform_inclusive_scan(seeding.squared.begin(), seeding.squared.begin() + points_.count,
                                  sum.begin(), std::plus<>(), [](float x) -> double { return x; });
    if (!(sum.back() > 0)) return;
    for (int draw = 0; draw < draws_; ++draw) {
      const double place = seeding.random.uniform() * sum.back();
      const auto found = std::upper_bound(sum.begin(), sum.end() - 1, place);
      seeding.drawn.push_back(static_cast<Index>(found - sum.begin()));
    }
    if (draws_ == 1) seeding.chosen = seeding.drawn.front();
  }

  /// Of the points drawn, those that leave the least energy.
  void choose() {
    const std::size_t sums = tiles_ * tile_ / kTilePoints;
    for (Seeding& seeding : seedings_) seeding.left.assign(seeding.drawn.size() * sums, 0.0);
    for_tiles([&](std::size_t tile) {
      const std::size_t place = tile * tile_ / kTilePoints;
      for (Seeding& seeding : seedings_) {
        for (std::size_t k = 0; k < seeding.drawn.size(); ++k) {
          kernels::lowered_sums(at(tile), static_cast<Index>(tile_),
                                static_cast<Index>(points_in(tile)), points_.dimension,
                                points_[seeding.drawn[k]], seeding.squared.data() + tile * tile_,
                                seeding.left.data() + k * sums + place);
        }
      }
    });
    for (Seeding& seeding : seedings_) {
      double least = std::numeric_limits<double>::infinity();
      const double* left = seeding.left.data();
      for (const Index drawn : seeding.drawn) {
        const double all = std::accumulate(left, left + sums, 0.0);
        left += sums;
        if (all < least) {
          least = all;
          seeding.chosen = drawn;
        }
      }
    }
  }

  PointsView<float> points_;
  const Arena& arena_;
  std::size_t tile_;  ///< points of a tile
  std::size_t tiles_;
  std::size_t grain_;
  int draws_;
  std::vector<float> block_;
  std::vector<Seeding> seedings_;
};

}  // namespace

std::vector<std::vector<double>> plus_plus(PointsView<float> points, Index sites,
                                           std::uint64_t seed,
                                           std::span<const std::uint64_t> streams,
                                           const Arena& arena) {
  return PlusPlus(points, sites, seed, streams, arena).draw(sites);
}

std::vector<double> plus_plus_in_rounds(PointsView<float> points, Index sites, std::uint64_t seed,
                                        std::uint64_t stream, const Arena& arena) {
  const Metric metric(points.dimension, Domain());
  const auto width = static_cast<std::size_t>(points.dimension);
  std::vector<double> squared(static_cast<std::size_t>(points.count),
                              std::numeric_limits<double>::infinity());
  Random random(seed, stream);
  std::vector<double> result;
  std::vector<Index> drawn = {random.index_below(points.count)};
  for (Index left = sites;;) {
    std::vector<double> added;
    for (const Index p : drawn) added.insert(added.end(), points[p], points[p] + width);
    result.insert(result.end(), added.begin(), added.end());
    left -= static_cast<Index>(drawn.size());
    if (left == 0) return result;
    const std::vector<Index> nearest = nearest_owners(metric, points, added, arena);
    arena.for_each(squared.size(), kPointsPerGrain, [&](std::size_t p) {
      const double* const site = added.data() + static_cast<std::size_t>(nearest[p]) * width;
      const float* const x = points[static_cast<Index>(p)];
      squared[p] = std::min(squared[p], squared_distance(x, site, points.dimension));
    });
    std::vector<double> sum(squared.size());
    std::inclusive_scan(squared.begin(), squared.end(), sum.begin());
    const auto batch = std::min<std::size_t>(result.size() / width, static_cast<std::size_t>(left));
    drawn.clear();
    for (std::size_t k = 0; k < batch; ++k) {
      const double at = random.uniform() * sum.back();
      const auto found = std::upper_bound(sum.begin(), sum.end() - 1, at) - sum.begin();
      // Where all points are at sites, any will do.
      drawn.push_back(sum.back() > 0 ? static_cast<Index>(found)
                                     : random.index_below(points.count));
    }
    std::sort(drawn.begin(), drawn.end());
    drawn.erase(std::unique(drawn.begin(), drawn.end()), drawn.end());
  }
}

}  // namespace ccvt
