#include "exact/exchange.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <tuple>

#include "cell_sizes.h"
#include "exact/grouping.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// All edges of all sites take slots as long as there are no more than this.
constexpr std::size_t kSlots = std::size_t{1} << 16;
constexpr std::size_t kLeastSlots = 64;
/// Searches for so many surplus points look at most sites: their edges are bounded in parallel.
constexpr std::int64_t kSitesPerSurplus = 32;
/// A path goes along about so many edges, and most go along the same few of a site.
constexpr double kPathEdges = 2;

}  // namespace

ExchangeGraph::ExchangeGraph(std::vector<Index>& capacities, bool floating,
                             std::vector<Index>& owners, std::vector<double>& weights,
                             MoveCosts& costs, CellBounds* kept, const RankPart& part)
    : capacities_(capacities),
      floating_(floating),
      owners_(owners),
      weights_(weights),
      costs_(costs),
      kept_(kept),
      part_(part),
      cells_(capacities.size()),
      own_storage_(kept == nullptr ? owners.size() : 0),
      own_cost_(kept == nullptr ? own_storage_ : kept->own_costs()),
      in_slot_(capacities.size(), 0),
      distance_(capacities.size() + 1, kNone),
      limit_(capacities.size() + 1, kNone),
      way_(capacities.size() + 1) {
  const Grouping groups(owners, cells_.size());
  const std::vector<Index> sizes = summed(part.ranks, cell_sizes(owners, cells_.size()));
  for (const SiteNumber s : sites_below(cells_.size())) {
    const auto members = groups.of(s);
    cells_[s].members.assign(members.begin(), members.end());
    cells_[s].size = sizes[s];
  }
  for (const double weight : weights) largest_weight_ = std::max(largest_weight_, std::abs(weight));
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

std::size_t ExchangeGraph::slots_of_each() const {
  return std::max(kLeastSlots, kSlots / cells_.size());
}

void ExchangeGraph::bound_all_edges(const Arena& arena) {
  if (part_.ranks != nullptr) return bound_all_together(arena);
  if (sharing_ != nullptr) return bound_all_in_turns(arena);
  PerWorker<Scratch> scratch(arena);
  arena.for_ranges(cells_.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(begin, end)) {
      arena.check();
      bound_edges(s, slots_of_each(), scratch[worker]);
    }
  });
}

void ExchangeGraph::push(const Step& step) {
  heap_.push_back(step);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

/// Reaches `to`, if that is the shortest way so far, or the lowest of those.
void ExchangeGraph::relax(const Way& way, SiteNumber to, double distance) {
  if (distance > limit_[to]) return;
  if (distance == limit_[to]) {
    way_[to] = std::min(way_[to], way);
    return;
  }
  if (distance_[to] == kNone) seen_.push_back(to);
  distance_[to] = limit_[to] = distance;
  way_[to] = way;
  const bool target = to != hub() && surplus(to) < 0;
  if (target && std::tie(distance, to) < std::tie(nearest_, end_)) {
    nearest_ = distance;
    end_ = to;
  }
  push({distance, to, target ? kTarget : kSite});
}

/// Whether a way from one site to another that is no shorter than this may be one of the path's.
bool ExchangeGraph::may_matter(SiteNumber from, SiteNumber to, double distance) const {
  if (distance > limit_[to] || distance > nearest_) return false;
  if (distance == limit_[to] && way_[to].from < from) return false;  // it has a lower one
  // As far away as the end, and not before it, it is not looked on from.
  return distance < nearest_ || (surplus(to) < 0 && !(end_ < to));
}

/// Along an edge of a site; never below the site's distance, whatever rounding has done to a
/// reduced cost.
void ExchangeGraph::relax_edge(SiteNumber from, std::size_t slot) {
  const Moves& moves = weigh(from, slot);
  if (moves.cheapest.empty()) return;
  const Move& move = moves.cheapest.front();
  const SiteNumber to = cells_[from].to[slot];
  const double base = distance_[from] + weights_[from];
  relax({from, move.point}, to, std::max(distance_[from], base + move.cost - weights_[to]));
}

/// The shortest way from `source` to a site with too few points without any other on it: no path
/// longer than that need be looked at.
void ExchangeGraph::reach_directly(SiteNumber source) {
  const Cell& cell = cells_[source];
  const double base = weights_[source];
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    const SiteNumber j = cell.to[slot];
    const double distance = std::max(0.0, base + cell.bound[slot] - weights_[j]);
    if (surplus(j) >= 0 || !may_matter(source, j, distance)) continue;
    relax_edge(source, slot);
  }
}

/// Less than the length of any way, as it is rounded, from a site to one whose edge weighs no less
/// than `reduced` when its weight is taken off.
double ExchangeGraph::lowered(double base, double reduced) const {
  return base + reduced - 1e-14 * (std::abs(base) + std::abs(reduced) + largest_weight_);
}

/// From the hub, along all its edges.
void ExchangeGraph::relax_hub() {
  const double least = distance_[hub()];
  const double base = least + hub_weight_;
  for (const SiteNumber a : sites_below(cells_.size())) {
    if (has_more(a)) relax({hub(), kNoPoint}, a, std::max(least, base - weights_[a]));
  }
}

/// Along the edges of a site from the slots of a page on; those that lead no farther than
/// `looked_at` at once, others when the search has come as far.
void ExchangeGraph::relax_edges(SiteNumber from, std::size_t page, double looked_at) {
  const Cell& cell = cells_[from];
  const double least = distance_[from];
  const double base = least + weights_[from];
  for (; page < cell.page.size(); ++page) {
    const double nearest = lowered(base, std::min(cell.rest, cell.page[page]));
    if (nearest > nearest_) return;
    if (nearest > looked_at) return push({nearest, from, step_of_page(page)});
    const std::size_t end = std::min((page + 1) * kPage, cell.to.size());
    for (std::size_t slot = page * kPage; slot < end; ++slot) {
      const SiteNumber j = cell.to[slot];
      const double distance = std::max(least, base + cell.bound[slot] - weights_[j]);
      if (!may_matter(from, j, distance)) continue;
      if (is_weighed(cell, slot)) {
        relax_edge(from, slot);
      } else {
        push({distance, from, static_cast<std::int32_t>(slot)});
      }
    }
  }
  if (cell.size == 0 || cell.rest == kNone) return;
  const double rest = lowered(base, cell.rest);
  if (rest <= nearest_) push({std::max(least, rest), from, kRest});
}

/// Shortest paths from `source` up to the first site with too few points, settled_.back(); how far
/// that is.
double ExchangeGraph::find_path(SiteNumber source, const Arena& arena) {
  for (const SiteNumber s : seen_) distance_[s] = limit_[s] = kNone;
  seen_.assign(1, source);
  settled_.clear();
  heap_.clear();
  nearest_ = kNone;
  end_ = hub();
  distance_[source] = limit_[source] = 0;
  push({0, source, kSite});
  for (;;) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const Step step = heap_.back();
    heap_.pop_back();
    const SiteNumber i = step.site;
    if (step.what >= kTarget) {
      if (settled(i)) continue;
      limit_[i] = -kNone;
      settled_.push_back(i);
      if (i == hub()) {
        relax_hub();
        continue;
      }
      if (surplus(i) < 0) return step.distance;
      if (!cells_[i].bounded) {
        arena.check();
        bound_edges(i, slots_of_each(), scratch_);
      }
      if (i == source) reach_directly(i);
      if (floating_ && !has_more(i)) {
        const double distance = distance_[i] + weights_[i] - hub_weight_;
        relax({i, kNoPoint}, hub(), std::max(distance_[i], distance));
      }
    } else if (step.what < kRest) {
      relax_edges(i, page_of_step(step.what), step.distance);
      continue;
    } else if (step.what == kRest) {
      arena.check();
      bound_edges(i, 2 * cells_[i].to.size(), scratch_);
    } else {
      // Slots may have changed since: then all edges of the site were pushed again, and this is
      // one of them too many.
      const auto slot = static_cast<std::size_t>(step.what);
      const Cell& cell = cells_[i];
      if (!may_matter(i, cell.to[slot], step.distance)) continue;
      if (cell.tight || cell.weighings < costs_.weighings() || is_weighed(cell, slot)) {
        relax_edge(i, slot);
        continue;
      }
      arena.check();
      tighten(i);
    }
    relax_edges(i, 0, step.distance);
  }
}

/// With a path of that length, the weight of a settled site falls by the length less its distance.
void ExchangeGraph::lower_weights(double length) {
  for (const SiteNumber s : settled_) {
    double& weight = s == hub() ? hub_weight_ : weights_[s];
    weight += std::min(0.0, distance_[s] - length);
    largest_weight_ = std::max(largest_weight_, std::abs(weight));
  }
}

void ExchangeGraph::move_along_path(SiteNumber source, SiteNumber target) {
  std::vector<Mover>& movers = movers_;
  movers.clear();
  for (SiteNumber j = target; j != source; j = way_[j].from) {
    const auto [i, point] = way_[j];
    if (j == hub()) {
      ++capacities_[i];
    } else if (i == hub()) {
      --capacities_[j];
    } else {
      movers.push_back({point, PointNumber(point), i, j});
    }
  }
  if (part_.ranks != nullptr) bring(movers);
  for (const Mover& mover : movers) move(mover);
  ++augmentations_;
}

void ExchangeGraph::move(const Mover& mover) {
  if (is_own(mover.place)) owners_[mover.place] = mover.to.index();
  remove(mover);
  insert(mover);
}

void ExchangeGraph::settle(const Arena& arena) {
  arena_ = &arena;
  sharing_ = sharing(arena, part_);
  turns_ = RankTurns(sharing_);
  std::int64_t surpluses = 0;
  for (const SiteNumber s : sites_below(cells_.size())) surpluses += std::max(0, surplus(s));
  moves_expected_ =
      kPathEdges * static_cast<double>(surpluses) / static_cast<double>(cells_.size());
  if (surpluses * kSitesPerSurplus >= std::ssize(cells_)) bound_all_edges(arena);
  for (const SiteNumber s : sites_below(cells_.size())) {
    while (surplus(s) > 0) {
      arena.check();
      const double length = find_path(s, arena);
      lower_weights(length);
      move_along_path(s, settled_.back());
    }
  }
  arena_ = nullptr;
}

}  // namespace ccvt
