#include "exact/exchange.h"

#include <algorithm>
#include <cmath>
#include <functional>
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
/// Slots that are looked at or passed over together.
constexpr std::size_t kPage = 32;
/// Of an edge that is weighed again so many moves are kept, or this share of the root of the
/// members; of one that is weighed for the first time, the cheapest.
constexpr double kMoves = 8;
constexpr double kMovesPerRoot = 0.5;

std::size_t slots_of_each(std::size_t sites) { return std::max(kLeastSlots, kSlots / sites); }

std::size_t moves_kept(std::size_t members) {
  const auto size = static_cast<double>(members);
  return static_cast<std::size_t>(std::max(kMoves, kMovesPerRoot * std::sqrt(size)));
}

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

/// Gives slots to the `edges` of a site that cost least, as far as bounds tell. A site without
/// points has none yet.
void ExchangeGraph::bound_edges(SiteNumber site, std::size_t edges, Scratch& scratch) {
  Cell& cell = cells_[site];
  if (cell.members.empty()) return;
  if (!cell.bounded && kept_ == nullptr) {
    costs_.squared(cell.members, site, scratch.own);
    for (std::size_t k = 0; k < cell.members.size(); ++k) {
      own_cost_[cell.members[k]] = scratch.own[k];
    }
  }
  cell.bounded = true;
  cell.tight |= kept_ == nullptr;
  const std::span<const double> bounds =
      kept_ != nullptr ? kept_->include(site, cell.members, costs_, scratch.costs)
                       : costs_.bounds(site, cell.members, scratch.costs);
  std::vector<Edge>& others = scratch.edges;
  others.clear();
  for (const SiteNumber j : sites_below(cells_.size())) {
    if (j != site) others.push_back({bounds[j] - weights_[j], j});
  }
  cell.rest = kNone;
  if (edges < others.size()) {
    const auto first = others.begin() + static_cast<std::ptrdiff_t>(edges);
    std::nth_element(others.begin(), first, others.end());
    cell.rest = first->reduced;
    others.resize(edges);
  }
  std::sort(others.begin(), others.end());
  // What was weighed stays so.
  scratch.weighed.assign(cells_.size(), kNotWeighed);
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    scratch.weighed[cell.to[slot]] = cell.weighed[slot];
  }
  cell.to.resize(others.size());
  cell.bound.resize(others.size());
  cell.weighed.resize(others.size());
  cell.page.resize((others.size() + kPage - 1) / kPage);
  for (std::size_t slot = 0; slot < others.size(); ++slot) {
    const auto& [reduced, to] = others[slot];
    cell.to[slot] = to;
    cell.weighed[slot] = scratch.weighed[to];
    cell.bound[slot] =
        is_weighed(cell, slot) ? moves_of(cell, slot).cheapest.front().cost : bounds[to];
    if (slot % kPage == 0) cell.page[slot / kPage] = reduced;
  }
}

/// Bounds all edges of a site by a product: what was kept may be far below what the edges of a cell
/// weigh, and a search would weigh most of them.
void ExchangeGraph::tighten(SiteNumber site) {
  Cell& cell = cells_[site];
  kept_->raise(site, costs_.bounds(site, cell.members, scratch_.costs));
  bound_edges(site, cell.to.size(), scratch_);
  cell.tight = true;
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

ExchangeGraph::Moves& ExchangeGraph::moves_of(Cell& cell, std::size_t slot) {
  std::int32_t& weighed = cell.weighed[slot];
  if (weighed == kNotWeighed) {
    weighed = static_cast<std::int32_t>(cell.moves.size());
    cell.moves.emplace_back();
  }
  return cell.moves[static_cast<std::size_t>(weighed)];
}

/// The cheapest moves along an edge.
ExchangeGraph::Moves& ExchangeGraph::weigh(SiteNumber site, std::size_t slot) {
  Cell& cell = cells_[site];
  Moves& moves = moves_of(cell, slot);
  if (!moves.cheapest.empty()) return moves;
  std::vector<double>& squared = scratch_.own;
  costs_.squared(cell.members, cell.to[slot], squared);
  ++cell.weighings;
  const std::size_t kept = moves.kept;
  moves.kept = moves_kept(cell.members.size());
  std::vector<Move>& cheapest = moves.cheapest;
  moves.beyond = kNone;
  for (std::size_t k = 0; k < cell.members.size(); ++k) {
    const PointNumber p = cell.members[k];
    const Move move{squared[k] - own_cost_[p], p};
    if (cheapest.size() == kept) {
      moves.beyond = std::min(moves.beyond, std::max(move, cheapest.back()).cost);
      if (!(move < cheapest.back())) continue;
      cheapest.pop_back();
    }
    cheapest.insert(std::upper_bound(cheapest.begin(), cheapest.end(), move), move);
  }
  cell.bound[slot] = cheapest.empty() ? kNone : cheapest.front().cost;
  if (kept_ != nullptr) kept_->set(site, cell.to[slot], cell.bound[slot]);
  return moves;
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

/// Whether cheapest moves are known.
bool ExchangeGraph::is_weighed(const Cell& cell, std::size_t slot) {
  const std::int32_t weighed = cell.weighed[slot];
  return weighed != kNotWeighed && !cell.moves[static_cast<std::size_t>(weighed)].cheapest.empty();
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
  insert(point, to);
}

void ExchangeGraph::remove(PointNumber point, SiteNumber site) {
  if (kept_ != nullptr) kept_->remove(point);
  Cell& cell = cells_[site];
  *std::find(cell.members.begin(), cell.members.end(), point) = cell.members.back();
  cell.members.pop_back();
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    if (cell.weighed[slot] == kNotWeighed) continue;
    Moves& moves = moves_of(cell, slot);
    std::erase_if(moves.cheapest, [point](const Move& m) { return m.point == point; });
    cell.bound[slot] = moves.cheapest.empty() ? moves.beyond : moves.cheapest.front().cost;
  }
}

void ExchangeGraph::insert(PointNumber point, SiteNumber site) {
  Cell& cell = cells_[site];
  cell.members.push_back(point);
  if (!cell.bounded) return;
  const std::span<const double> squared = costs_.squared_to_all(point, scratch_.costs);
  own_cost_[point] = squared[site];
  if (kept_ != nullptr) kept_->include(site, point, squared);
  const std::size_t kept = moves_kept(cell.members.size());
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    const Move move{squared[cell.to[slot]] - squared[site], point};
    if (move.cost < cell.bound[slot]) {
      cell.bound[slot] = move.cost;
      double& page = cell.page[slot / kPage];
      page = std::min(page, move.cost - weights_[cell.to[slot]]);
    }
    if (cell.weighed[slot] == kNotWeighed) continue;
    Moves& moves = moves_of(cell, slot);
    if (move.cost >= moves.beyond) continue;
    moves.cheapest.insert(std::upper_bound(moves.cheapest.begin(), moves.cheapest.end(), move),
                          move);
    if (moves.cheapest.size() > 2 * kept) {
      moves.beyond = moves.cheapest[kept].cost;
      moves.cheapest.resize(kept);
    }
  }
  if (cell.rest == kNone) return;
  for (const SiteNumber j : cell.to) in_slot_[j] = 1;
  in_slot_[site] = 1;
  for (const SiteNumber j : sites_below(cells_.size())) {
    if (in_slot_[j] == 0) cell.rest = std::min(cell.rest, squared[j] - squared[site] - weights_[j]);
  }
  for (const SiteNumber j : cell.to) in_slot_[j] = 0;
  in_slot_[site] = 0;
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
