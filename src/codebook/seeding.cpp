#include "codebook/seeding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "codebook/reseat.h"
#include "codebook/rough_lloyd.h"
#include "codebook/sample.h"
#include "exact/centroids.h"
#include "exact/pricing.h"
#include "geometry/as_matrix.h"
#include "geometry/squares.h"
#include "kernels/products.h"
#include "random.h"
#include "streams.h"

namespace ccvt {
namespace {

/// The sample has this many points a site, and no fewer than kLeastSample.
constexpr std::int64_t kSamplePerSite = 64;
constexpr std::int64_t kSmallSamplePerSite = 16;  ///< where sites are drawn in rounds
constexpr std::int64_t kLeastSample = 8192;
/// Greed pays, and is affordable, up to so many.
constexpr int kGreedyDimensions = 8;
constexpr Index kGreedySites = 2048;
constexpr std::size_t kPointsPerGrain = 1024;
constexpr int kReseatings = 24;

/// As many points as wanted, or all.
Index sample_size(std::int64_t wanted, Index points) {
  return static_cast<Index>(std::min<std::int64_t>(points, wanted));
}

}  // namespace

std::vector<double> plus_plus(PointsView<float> points, Index sites, std::uint64_t seed,
                              std::uint64_t stream, const Arena& arena) {
  const int dimension = points.dimension;
  const Index count = points.count;
  const Index step = std::max<Index>(kernels::product_points(), 64);
  const Index stride = (count + step - 1) / step * step;
  Eigen::MatrixXf block = Eigen::MatrixXf::Zero(stride, dimension);
  block.topRows(count) = as_matrix(points).transpose();
  Eigen::VectorXf squared = Eigen::VectorXf::Zero(stride);
  squared.head(count).setConstant(std::numeric_limits<float>::max());
  Eigen::VectorXd sum(count);
  std::vector<double> result;
  double* const last = sum.data() + count - 1;
  Random random(seed, stream);
  // Several draws pay where distances are cheap.
  const int draws = dimension <= kGreedyDimensions ? 2 + static_cast<int>(std::log(sites)) : 1;
  for (Index s = 0; s < sites; ++s) {
    arena.check();
    Index chosen = random.index_below(count);
    if (s > 0) {
      std::transform_inclusive_scan(squared.data(), squared.data() + count, sum.data(),
                                    std::plus<>(), [](float x) -> double { return x; });
      if (*last > 0) {
        double least = std::numeric_limits<double>::infinity();
        for (int draw = 0; draw < draws; ++draw) {
          const double at = random.uniform() * *last;
          const auto p = static_cast<Index>(std::upper_bound(sum.data(), last, at) - sum.data());
          const double left = draws == 1
                                  ? 0
                                  : kernels::lowered_sum(block.data(), stride, count, dimension,
                                                         points[p], squared.data());
          if (left < least) {
            least = left;
            chosen = p;
          }
        }
      }
    }
    kernels::lower_squares(block.data(), stride, dimension, points[chosen], squared.data());
    result.insert(result.end(), points[chosen], points[chosen] + dimension);
  }
  return result;
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
      squared[p] = std::min(squared[p], squared_difference(x, site, points.dimension));
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

template <class Scalar>
double sampled_energy(const Vectors<Scalar>& points, const std::vector<double>& sites,
                      std::uint64_t seed, const Arena& arena) {
  const std::vector<double> weights = no_weights(sites, points.dimension());
  const std::int64_t few = 4 * std::ssize(weights);
  const Index count = sample_size(std::max(kLeastSample, few), points.count());
  const Points<Scalar> sample =
      points.chosen(draw_distinct(count, points.count(), seed, streams::codebook_sample));
  const Metric metric(points.dimension(), Domain());
  const PointsView<Scalar> view = view_points(sample);
  std::vector<Index> owners = nearest_owners(metric, view, sites, arena);
  return Pricer<Scalar>(metric, view, arena).price({sites, weights}, owners).energy;
}

template <class Scalar>
std::vector<double> seed_sites(const Vectors<Scalar>& points, Index sites, int restarts,
                               std::uint64_t seed, const Arena& arena) {
  const bool in_rounds =
      sites > kFewSites && (points.dimension() > kGreedyDimensions || sites > kGreedySites);
  const std::int64_t each = in_rounds ? kSmallSamplePerSite : kSamplePerSite;
  const std::int64_t wanted = std::max(kLeastSample, each * sites);
  if (restarts == 0) restarts = in_rounds ? 1 : kRestarts;
  const Index count = sample_size(wanted, points.count());
  const Sample sample =
      points.sample(draw_distinct(count, points.count(), seed, streams::codebook_sample));
  const PointsView<float> view = view_points(sample.points);
  const Metric metric(points.dimension(), Domain());
  Seeds best;
  best.energy = std::numeric_limits<double>::infinity();
  Seeds seeds;
  try {
    std::uint64_t stream = streams::codebook_restarts;
    for (int r = 0; r < restarts; ++r, ++stream) {
      seeds = {};
      RoughLloyd lloyd(metric, view, sites, arena);
      seeds.sites = in_rounds ? plus_plus_in_rounds(view, sites, seed, stream, arena)
                              : plus_plus(view, sites, seed, stream, arena);
      seeds.owners = nearest_owners(metric, view, seeds.sites, arena);
      lloyd.relax(seeds);
      for (int k = 0; k < kReseatings; ++k) {
        Seeds changed = seeds;
        if (!reseat_sites(view, changed.owners, changed.sites, arena)) break;
        lloyd.relax(changed);
        if (changed.energy >= seeds.energy * (1 - RoughLloyd::kRough)) break;
        seeds = std::move(changed);
      }
      if (seeds.energy < best.energy) best = std::move(seeds);
    }
  } catch (const Stopped&) {
    if (best.sites.empty()) best.sites = std::move(seeds.sites);
    for (const Index p :
         draw_distinct(best.sites.empty() ? sites : 0, count, seed, streams::codebook_sample)) {
      best.sites.insert(best.sites.end(), view[p], view[p] + view.dimension);
    }
  }
  sample.take_back(best.sites);
  return best.sites;
}

template <class Scalar>
std::vector<double> draw_sites(const Vectors<Scalar>& points, Index sites, int restarts,
                               std::uint64_t seed, const Arena& arena) {
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  std::uint64_t stream = streams::codebook_seeding;
  if (restarts == 0) restarts = kRestarts;
  for (int r = 0; r < restarts; ++r, stream += 256) {
    const Points<Scalar> chosen = points.chosen(draw_distinct(sites, points.count(), seed, stream));
    std::vector<double> drawn(chosen.data(), chosen.data() + chosen.size());
    if (restarts == 1) return drawn;
    if (r == 0) best = drawn;
    try {
      const double energy = sampled_energy(points, drawn, seed, arena);
      if (energy >= least) continue;
      least = energy;
    } catch (const Stopped&) {
      break;
    }
    best = std::move(drawn);
  }
  return best;
}

template double sampled_energy(const Vectors<float>&, const std::vector<double>&, std::uint64_t,
                               const Arena&);
template double sampled_energy(const Vectors<double>&, const std::vector<double>&, std::uint64_t,
                               const Arena&);
template std::vector<double> draw_sites(const Vectors<float>&, Index, int, std::uint64_t,
                                        const Arena&);
template std::vector<double> draw_sites(const Vectors<double>&, Index, int, std::uint64_t,
                                        const Arena&);
template std::vector<double> seed_sites(const Vectors<float>&, Index, int, std::uint64_t,
                                        const Arena&);
template std::vector<double> seed_sites(const Vectors<double>&, Index, int, std::uint64_t,
                                        const Arena&);

}  // namespace ccvt
