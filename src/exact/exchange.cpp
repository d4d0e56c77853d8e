#include "exact/exchange.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

#include "exact/grouping.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// All edges of all sites take slots as long as there are no more than this.
constexpr std::size_t kSlots = std::size_t{1} << 16;
constexpr std::size_t kLeastSlots = 64;
/// Searches for so many surplus points look at most sites: their edges are bounded in parallel.
constexpr std::int64_t kSitesPerSurplus = 32;

std::size_t slots_of_each(std::size_t sites) { return std::max(kLeastSlots, kSlots / sites); }

}  // namespace

ExchangeGraph::ExchangeGraph(std::vector<Index>& capacities, bool floating,
                             std::vector<Index>& owners, std::vector<double>& weights,
                             const MoveCosts& costs, CellBounds* kept)
    : capacities_(capacities),
      floating_(floating),
      owners_(owners),
      weights_(weights),
      costs_(costs),
      kept_(kept),
      cells_(capacities.size()),
      own_storage_(kept == nullptr ? owners.size() : 0),
      own_cost_(kept == nullptr ? own_storage_ : kept->own_costs()),
      in_slot_(capacities.size(), 0),
      distance_(capacities.size() + 1, kNone),
      limit_(capacities.size() + 1, kNone),
      way_(capacities.size() + 1) {
  const Grouping groups(owners, cells_.size());
  for (const SiteNumber s : sites_below(cells_.size())) {
    const auto members = groups.of(s);
    cells_[s].members.assign(members.begin(), members.end());
  }
  if (!floating) return;
  least_capacity_ = *std::min_element(capacities.begin(), capacities.end());
  hub_weight_ = kNone;
  double highest = -kNone;
  for (std::size_t s = 0; s < capacities.size(); ++s) {
    if (capacities[s] > least_capacity_) {
      highest = std::max(highest, weights[s]);
    } else {
      hub_weight_ = std::min(hub_weight_, weights[s]);
    }
  }
  // Where all have the same there is nothing to hand on.
  floating_ = highest > -kNone;
}

void ExchangeGraph::bound_all_edges(const Arena& arena) {
  PerWorker<Scratch> scratch(arena);
  arena.for_ranges(cells_.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(begin, end)) {
      arena.check();
      bound_edges(s, slots_of_each(cells_.size()), scratch[worker]);
    }
  });
}

void ExchangeGraph::push(const Step& step) {
  heap_.push_back(step);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

/// Reaches `to`, if that is the shortest way so far.
void ExchangeGraph::relax(const Way& way, SiteNumber to, double distance) {
  if (settled(to) || !(distance < distance_[to])) return;
  if (distance_[to] == kNone) seen_.push_back(to);
  distance_[to] = distance;
  if (to != hub()) limit_[to] = distance + weights_[to];
  way_[to] = way;
  if (to != hub() && surplus(to) < 0) nearest_ = std::min(nearest_, distance);
  push({distance, to, kSite});
}

/// Along an edge of a site; never below `least`, whatever rounding has done to a reduced cost.
void ExchangeGraph::relax_edge(SiteNumber from, std::size_t slot, double least) {
  const Moves& moves = weigh(from, slot);
  if (moves.cheapest.empty()) return;
  const Move& move = moves.cheapest.front();
  const SiteNumber to = cells_[from].to[slot];
  const double base = distance_[from] + weights_[from];
  relax({from, move.point}, to, std::max(least, base + move.cost - weights_[to]));
}

/// The shortest way from `source` to a site with too few points without any other on it: no path
/// longer than that need be looked at.
void ExchangeGraph::reach_directly(SiteNumber source) {
  const Cell& cell = cells_[source];
  const double base = weights_[source];
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    const SiteNumber j = cell.to[slot];
    if (surplus(j) >= 0 || base + cell.bound[slot] - weights_[j] >= nearest_) continue;
    relax_edge(source, slot, 0);
  }
}

/// Along all edges of a site, or of the hub, that are known.
void ExchangeGraph::relax_edges(SiteNumber from, double least) {
  if (from == hub()) {
    const double base = distance_[from] + hub_weight_;
    for (const SiteNumber a : sites_below(cells_.size())) {
      if (has_more(a)) relax({from, kNoPoint}, a, std::max(least, base - weights_[a]));
    }
    return;
  }
  const Cell& cell = cells_[from];
  const double base = distance_[from] + weights_[from];
  for (std::size_t page = 0; page < cell.page.size(); ++page) {
    if (base + cell.page[page] >= nearest_) continue;
    const std::size_t end = std::min((page + 1) * kPage, cell.to.size());
    for (std::size_t slot = page * kPage; slot < end; ++slot) {
      const SiteNumber j = cell.to[slot];
      const double bound = base + cell.bound[slot];
      const double distance = bound - weights_[j];
      if (bound >= limit_[j] || distance >= nearest_) continue;
      if (is_weighed(cell, slot)) {
        relax_edge(from, slot, least);
      } else {
        push({std::max(least, distance), from, static_cast<std::int32_t>(slot)});
      }
    }
  }
  if (floating_ && !has_more(from)) {
    relax({from, kNoPoint}, hub(), std::max(least, base - hub_weight_));
  }
}

/// Shortest paths from `source` up to the first site with too few points, settled_.back(); how far
/// that is.
double ExchangeGraph::find_path(SiteNumber source, const Arena& arena) {
  for (const SiteNumber s : seen_) distance_[s] = limit_[s] = kNone;
  seen_.assign(1, source);
  settled_.clear();
  heap_.clear();
  nearest_ = kNone;
  distance_[source] = 0;
  push({0, source, kSite});
  for (;;) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const Step step = heap_.back();
    heap_.pop_back();
    const SiteNumber i = step.site;
    if (step.what >= 0) {
      // Slots may have changed since: then all edges of the site were pushed again, and this is
      // one of them too many.
      const auto slot = static_cast<std::size_t>(step.what);
      const Cell& cell = cells_[i];
      const bool shorter = step.distance < std::min(nearest_, distance_[cell.to[slot]]);
      if (!shorter || settled(cell.to[slot])) continue;
      if (cell.tight || cell.weighings < costs_.weighings() || is_weighed(cell, slot)) {
        relax_edge(i, slot, step.distance);
        continue;
      }
      arena.check();
      tighten(i);
    } else if (step.what == kRest) {
      arena.check();
      bound_edges(i, 2 * cells_[i].to.size(), scratch_);
    } else {
      if (settled(i)) continue;
      limit_[i] = -kNone;
      settled_.push_back(i);
      if (i != hub()) {
        if (surplus(i) < 0) return step.distance;
        if (!cells_[i].bounded) {
          arena.check();
          bound_edges(i, slots_of_each(cells_.size()), scratch_);
        }
        if (i == source) reach_directly(i);
      }
    }
    relax_edges(i, step.distance);
    if (i == hub() || cells_[i].members.empty() || cells_[i].rest == kNone) continue;
    const double rest = distance_[i] + weights_[i] + cells_[i].rest;
    if (rest < nearest_) push({std::max(step.distance, rest), i, kRest});
  }
}

/// With a path of that length, the weight of a settled site falls by the length less its distance.
void ExchangeGraph::lower_weights(double length) {
  for (const SiteNumber s : settled_) {
    (s == hub() ? hub_weight_ : weights_[s]) += std::min(0.0, distance_[s] - length);
  }
}

void ExchangeGraph::move_along_path(SiteNumber source, SiteNumber target) {
  for (SiteNumber j = target; j != source;) {
    const auto [i, point] = way_[j];
    if (j == hub()) {
      ++capacities_[i];
    } else if (i == hub()) {
      --capacities_[j];
    } else {
      move(point, i, j);
    }
    j = i;
  }
  ++augmentations_;
}

void ExchangeGraph::move(PointNumber point, SiteNumber from, SiteNumber to) {
  owners_[point] = to.index();
  remove(point, from);
  insert(point, from, to);
}

void ExchangeGraph::settle(const Arena& arena) {
  std::int64_t surpluses = 0;
  for (const SiteNumber s : sites_below(cells_.size())) surpluses += std::max(0, surplus(s));
  if (surpluses * kSitesPerSurplus >= std::ssize(cells_)) bound_all_edges(arena);
  for (const SiteNumber s : sites_below(cells_.size())) {
    while (surplus(s) > 0) {
      arena.check();
      const double length = find_path(s, arena);
      lower_weights(length);
      move_along_path(s, settled_.back());
    }
  }
}

}  // namespace ccvt
