#include "relax/relaxer.h"

#include <algorithm>
#include <limits>

#include "relax/screen.h"
#include "relax/update.h"

namespace ccvt {
namespace {

/// Tasks handed to a worker at once: about as many pairs as make its start negligible.
constexpr std::size_t kPairsPerGrain = 64;
/// Sites updated at once by a worker.
constexpr std::size_t kSitesPerGrain = 64;

/// A worker looks whether to stop after so many points.
constexpr Index kPointsBetweenChecks = 1 << 16;

/// Full passes over all pairs before the list of meeting ones is tried again.
constexpr int kDensePasses = 4;

/// A list of meeting pairs longer than this is not worth having.
std::size_t list_limit(Index sites) {
  const auto n = static_cast<std::size_t>(sites);
  return std::min({n * (n - 1) / 4, 256 * n, static_cast<std::size_t>(INT32_MAX)});
}

}  // namespace

template <class Scalar>
Relaxer<Scalar>::Relaxer(const Metric& metric, const Options& options, const Arena& arena,
                         Stop& stop, Cells<Scalar>& cells, SiteState& sites,
                         double coordinate_bound)
    : metric_(metric), options_(options), arena_(arena), stop_(stop), cells_(cells), sites_(sites) {
  for (int w = 0; w < arena.threads(); ++w) {
    workers_.push_back({PairSwapper<Scalar>(metric, options, coordinate_bound), {}, {}, 0});
  }
  changed_.assign(sites.radius.size(), 0);
  touched_.assign(sites.radius.size(), 1);
}

template <class Scalar>
void Relaxer<Scalar>::update_all() {
  // Of other cells than these, perhaps.
  std::fill(sites_.radius.begin(), sites_.radius.end(), std::numeric_limits<double>::infinity());
  arena_.for_each(sites_.radius.size(), kSitesPerGrain, [&](std::size_t s) {
    update_site(metric_, cells_, sites_, static_cast<Index>(s));
  });
}

/// Whether a pair is worth a look: of those whose spheres meet, in a full pass, one of two sites
/// that have not changed is not.
template <class Scalar>
bool Relaxer<Scalar>::may_gain(Index i, Index j, bool full) const {
  if (options_.pairs == PairSelection::all) return true;
  const auto a = static_cast<std::size_t>(i);
  const auto b = static_cast<std::size_t>(j);
  if (full && (touched_[a] | touched_[b]) == 0) return false;
  return PairSwapper<Scalar>::spheres_meet(metric_, sites_, i, j);
}

template <class Scalar>
void Relaxer<Scalar>::examine(Worker& worker, Index i, Index j) {
  worker.streamed += cells_.size(i) / 2 + cells_.size(j) / 2;
  if (worker.streamed > kPointsBetweenChecks) {
    worker.streamed = 0;
    arena_.check();
  }
  ++worker.count.pairs;
  const Index exchanged = worker.swap(cells_, sites_, i, j);
  if (exchanged == 0) return;
  changed_[static_cast<std::size_t>(i)] = changed_[static_cast<std::size_t>(j)] = 1;
  ++worker.count.swaps;
  worker.count.exchanged += 2 * static_cast<std::int64_t>(exchanged);
  if (options_.cached_passes > 0) worker.swapped.emplace_back(i, j);
}

/// Runs a schedule. In a full pass, pairs of two sites that have not changed are left out, and so
/// are whole tasks between tiles without a changed site.
template <class Scalar>
void Relaxer<Scalar>::run(const Schedule& schedule, bool full) {
  const Pair* const pairs = schedule.pairs.data();
  const auto touches = [&](const Pair& pair) {
    return (touched_tile_[static_cast<std::size_t>(pair.first / options_.tile_sites)] |
            touched_tile_[static_cast<std::size_t>(pair.second / options_.tile_sites)]) != 0;
  };
  for (std::size_t b = 0; b < schedule.batch_count() && !cancelled(); ++b) {
    const auto tasks = schedule.batch(b);
    const auto count = static_cast<std::size_t>(tasks.back().end - tasks.front().begin);
    const std::size_t grain = std::max<std::size_t>(1, kPairsPerGrain * tasks.size() / count);
    arena_.for_ranges(tasks.size(), grain, [&](std::size_t begin, std::size_t end, int w) {
      Worker& worker = workers_[static_cast<std::size_t>(w)];
      for (std::size_t t = begin; t < end; ++t) {
        if (full && !touches(pairs[tasks[t].begin])) continue;
        for (std::int64_t p = tasks[t].begin; p < tasks[t].end; ++p) {
          const auto [i, j] = pairs[p];
          if (may_gain(i, j, full)) examine(worker, i, j);
        }
      }
    });
  }
}

/// Every pair, in the rounds of a tournament between tiles; pairs inside tiles come first.
template <class Scalar>
void Relaxer<Scalar>::all_pairs_pass() {
  const Index n = sites_.count();
  const Index tile = std::min(options_.tile_sites, n);
  const Index tiles = n / tile + (n % tile != 0 ? 1 : 0);
  const auto last = [&](Index t) { return n - t * tile > tile ? (t + 1) * tile : n; };
  const auto grain = std::max<std::size_t>(
      1, kPairsPerGrain / (static_cast<std::size_t>(tile) * static_cast<std::size_t>(tile)));
  const auto visit = [&](int w, Index i, Index j) {
    if (may_gain(i, j, true)) examine(workers_[static_cast<std::size_t>(w)], i, j);
  };
  if (tile > 1 && !cancelled()) {
    arena_.for_ranges(static_cast<std::size_t>(tiles), 1,
                      [&](std::size_t begin, std::size_t end, int w) {
                        for (auto t = static_cast<Index>(begin); t < static_cast<Index>(end); ++t) {
                          for (Index i = t * tile; i < last(t); ++i) {
                            for (Index j = i + 1; j < last(t); ++j) {
                              visit(w, i, j);
                            }
                          }
                        }
                      });
  }
  std::vector<Pair> round;
  for (Index r = 0; r < tiles && !cancelled(); ++r) {
    round.clear();
    round_robin(tiles, r, [&](Index a, Index b) { round.emplace_back(a, b); });
    arena_.for_ranges(round.size(), grain, [&](std::size_t begin, std::size_t end, int w) {
      for (std::size_t k = begin; k < end; ++k) {
        const auto [a, b] = round[k];
        for (Index i = a * tile; i < last(a); ++i) {
          for (Index j = b * tile; j < last(b); ++j) {
            visit(w, i, j);
          }
        }
      }
    });
  }
}

template <class Scalar>
void Relaxer<Scalar>::screened_pass() {
  const auto pairs = gaining_pairs(metric_, cells_, sites_, touched_, arena_);
  if (pairs.empty()) return;
  // The greedy rule packs few pairs well, but takes too long for many.
  const bool many = pairs.size() > 8 * static_cast<std::size_t>(sites_.count());
  run(many ? schedule_rounds(pairs, sites_.count()) : schedule_pairs(pairs, sites_.count(), 1),
      false);
}

/// Brings the list of pairs and its schedules up to date.
template <class Scalar>
void Relaxer<Scalar>::list_pairs() {
  const auto schedule = [&](std::span<const Pair> pairs) {
    return schedule_pairs(pairs, sites_.count(), options_.tile_sites);
  };
  switch (meeting_.refresh(metric_, sites_, arena_, list_limit(sites_.count()))) {
    case MeetingPairs::Refreshed::unchanged:
      break;
    case MeetingPairs::Refreshed::extended:
      added_schedule_ = schedule(meeting_.added());
      break;
    case MeetingPairs::Refreshed::rebuilt:
      dense_ = false;
      schedule_ = schedule(meeting_.pairs());
      added_schedule_ = {};
      break;
    case MeetingPairs::Refreshed::too_many:
      dense_ = true;
      break;
  }
}

template <class Scalar>
void Relaxer<Scalar>::full_pass() {
  if (options_.pairs == PairSelection::all) return all_pairs_pass();
  // Spheres shrink as the relaxation goes on: a list may pay by now.
  const bool retry = dense_ && !screening_pays(metric_) && ++dense_passes_ % kDensePasses == 0;
  if (!dense_ || retry) list_pairs();
  if (!dense_) {
    const Index tiles = sites_.count() / options_.tile_sites + 1;
    touched_tile_.assign(static_cast<std::size_t>(tiles), 0);
    for (std::size_t s = 0; s < touched_.size(); ++s) {
      touched_tile_[s / static_cast<std::size_t>(options_.tile_sites)] |= touched_[s];
    }
    run(schedule_, true);
    run(added_schedule_, true);
    return;
  }
  if (screening_pays(metric_)) return screened_pass();
  all_pairs_pass();
}

template <class Scalar>
void Relaxer<Scalar>::cached_pass() {
  const Schedule cached = schedule_pairs(cache_, sites_.count(), options_.tile_sites);
  run(cached, false);
}

/// Moves the sites whose cells have changed, and notes them for the next full pass.
template <class Scalar>
void Relaxer<Scalar>::update_changed(bool full) {
  arena_.for_each(changed_.size(), kSitesPerGrain, [&](std::size_t s) {
    if (changed_[s] != 0) update_site(metric_, cells_, sites_, static_cast<Index>(s));
  });
  for (std::size_t s = 0; s < changed_.size(); ++s) {
    touched_[s] = full ? changed_[s] : touched_[s] | changed_[s];
  }
}

template <class Scalar>
void Relaxer<Scalar>::pass(bool full) {
  if (full) {
    full_pass();
    cached_passes_ = 0;
  } else {
    cached_pass();
    ++cached_passes_;
  }
}

/// A pass was left in the middle: what is listed may be incomplete.
template <class Scalar>
void Relaxer<Scalar>::forget_pairs() {
  cache_.clear();
  meeting_.forget();
  schedule_ = {};
  added_schedule_ = {};
  dense_ = false;
  std::fill(touched_.begin(), touched_.end(), std::uint8_t{1});
}

template <class Scalar>
PassCount Relaxer<Scalar>::step() {
  const bool full = cache_.empty() || cached_passes_ >= options_.cached_passes;
  for (Worker& worker : workers_) {
    worker.count = {};
    worker.swapped.clear();
  }
  std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
  try {
    pass(full);
  } catch (const Stopped&) {
    stopped_ = true;
    forget_pairs();
  } catch (...) {
    // Swaps have been made: whoever goes on must find the sites where their cells are.
    forget_pairs();
    const Stop::Pause pause(stop_);
    update_all();
    throw;
  }
  // What is left takes a pass over the cells that have changed.
  if (stopped_) stop_.off();
  PassCount count;
  count.full = full;
  count.stopped = stopped_;
  cache_.clear();
  for (const Worker& worker : workers_) {
    count.pairs += worker.count.pairs;
    count.swaps += worker.count.swaps;
    count.exchanged += worker.count.exchanged;
    cache_.insert(cache_.end(), worker.swapped.begin(), worker.swapped.end());
  }
  // Which worker met a pair is chance; the schedule must not depend on it.
  std::sort(cache_.begin(), cache_.end());
  count.active_sites =
      static_cast<Index>(std::count(changed_.begin(), changed_.end(), std::uint8_t{1}));
  const Stop::Pause pause(stop_);
  update_changed(full && !stopped_);
  stable_ = full && !stopped_ && count.swaps == 0;
  return count;
}

template <class Scalar>
std::vector<Pair> Relaxer<Scalar>::listed() const {
  std::vector<Pair> all(meeting_.pairs().begin(), meeting_.pairs().end());
  all.insert(all.end(), meeting_.added().begin(), meeting_.added().end());
  return all;
}

template class Relaxer<float>;
template class Relaxer<double>;

}  // namespace ccvt
