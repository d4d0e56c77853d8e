#include "relax/relaxer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "parallel/together.h"
#include "relax/all_pairs.h"
#include "relax/loans.h"
#include "relax/site_records.h"
#include "relax/update.h"
#include "schedule/lending.h"

namespace ccvt {
namespace {

/// A worker looks whether to stop after so many points.
constexpr Index kPointsBetweenChecks = 1 << 16;

}  // namespace

template <class Scalar>
Relaxer<Scalar>::Relaxer(const Metric& metric, const Options& options, const Arena& arena,
                         Stop& stop, std::span<const Index> sizes, double coordinate_bound)
    : metric_(metric),
      options_(options),
      arena_(arena),
      stop_(stop),
      workers_(arena, {PairSwapper<Scalar>(metric, options, coordinate_bound), {}, {}, 0}),
      patches_(metric.dimension(), sizes),
      bands_(patches_.any() ? sizes.size() : 0),
      screen_(metric) {
  changed_.assign(sizes.size(), 0);
  touched_.assign(changed_.size(), 1);
}

template <class Scalar>
PassCount Relaxer<Scalar>::step(LevelState<Scalar>& state) {
  const bool full = cache_.empty() || cached_passes_ >= options_.cached_passes;
  for (int w = 0; w < arena_.threads(); ++w) {
    workers_[w].count = {};
    workers_[w].swapped.clear();
  }
  const auto sites = static_cast<std::int64_t>(state.cells.site_count());
  cells_are_large_ =
      patches_.any() && patches_.divides(static_cast<Index>(state.cells.point_count() / sites));
  if (touched_tile_.empty()) touched_tile_.assign(state.tiling.count(), 1);
  if (state.tiling.ranks() != nullptr) loans_.begin(state.tiling);
  cached_passes_ = full ? 0 : cached_passes_ + 1;
  try {
    bands_.begin_pass(arena_);
    if (full) {
      full_pass(state);
    } else {
      run(schedule_pairs(cache_, state.tiling, arena_), state.tiling, false, state);
    }
  } catch (const Stopped&) {
    stopped_ = true;
    forget_pairs();
  } catch (...) {
    if (state.tiling.ranks() != nullptr) throw;  // others wait for messages, and are ended
    // Swaps have been made: whoever goes on must find the sites where their cells are. What is
    // known of these may lack the last one.
    forget_pairs();
    patches_.forget();
    bands_.forget();
    std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
    const Stop::Pause pause(stop_);
    update_all(metric_, state, arena_);
    throw;
  }
  // What is left takes a pass over the cells that have changed.
  if (stopped_) stop_.off();
  PassCount result = count(full, state.tiling);
  const Stop::Pause pause(stop_);
  result.active_sites = update_changed(state, full && !stopped_);
  stable_ = full && !stopped_ && result.swaps == 0;
  return result;
}

/// Each pair that may gain comes from the cheapest source that has it.
template <class Scalar>
void Relaxer<Scalar>::full_pass(LevelState<Scalar>& state) {
  if (options_.pairs == PairSelection::all) {
    return run(AllPairs(state.tiling), state.tiling, true, state);
  }
  if (lists_.refresh(metric_, state.sites, state.tiling, arena_)) {
    for (const Schedule* schedule : lists_.schedules()) run(*schedule, state.tiling, true, state);
    return;
  }
  if (!screening_pays(metric_)) return run(AllPairs(state.tiling), state.tiling, true, state);
  const Buffer<Pair> pairs =
      screen_.gaining(state.cells, state.sites, touched_, state.tiling, arena_);
  // The greedy rule packs few pairs well, but takes too long for many.
  const std::size_t sites = state.sites.count();
  const bool many = pairs.size() > 8 * sites;
  const Tiling ones = state.tiling.of_single_sites();
  run(many ? schedule_rounds(pairs, sites, arena_) : schedule_pairs(pairs, ones, arena_), ones,
      false, state);
}

/// Swaps all pairs of a source, batch by batch; its tasks are of this tiling. In a full pass, of
/// pairs that meet, those of two sites that have not changed are left out, and so are whole tasks
/// between tiles without a changed site.
template <class Scalar>
template <class Source>
void Relaxer<Scalar>::run(Source&& source, const Tiling& tiling, bool full,
                          LevelState<Scalar>& state) {
  const auto charge = arena_.phase(Phase::swap);
  const bool all = options_.pairs == PairSelection::all;
  const bool of_touched = full && !all;
  const auto touched = [](const std::vector<std::uint8_t>& flags, auto a, auto b) {
    return (flags[a] | flags[b]) != 0;
  };
  const auto for_pairs = [&](const Schedule::Task& task, const auto& visit) {
    if (of_touched && !touched(touched_tile_, task.a, task.b)) return;
    source.for_pairs(task, [&](SiteNumber i, SiteNumber j) {
      if (!of_touched || touched(touched_, i, j)) visit(i, j);
    });
  };
  const auto meet = [&](SiteNumber i, SiteNumber j) {
    return PairSwapper<Scalar>::spheres_meet(metric_, state.sites, i, j);
  };
  const auto relax = [&](const Schedule::Task& task, int w) {
    Worker& worker = workers_[w];
    const auto look = [&](SiteNumber i, SiteNumber j) {
      if (all || meet(i, j)) examine(state, worker, i, j);
    };
    if (!cells_are_large_) return for_pairs(task, look);
    PairsAhead<Scalar> ahead(bands_, patches_, state.cells);
    for_pairs(task, [&](SiteNumber i, SiteNumber j) { ahead.push(i, j, meet(i, j), look); });
    ahead.finish(look);
  };
  const RelaxedLender lender{
      state, tiling, patches_, changed_, loans_, for_pairs, of_touched ? &touched_tile_ : nullptr};
  run_batches(arena_, tiling, source, lender, relax, [this] { return !cancelled(); });
}

template <class Scalar>
void Relaxer<Scalar>::examine(LevelState<Scalar>& state, Worker& worker, SiteNumber i,
                              SiteNumber j) {
  worker.streamed += state.cells.size(i) / 2 + state.cells.size(j) / 2;
  if (worker.streamed > kPointsBetweenChecks) {
    worker.streamed = 0;
    arena_.check();
  }
  ++worker.count.pairs;
  // What is known of all pairs of sites would take too much memory.
  const bool may_be_known = options_.pairs != PairSelection::all ||
                            PairSwapper<Scalar>::spheres_meet(metric_, state.sites, i, j);
  const std::int64_t exchanged =
      worker.swap(state.cells, patches_, state.sites, i, j, may_be_known ? &bands_ : nullptr);
  const auto [sorted_i, sorted_j] = worker.swap.sorted();
  if (sorted_i) loans_.note_sorting(i);
  if (sorted_j) loans_.note_sorting(j);
  if (exchanged == 0) return;
  changed_[i] = changed_[j] = 1;
  loans_.note_change(i, worker.swap.moved().from_i);
  loans_.note_change(j, worker.swap.moved().from_j);
  ++worker.count.swaps;
  worker.count.exchanged += 2 * exchanged;
  if (options_.cached_passes > 0) worker.swapped.emplace_back(i, j);
}

/// Adds up what the workers have done, and keeps the pairs that swapped for the next pass.
template <class Scalar>
PassCount Relaxer<Scalar>::count(bool full, const Tiling& tiling) {
  PassCount count;
  count.full = full;
  count.stopped = stopped_;
  cache_.clear();
  for (int w = 0; w < arena_.threads(); ++w) {
    const Worker& worker = workers_[w];
    count.pairs += worker.count.pairs;
    count.swaps += worker.count.swaps;
    count.exchanged += worker.count.exchanged;
    cache_.insert(cache_.end(), worker.swapped.begin(), worker.swapped.end());
  }
  Ranks* const ranks = tiling.ranks();
  const auto totals = summed(ranks, std::vector{count.pairs, count.swaps, count.exchanged});
  count.pairs = totals[0];
  count.swaps = totals[1];
  count.exchanged = totals[2];
  if (options_.cached_passes > 0) cache_ = joined(ranks, std::move(cache_));
  // Which worker met a pair is chance; the schedule must not depend on it.
  std::sort(cache_.begin(), cache_.end());
  return count;
}

/// Moves the sites whose cells have changed, and notes them for the next full pass. How many.
template <class Scalar>
Index Relaxer<Scalar>::update_changed(LevelState<Scalar>& state, bool full) {
  const auto charge = arena_.phase(Phase::update);
  PerWorker<Index> active(arena_);
  for_each_tile(arena_, state.tiling, [&](Tile tile, int) {
    for (const SiteNumber site : state.tiling.sites_of(tile)) {
      if (changed_[site] == 0 ||
          update_by_sums(metric_, patches_, state.sites, site, state.cells.size(site))) {
        continue;
      }
      update_site(metric_, state.cells, state.sites, site);
      begin_sums(patches_, state.sites, site);
    }
  });
  share_records(state.tiling, state.sites, changed_);
  arena_.for_ranges(state.tiling.count(), 1, [&](std::size_t t, std::size_t, int worker) {
    std::uint8_t any = 0;
    for (const SiteNumber site : state.tiling.sites_of(Tile(t))) {
      const std::uint8_t changed = std::exchange(changed_[site], std::uint8_t{0});
      active[worker] += changed;
      any |= touched_[site] = full ? changed : touched_[site] | changed;
    }
    touched_tile_[Tile(t)] = any;
  });
  Index all = 0;
  for (int w = 0; w < arena_.threads(); ++w) all += active[w];
  return all;
}

/// A pass was left in the middle: what is listed may be incomplete.
template <class Scalar>
void Relaxer<Scalar>::forget_pairs() {
  cache_.clear();
  lists_.forget();
  screen_.forget();
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{1});
  std::fill(touched_tile_.begin(), touched_tile_.end(), std::uint8_t{1});
}

template <class Scalar>
void Relaxer<Scalar>::save(ByteWriter& out, std::span<const Pair> added) const {
  out.put(cached_passes_);
  out.put(cache_);
  out.put(touched_);
  lists_.save(out, added);
}

template <class Scalar>
void Relaxer<Scalar>::load(ByteReader& in, const Tiling& tiling) {
  cached_passes_ = in.get<int>();
  cache_ = in.get_all<Pair>();
  for (const Pair& pair : cache_) {
    if (std::max(pair.first, pair.second) >= touched_.size()) throw Damaged();
  }
  touched_ = in.get_all<std::uint8_t>(touched_.size());
  touched_tile_.assign(tiling.count(), 0);
  for (const SiteNumber site : sites_below(touched_.size())) {
    touched_tile_[tiling.tile_of(site)] |= touched_[site];
  }
  lists_.load(in, metric_, tiling, arena_);
}

template <class Scalar>
void update_all(const Metric& metric, LevelState<Scalar>& state, const Arena& arena) {
  const auto charge = arena.phase(Phase::update);
  for_each_site(arena, state.tiling, [&](SiteNumber site) {
    // Of another cell than this, perhaps.
    state.sites.radius[site] = std::numeric_limits<double>::infinity();
    update_site(metric, state.cells, state.sites, site);
  });
  if (state.tiling.ranks() == nullptr) return;
  std::vector<std::uint8_t> all(state.sites.count(), 1);
  share_records(state.tiling, state.sites, all);
}

template class Relaxer<float>;
template class Relaxer<double>;
template void update_all(const Metric&, LevelState<float>&, const Arena&);
template void update_all(const Metric&, LevelState<double>&, const Arena&);

}  // namespace ccvt
