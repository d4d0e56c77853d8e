// The kernels of the core on Google Benchmark, beside what the machine can do: bytes per second
// against "memory/read" and "memory/copy", flops against "flops". Run with
// --benchmark_format=json for a file.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "geometry/metric.h"
#include "kernels/keys.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/filling.h"
#include "relax/initial_sites.h"
#include "relax/initialize.h"
#include "relax/meeting_pairs.h"
#include "relax/nearest_sites.h"
#include "relax/screen.h"
#include "relax/swap.h"
#include "relax/update.h"
#include "schedule/schedule.h"
#include "spatial/site_tree.h"

namespace ccvt::bench {
namespace {

/// A start as the solver makes it: points in cells around their sites, on the unit torus in few
/// dimensions.
struct Start {
  Start(int dimension, Index count, Index points_per_site)
      : points(sample_uniform<float>(Box::unit(dimension), count * points_per_site, 1,
                                     Distribution::white)),
        problem(points, count),
        metric(dimension, dimension <= 3 ? Domain::periodic(Box::unit(dimension)) : Domain()),
        sites(initial_sites(problem, metric, 1)),
        cells(dimension, problem.capacities()),
        all(static_cast<std::size_t>(points.cols())) {
    std::iota(all.begin(), all.end(), PointNumber(0));
    Filling<float> filling(cells, problem.points());
    join_balanced(metric, sites, Box::unit(dimension), JoiningPoints::between(0, all.size()), {},
                  arena, filling);
    for (const SiteNumber s : sites.all()) update_site(metric, cells, sites, s);
    MeetingPairs meeting;
    const auto limit = static_cast<std::size_t>(count) * static_cast<std::size_t>(count);
    meeting.refresh(metric, sites, {count, 1}, arena, limit);
    pairs.assign(meeting.pairs().begin(), meeting.pairs().end());
  }

  Arena arena{1};
  Points<float> points;
  Problem<float> problem;
  Metric metric;
  SiteState sites;
  Cells<float> cells;
  std::vector<PointNumber> all;
  std::vector<Pair> pairs;
};

constexpr Index kSites = 1024;
constexpr Index kPointsPerSite = 256;

void count_points(benchmark::State& state, std::int64_t points, int dimension) {
  state.SetItemsProcessed(state.iterations() * points);
  state.SetBytesProcessed(state.iterations() * points * dimension *
                          static_cast<std::int64_t>(sizeof(float)));
}

/// The machine: reading more memory than any cache holds.
void memory_read(benchmark::State& state) {
  const std::vector<std::uint64_t> block(std::size_t{1} << 25, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(std::accumulate(block.begin(), block.end(), std::uint64_t{0}));
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(block.size() * 8));
}
BENCHMARK(memory_read)->Name("memory/read")->Unit(benchmark::kMillisecond);

void memory_copy(benchmark::State& state) {
  const std::vector<std::uint64_t> from(std::size_t{1} << 24, 1);
  std::vector<std::uint64_t> to(from.size());
  for (auto _ : state) {
    std::copy(from.begin(), from.end(), to.begin());
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(2 * from.size() * 8));
}
BENCHMARK(memory_copy)->Name("memory/copy")->Unit(benchmark::kMillisecond);

/// The machine: float products and sums in registers, by the widest vectors that the library's own
/// kernels dispatch to: 64 dimensions of one cell that stays in the first cache.
void flops(benchmark::State& state) {
  constexpr int kDimension = 64;
  constexpr Index kCount = 64;
  const std::vector<float> block(std::size_t{kDimension} * kCount, 0.5F);
  const std::vector<float> middle(kDimension, 0.25F);
  const std::vector<float> normal(kDimension, 0.125F);
  for (auto _ : state) {
    const kernels::Cut<float> cut{middle.data(), normal.data()};
    benchmark::DoNotOptimize(
        kernels::key_extremes(block.data(), kCount, cut, block.data(), kCount, cut, kDimension));
  }
  // A difference, a product and a sum for each coordinate, twice.
  state.counters["flops"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 6 * kDimension * kCount,
                         benchmark::Counter::kIsRate);
}
BENCHMARK(flops);

/// A pass over the pairs that meet, from a state in which nothing swaps any more: the cost of
/// finding out. Items are points, two cells of them a pair.
void swap_separated(benchmark::State& state) {
  const auto dimension = static_cast<int>(state.range(0));
  Start start(dimension, kSites, kPointsPerSite);
  PairSwapper<float> swap(start.metric, Options{}, 1);
  Patches<float> patches(dimension, start.cells.sizes());
  for (int pass = 0; pass < 200; ++pass) {
    Index exchanged = 0;
    for (const auto& [i, j] : start.pairs) {
      exchanged += swap(start.cells, patches, start.sites, i, j);
    }
    if (exchanged == 0) break;
  }
  for (auto _ : state) {
    for (const auto& [i, j] : start.pairs) {
      benchmark::DoNotOptimize(swap(start.cells, patches, start.sites, i, j));
    }
  }
  count_points(state,
               static_cast<std::int64_t>(start.pairs.size()) * std::int64_t{2} * kPointsPerSite,
               dimension);
  state.counters["pairs"] = static_cast<double>(start.pairs.size());
}
BENCHMARK(swap_separated)->Name("swap/separated")->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

/// The first pass after a start, in which pairs do swap.
void swap_first_pass(benchmark::State& state, SwapMethod method, PointPruning pruning) {
  const Start start(2, kSites, kPointsPerSite);
  Options options;
  options.swap = method;
  options.point_pruning = pruning;
  PairSwapper<float> swap(start.metric, options, 1);
  for (auto _ : state) {
    state.PauseTiming();
    Cells<float> cells = start.cells;
    SiteState sites = start.sites;
    Patches<float> patches(2, cells.sizes());
    state.ResumeTiming();
    for (const auto& [i, j] : start.pairs) {
      benchmark::DoNotOptimize(swap(cells, patches, sites, i, j));
    }
  }
  count_points(state,
               static_cast<std::int64_t>(start.pairs.size()) * std::int64_t{2} * kPointsPerSite, 2);
}
BENCHMARK_CAPTURE(swap_first_pass, median, SwapMethod::median, PointPruning::extremes)
    ->Name("swap/first_pass/median/extremes")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(swap_first_pass, distance, SwapMethod::median, PointPruning::distance)
    ->Name("swap/first_pass/median/distance")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(swap_first_pass, all, SwapMethod::median, PointPruning::none)
    ->Name("swap/first_pass/median/none")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(swap_first_pass, heap, SwapMethod::heap, PointPruning::none)
    ->Name("swap/first_pass/heap/none")
    ->Unit(benchmark::kMillisecond);

/// All pairs by one blocked matrix product, as in many dimensions. Items are pairs of a point and
/// a site; a product and a sum for each of their coordinates.
void screening(benchmark::State& state) {
  const auto dimension = static_cast<int>(state.range(0));
  const Start start(dimension, kSites, 64);
  const std::vector<std::uint8_t> touched(static_cast<std::size_t>(kSites), 1);
  for (auto _ : state) {
    Screen<float> screen(start.metric);
    benchmark::DoNotOptimize(
        screen.gaining(start.cells, start.sites, touched, Tiling(kSites, 1), start.arena));
  }
  const auto products = static_cast<std::int64_t>(start.points.cols()) * kSites;
  state.SetItemsProcessed(state.iterations() * products);
  state.counters["flops"] =
      benchmark::Counter(static_cast<double>(state.iterations() * products) * 2 * dimension,
                         benchmark::Counter::kIsRate);
}
BENCHMARK(screening)->Arg(16)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

/// The nearest of all sites, for every point.
void nearest_sites(benchmark::State& state) {
  const auto dimension = static_cast<int>(state.range(0));
  const Start start(dimension, kSites, kPointsPerSite);
  for (auto _ : state) {
    const NearestSites<float> nearest(start.metric, start.sites, Box::unit(dimension));
    benchmark::DoNotOptimize(nearest.owners(start.problem.points(), start.arena).data());
  }
  count_points(state, start.points.cols(), dimension);
}
BENCHMARK(nearest_sites)->Arg(2)->Arg(3)->Arg(8)->Unit(benchmark::kMillisecond);

/// The nearest site that has room, sites leaving as they fill up [Program 6].
void nearest_available(benchmark::State& state) {
  const auto dimension = static_cast<int>(state.range(0));
  const Start start(dimension, kSites, kPointsPerSite);
  for (auto _ : state) {
    Cells<float> cells(dimension, start.problem.capacities());
    Filling<float> filling(cells, start.problem.points());
    join_coherent(start.metric, start.sites, std::span<const PointNumber>(start.all), 1, filling);
    benchmark::DoNotOptimize(cells.point(SiteNumber(0), 0));
  }
  count_points(state, start.points.cols(), dimension);
}
BENCHMARK(nearest_available)->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

/// Listing and batching the pairs that meet; tiles of one site are the paper's schedule.
void schedule_building(benchmark::State& state) {
  const Start start(2, 4 * kSites, 64);
  for (auto _ : state) {
    benchmark::DoNotOptimize(schedule_pairs(
        start.pairs, Tiling(start.sites.count(), static_cast<Index>(state.range(0)))));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(start.pairs.size()));
}
BENCHMARK(schedule_building)->Arg(1)->Arg(64)->Unit(benchmark::kMillisecond);

void centroid_update(benchmark::State& state) {
  const auto dimension = static_cast<int>(state.range(0));
  Start start(dimension, kSites, kPointsPerSite);
  for (auto _ : state) {
    for (const SiteNumber s : start.sites.all()) {
      update_site(start.metric, start.cells, start.sites, s);
    }
    benchmark::DoNotOptimize(start.sites.energy.data());
  }
  count_points(state, start.points.cols(), dimension);
}
BENCHMARK(centroid_update)->Arg(2)->Arg(3)->Arg(16)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ccvt::bench

BENCHMARK_MAIN();
