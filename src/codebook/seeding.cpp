#include "codebook/seeding.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "codebook/plus_plus.h"
#include "codebook/reseat.h"
#include "codebook/rough_lloyd.h"
#include "codebook/sample.h"
#include "exact/centroids.h"
#include "exact/pricing.h"
#include "streams.h"

namespace ccvt {
namespace {

/// The sample has this many points a site, and no fewer than kLeastSample.
constexpr std::int64_t kSamplePerSite = 64;
constexpr std::int64_t kSmallSamplePerSite = 16;  ///< where sites are drawn in rounds
constexpr std::int64_t kLeastSample = 8192;
/// Greed is affordable for so many at most.
constexpr Index kGreedySites = 2048;
constexpr int kReseatings = 24;
/// Restarts whose sites are drawn together: but for the first, so that a stop soon finds it done.
constexpr std::size_t kTogether = 8;

/// As many points as wanted, or all.
Index sample_size(std::int64_t wanted, Index points) {
  return static_cast<Index>(std::min<std::int64_t>(points, wanted));
}

/// Lloyd iterations, and cells merged and split between them as long as that pays.
void improve(PointsView<float> points, const Metric& metric, const Arena& arena, Seeds& seeds) {
  RoughLloyd lloyd(metric, points, static_cast<Index>(std::ssize(seeds.sites)) / points.dimension,
                   arena);
  seeds.owners = nearest_owners(metric, points, seeds.sites, arena);
  lloyd.relax(seeds);
  for (int k = 0; k < kReseatings; ++k) {
    Seeds changed = seeds;
    if (!reseat_sites(points, changed.owners, changed.sites, arena)) break;
    lloyd.relax(changed);
    if (changed.energy >= seeds.energy * (1 - RoughLloyd::kRough)) break;
    seeds = std::move(changed);
  }
}

}  // namespace

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
  if (restarts == 0) restarts = sites > kFewSites ? 1 : kRestarts;
  const Index count = sample_size(wanted, points.count());
  const Sample sample =
      points.sample(draw_distinct(count, points.count(), seed, streams::codebook_sample));
  const PointsView<float> view = view_points(sample.points);
  const Metric metric(points.dimension(), Domain());
  Seeds best;
  best.energy = std::numeric_limits<double>::infinity();
  Seeds seeds;
  try {
    std::vector<std::vector<double>> drawn;  // for the next restarts, the last of them first
    const auto seedings = static_cast<std::uint64_t>(restarts);
    for (std::uint64_t r = 0; r < seedings; ++r) {
      if (in_rounds) {
        drawn = {plus_plus_in_rounds(view, sites, seed, streams::codebook_restarts + r, arena)};
      } else if (drawn.empty()) {
        std::vector<std::uint64_t> next(r == 0 ? 1 : std::min(kTogether, seedings - r));
        std::iota(next.begin(), next.end(), streams::codebook_restarts + r);
        drawn = plus_plus(view, sites, seed, next, arena);
        std::reverse(drawn.begin(), drawn.end());
      }
      seeds = {std::move(drawn.back()), {}, 0};
      drawn.pop_back();
      improve(view, metric, arena, seeds);
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
