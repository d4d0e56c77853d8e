#include "weighted/whole.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "relax/site_graph.h"
#include "relax/update.h"
#include "weighted/settle.h"

namespace ccvt {
namespace {

/// Passes in which neighbouring cells even out their errors, before and after they are settled.
constexpr int kPasses = 12;
constexpr std::size_t kSitesPerGrain = 16;

}  // namespace

template <class Scalar>
WholePoints<Scalar>::WholePoints(MassCells<Scalar>& cells, const Arena& arena, Stop& stop)
    : cells_(cells), arena_(arena), stop_(stop), scratch_(arena), changed_(cells.site_count(), 1) {}

/// Calls visit(pair, worker) for each, those without a common site at the same time.
template <class Scalar>
template <class Visit>
void WholePoints<Scalar>::for_pairs(const std::vector<Pair>& pairs, const Visit& visit) {
  const Tiling tiling(cells_.site_count(), 1);
  const Schedule schedule = schedule_pairs(pairs, tiling, arena_);
  schedule.run(arena_, tiling, [&](const Schedule::Task& task, int worker) {
    for (const Pair& pair : schedule.pairs_of(task)) visit(pair, worker);
  });
}

/// Moves the sites of changed cells; returns how many there are.
template <class Scalar>
Index WholePoints<Scalar>::update() {
  for_each_site(arena_, changed_.size(), kSitesPerGrain, [&](SiteNumber s) {
    if (changed_[s] != 0) cells_.update(s);
  });
  return std::accumulate(changed_.begin(), changed_.end(), Index{0});
}

/// One pass over these pairs. Returns whether anything has changed.
template <class Scalar>
bool WholePoints<Scalar>::even_out(const std::vector<Pair>& pairs) {
  std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
  for_pairs(pairs, [&](const Pair& pair, int worker) {
    const auto [i, j] = pair;
    if (scratch_[worker].even_out(cells_, i, j)) changed_[i] = changed_[j] = 1;
  });
  return update() > 0;
}

template <class Scalar>
bool WholePoints<Scalar>::settled() const {
  double largest = 0;
  for (const SiteNumber s : cells_.sites().all()) {
    largest = std::max(largest, std::abs(cells_.error(s)));
  }
  return largest < cells_.error_bound();
}

template <class Scalar>
void WholePoints<Scalar>::balance() {
  const bool hurried = stop_.requested();
  const Stop::Pause pause(stop_);
  const std::vector<Pair> pairs = near_.side_by_side(cells_.metric(), cells_.sites(), arena_);
  const auto passes = [&] {
    for (int pass = 0; pass < kPasses && !(hurried && settled()) && even_out(pairs); ++pass) {
    }
  };
  passes();
  if (!settled()) {
    settle(cells_, SiteGraph(cells_.site_count(), pairs, arena_));
    std::fill(changed_.begin(), changed_.end(), std::uint8_t{1});
    update();
    passes();
  }
  std::fill(changed_.begin(), changed_.end(), std::uint8_t{1});
}

/// Whether the bounding spheres do.
template <class Scalar>
bool WholePoints<Scalar>::meet(const Pair& pair) const {
  constexpr double kRounding = 1 + 1e-12;
  const SiteState& sites = cells_.sites();
  const double both = sites.radius[pair.first] + sites.radius[pair.second];
  return cells_.metric().squared_distance(sites.at(pair.first), sites.at(pair.second)) <=
         both * both * kRounding;
}

template <class Scalar>
typename WholePoints<Scalar>::Sweep WholePoints<Scalar>::sweep() {
  Sweep done;
  std::vector<Pair> pairs;
  const std::vector<std::uint8_t> before =
      std::exchange(changed_, std::vector<std::uint8_t>(changed_.size(), 0));
  struct Count {
    std::int64_t pairs = 0;
    std::int64_t swaps = 0;
    std::int64_t exchanged = 0;
  };
  PerWorker<Count> counts(arena_);
  try {
    for (const Pair& pair : near_.list(cells_.metric(), cells_.sites(), arena_)) {
      if ((before[pair.first] != 0 || before[pair.second] != 0) && meet(pair))
        pairs.push_back(pair);
    }
    for_pairs(pairs, [&](const Pair& pair, int worker) {
      const auto [i, j] = pair;
      const Index moved = scratch_[worker].improve(cells_, i, j);
      Count& count = counts[worker];
      ++count.pairs;
      if (moved == 0) return;
      ++count.swaps;
      count.exchanged += moved;
      changed_[i] = changed_[j] = 1;
    });
  } catch (const Stopped&) {
    done.stopped = true;
  }
  for (int w = 0; std::cmp_less(w, counts.size()); ++w) {
    done.pairs += counts[w].pairs;
    done.swaps += counts[w].swaps;
    done.exchanged += counts[w].exchanged;
  }
  const Stop::Pause pause(stop_);
  done.changed = update();
  done.energy = energy();
  return done;
}

template <class Scalar>
double WholePoints<Scalar>::energy() const {
  const Stop::Pause pause(stop_);
  return total_energy(cells_.sites(), arena_);
}

template class WholePoints<float>;
template class WholePoints<double>;

}  // namespace ccvt
