// Figure 2: the pairs in each batch that the greedy heuristic makes.

#include <algorithm>
#include <numeric>

#include "ccvt/problem.h"
#include "geometry/metric.h"
#include "paper/experiments.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/filling.h"
#include "relax/initial_sites.h"
#include "relax/initialize.h"
#include "relax/swap.h"
#include "relax/update.h"
#include "schedule/schedule.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

/// The pairs that swapped in a full pass over all pairs of sites that meet, in the order met: what
/// the cached stage starts from [4.2]. Then the centroid update.
std::vector<Pair> swapped_pairs(const Metric& metric, PairSwapper<float>& swap, Cells<float>& cells,
                                SiteState& sites) {
  std::vector<Pair> swapped;
  Patches<float> patches(metric.dimension(), cells.sizes());
  for (std::size_t round = 0; round < sites.count(); ++round) {
    round_robin(sites.count(), round, [&](std::size_t a, std::size_t b) {
      const SiteNumber i(a);
      const SiteNumber j(b);
      if (!PairSwapper<float>::spheres_meet(metric, sites, i, j)) return;
      if (swap(cells, patches, sites, i, j) > 0) swapped.emplace_back(i, j);
    });
  }
  for (const SiteNumber s : sites.all()) update_site(metric, cells, sites, s);
  return swapped;
}

Json batches_of(const std::vector<Pair>& pairs, std::size_t sites) {
  std::vector<double> sizes;
  for (const auto& batch : greedy_batches(pairs, sites)) {
    sizes.push_back(static_cast<double>(batch.size()));
  }
  std::vector<int> degree(sites, 0);
  for (const Pair& pair : pairs) {
    ++degree[pair.first];
    ++degree[pair.second];
  }
  const Spread spread = spread_of(sizes);
  Json json;
  json["pairs"] = pairs.size();
  json["batches"] = sizes.size();
  json["lower_bound"] = *std::max_element(degree.begin(), degree.end());
  json["mean"] = spread.mean;
  json["least"] = spread.least;
  json["most"] = spread.most;
  json["deviation"] = spread.deviation;
  json["sizes"] = sizes;
  return json;
}

}  // namespace

void clusters(const Scale& scale, const std::filesystem::path& directory) {
  const Index count = scale.quick ? 256 : 2048;
  constexpr Index kPointsPerSite = 128;
  constexpr int kPasses = 10;
  constexpr std::uint64_t kSeed = 1;
  Record record("clusters", scale, directory);
  record.json["parameters"] = {{"sites", count},
                               {"points_per_site", kPointsPerSite},
                               {"domain", "unit torus"},
                               {"points", "white noise, float"},
                               {"initialization", "coherent"},
                               {"seed", kSeed}};
  const Points<float> points = white_points({2, count, kPointsPerSite}, kSeed);
  Problem<float> problem(points, count);
  problem.set_domain(Domain::periodic(Box::unit(2)));
  const Metric metric(2, problem.domain());
  SiteState sites = initial_sites(problem, metric, kSeed);
  Cells<float> cells(2, problem.capacities());
  Filling<float> filling(cells, problem.points());
  std::vector<PointNumber> all(static_cast<std::size_t>(points.cols()));
  std::iota(all.begin(), all.end(), PointNumber(0));
  join_coherent(metric, sites, std::span<const PointNumber>(all), kSeed, filling);
  for (const SiteNumber s : sites.all()) update_site(metric, cells, sites, s);

  PairSwapper<float> swap(metric, Options{}, 1);
  for (int pass = 1; pass <= kPasses; ++pass) {
    const auto pairs = swapped_pairs(metric, swap, cells, sites);
    if (pairs.empty()) break;
    Json run = batches_of(pairs, sites.count());
    run["pass"] = pass;
    record.json["runs"].push_back(std::move(run));
  }
  record.save();
}

}  // namespace ccvt::bench
