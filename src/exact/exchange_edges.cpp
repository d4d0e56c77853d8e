// The edges of an exchange graph: their bounds, what they weigh, and what becomes of both when a
// point moves.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "exact/exchange.h"

namespace ccvt {
namespace {

/// Of an edge that is weighed again so many moves are kept, or this share of the root of the
/// members; of one that is weighed for the first time, the cheapest. Of a cell with a surplus as
/// many as that, up to a larger share of the root: each point that goes is taken from the moves of
/// all edges, and when an edge has no more of them, all members are looked at (20,000 vectors in
/// 8-D, 1000 of them equal and far: 12.7 s where no more are kept, 3.6 so).
constexpr double kMoves = 8;
constexpr double kMovesPerRoot = 0.5;
constexpr double kMostMovesPerRoot = 4;
/// Where edges that cost least are looked for by a sample, so many of them are to be in it.
constexpr std::size_t kLeastSampled = 24;
/// With so many times as many sites as slots it takes longer to look at all sites for a point that
/// comes than what loose bounds of those in no slot cost later.
constexpr std::size_t kManySites = 8;

}  // namespace

std::size_t ExchangeGraph::moves_kept(SiteNumber site) const {
  const double root = std::sqrt(double{1} * cells_[site].size);
  const double of_many = std::min(double{1} * surplus(site), kMostMovesPerRoot * root);
  return static_cast<std::size_t>(std::max({kMoves, kMovesPerRoot * root, of_many}));
}

/// What the points of a cell cost where they are, unless it is known.
void ExchangeGraph::find_costs(SiteNumber site, Scratch& scratch) {
  Cell& cell = cells_[site];
  if (cell.costed) return;
  costs_.squared(cell.members, site, scratch.own);
  for (std::size_t k = 0; k < cell.members.size(); ++k) {
    own_cost_[cell.members[k]] = scratch.own[k];
  }
  cell.costed = true;
}

/// The `edges` of a site that cost least, as far as bounds tell, for points that this rank has.
void ExchangeGraph::find_edges(SiteNumber site, std::size_t edges, Scratch& scratch) {
  Cell& cell = cells_[site];
  scratch.edges.clear();
  scratch.rest = kNone;
  if (cell.members.empty()) return;
  if (kept_ == nullptr) find_costs(site, scratch);
  const std::span<const double> bounds =
      kept_ != nullptr ? kept_->include(site, cell.members, costs_, scratch.costs)
                       : costs_.bounds(site, cell.members, scratch.costs);
  cell.costed = true;
  std::vector<double>& reduced = scratch.reduced;
  reduced.resize(cells_.size());
  std::transform(bounds.begin(), bounds.end(), weights_.begin(), reduced.begin(),
                 [](double bound, double weight) { return bound - weight; });
  reduced[site] = kNone;
  const auto add_up_to = [&](double limit) {
    scratch.edges.clear();
    for (const SiteNumber j : sites_below(cells_.size())) {
      if (reduced[j] <= limit && j != site) scratch.edges.push_back({reduced[j], j, bounds[j]});
    }
  };
  const double limit = about(edges + edges / 2, scratch);
  add_up_to(limit);
  if (limit < kNone && scratch.edges.size() <= edges) add_up_to(kNone);
  keep_nearest(edges, scratch);
}

/// What about so many of the reduced costs do not exceed, by a sample of them.
double ExchangeGraph::about(std::size_t edges, Scratch& scratch) {
  if (edges >= scratch.reduced.size()) return kNone;
  const std::size_t step = std::max<std::size_t>(1, edges / kLeastSampled);
  std::vector<double>& sample = scratch.own;
  sample.clear();
  for (std::size_t j = 0; j < scratch.reduced.size(); j += step) {
    sample.push_back(scratch.reduced[j]);
  }
  if (edges / step >= sample.size()) return kNone;
  const auto at = sample.begin() + static_cast<std::ptrdiff_t>(edges / step);
  std::nth_element(sample.begin(), at, sample.end());
  return *at;
}

void ExchangeGraph::keep_nearest(std::size_t edges, Scratch& scratch) {
  std::vector<Edge>& nearest = scratch.edges;
  if (nearest.size() <= edges) return;
  const auto first = nearest.begin() + static_cast<std::ptrdiff_t>(edges);
  std::nth_element(nearest.begin(), first, nearest.end());
  scratch.rest = std::min(scratch.rest, first->reduced);
  nearest.resize(edges);
}

/// Gives slots to the `edges` of a site that cost least, as far as bounds tell. A site without
/// points has none yet.
void ExchangeGraph::bound_edges(SiteNumber site, std::size_t edges, Scratch& scratch) {
  if (cells_[site].size == 0) return;
  if (sharing_ != nullptr && kept_ != nullptr) {
    find_edges_in_turns(site, edges, scratch);
  } else {
    find_edges(site, edges, scratch);
    if (part_.ranks != nullptr) find_edges_together(edges, scratch);
  }
  set_edges(site, scratch);
}

/// Gives slots to the edges found.
void ExchangeGraph::set_edges(SiteNumber site, Scratch& scratch) {
  Cell& cell = cells_[site];
  cell.bounded = true;
  cell.tight |= kept_ == nullptr;
  cell.rest = scratch.rest;
  std::vector<Edge>& others = scratch.edges;
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
    const auto& [reduced, to, bound] = others[slot];
    cell.to[slot] = to;
    cell.weighed[slot] = scratch.weighed[to];
    cell.bound[slot] = is_weighed(cell, slot) ? moves_of(cell, slot).cheapest.front().cost : bound;
    if (slot % kPage == 0) cell.page[slot / kPage] = reduced;
  }
}

/// Bounds all edges of a site by a product: what was kept may be far below what the edges of a cell
/// weigh, and a search would weigh most of them.
void ExchangeGraph::tighten(SiteNumber site) {
  Cell& cell = cells_[site];
  if (!cell.members.empty() && kept_->has(site)) {
    kept_->raise(site, costs_.bounds(site, cell.members, scratch_.costs));
  }
  bound_edges(site, cell.to.size(), scratch_);
  cell.tight = true;
}

/// Whether cheapest moves are known.
bool ExchangeGraph::is_weighed(const Cell& cell, std::size_t slot) {
  const std::int32_t weighed = cell.weighed[slot];
  return weighed != kNotWeighed && !cell.moves[static_cast<std::size_t>(weighed)].cheapest.empty();
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
  if (is_weighed(cell, slot)) return moves_of(cell, slot);
  if (part_.ranks != nullptr) {
    weigh_together(site, slot);
  } else {
    choose_slots(site, slot, costs_.sites_at_once());
    weigh_own(site);
    for (const std::size_t chosen : slots_) set_weighed(site, chosen);
  }
  return moves_of(cell, slot);
}

/// The edge in that slot, and others of the site that the search at hand may take: the first in the
/// order of slots, which is about that of their bounds. With one to a site with too few points,
/// only others to such sites: they may end the search.
void ExchangeGraph::choose_slots(SiteNumber site, std::size_t slot, std::size_t most) {
  const Cell& cell = cells_[site];
  const double base = distance_[site] + weights_[site];
  const bool to_target = surplus(cell.to[slot]) < 0;
  slots_.assign(1, slot);
  for (std::size_t other = 0; other < cell.to.size() && slots_.size() < most; ++other) {
    const SiteNumber j = cell.to[other];
    if (other == slot || is_weighed(cell, other) || (to_target && surplus(j) >= 0)) continue;
    const double distance = std::max(distance_[site], base + cell.bound[other] - weights_[j]);
    if (may_matter(site, j, distance)) slots_.push_back(other);
  }
}

/// Of the points that this rank has, the cheapest moves along the edges chosen.
void ExchangeGraph::weigh_own(SiteNumber site) {
  Cell& cell = cells_[site];
  ++cell.weighings;
  find_costs(site, scratch_);
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.clear();
  for (const std::size_t slot : slots_) sites.push_back(cell.to[slot]);
  costs_.squared_at_least(cell.members, sites, scratch_.least, scratch_.slack);
  std::span<double> least = scratch_.least;
  for (std::size_t k = 0; k < slots_.size(); ++k, least = least.subspan(cell.members.size())) {
    keep_cheapest(site, slots_[k], least.first(cell.members.size()), scratch_.slack[k]);
  }
}

/// Along an edge. `least`: no more than the members' squares there, and less by `slack` at most.
void ExchangeGraph::keep_cheapest(SiteNumber site, std::size_t slot, std::span<double> least,
                                  double slack) {
  Cell& cell = cells_[site];
  Moves& moves = moves_of(cell, slot);
  moves.beyond = find_nearest(cell, moves.kept, least, slack);
  const std::vector<PointNumber>& nearest = scratch_.nearest;
  std::vector<double>& squared = scratch_.own;
  costs_.squared(nearest, cell.to[slot], squared);
  std::vector<Move>& cheapest = moves.cheapest;
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const PointNumber p = nearest[k];
    const Move move{squared[k] - own_cost_[p], number(p)};
    if (cheapest.size() == moves.kept) {
      moves.beyond = std::min(moves.beyond, std::max(move, cheapest.back()));
      if (!(move < cheapest.back())) continue;
      cheapest.pop_back();
    }
    cheapest.insert(std::upper_bound(cheapest.begin(), cheapest.end(), move), move);
  }
  if (kept_ != nullptr && !cheapest.empty()) {
    kept_->set(site, cell.to[slot], cheapest.front().cost);
  }
}

/// The members of which moving may be one of the `count` cheapest ways, in `nearest`; no other way
/// is before the one that is returned.
ExchangeGraph::Move ExchangeGraph::find_nearest(const Cell& cell, std::size_t count,
                                                std::span<double> least, double slack) {
  Move beyond = {kNone, 0};
  scratch_.nearest = cell.members;
  if (cell.members.size() <= count) return beyond;
  for (std::size_t k = 0; k < least.size(); ++k) least[k] -= own_cost_[cell.members[k]];
  double limit = *std::min_element(least.begin(), least.end());
  if (count > 1) {
    std::vector<double>& order = scratch_.there;
    order.assign(least.begin(), least.end());
    const auto last = order.begin() + static_cast<std::ptrdiff_t>(count - 1);
    std::nth_element(order.begin(), last, order.end());
    limit = *last;
  }
  limit += slack + 1e-15 * (std::abs(limit) + slack);
  scratch_.nearest.clear();
  for (std::size_t k = 0; k < least.size(); ++k) {
    const PointNumber p = cell.members[k];
    if (least[k] <= limit) {
      scratch_.nearest.push_back(p);
    } else {
      beyond = std::min(beyond, {least[k], number(p)});
    }
  }
  return beyond;
}

void ExchangeGraph::set_weighed(SiteNumber site, std::size_t slot) {
  Cell& cell = cells_[site];
  Moves& moves = moves_of(cell, slot);
  moves.kept = moves_kept(site);
  cell.bound[slot] = moves.cheapest.empty() ? kNone : moves.cheapest.front().cost;
}

void ExchangeGraph::remove(const Mover& mover) {
  Cell& cell = cells_[mover.from];
  --cell.size;
  if (is_own(mover.place)) {
    if (kept_ != nullptr) kept_->remove(mover.place);
    *std::find(cell.members.begin(), cell.members.end(), mover.place) = cell.members.back();
    cell.members.pop_back();
  }
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    if (cell.weighed[slot] == kNotWeighed) continue;
    Moves& moves = moves_of(cell, slot);
    std::erase_if(moves.cheapest, [&](const Move& m) { return m.point == mover.point; });
    cell.bound[slot] = (moves.cheapest.empty() ? moves.beyond : moves.cheapest.front()).cost;
  }
}

void ExchangeGraph::insert(const Mover& mover) {
  const auto& [point, place, from, site] = mover;
  Cell& cell = cells_[site];
  ++cell.size;
  if (is_own(place)) cell.members.push_back(place);
  if (!cell.bounded) return;
  // Where most are in no slot, they are bounded by those of `from`; not by several ranks, whose
  // bounds that are kept would not be alike.
  const bool most =
      kept_ == nullptr || (part_.ranks == nullptr && cells_.size() >= kManySites * cell.to.size());
  const bool some = most && cell.rest < kNone && cells_[from].rest < kNone;
  // What is weighed is known to the last bit; for the others bounds will do.
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.assign({site, from});
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    if (some || cell.weighed[slot] != kNotWeighed) sites.push_back(cell.to[slot]);
  }
  std::vector<double>& exact = scratch_.there;
  costs_.squared_to(place, sites, exact, scratch_.costs);
  const double own = exact[0];
  const double before = exact[1];
  std::span<const double> squared;
  if (!some) squared = costs_.squared_at_least_to_all(place, scratch_.costs);
  if (is_own(place)) {
    own_cost_[place] = own;
    if (kept_ != nullptr) {
      if (some) {
        kept_->widen(site, own);
      } else {
        kept_->include(site, place, squared, own);
      }
    }
  }
  const double* next = exact.data() + 2;
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    if (some || cell.weighed[slot] != kNotWeighed) {
      add_move(site, slot, {*next++ - own, point});
    } else {
      add_move(site, slot, {squared[cell.to[slot]] - own, point});
    }
  }
  if (cell.rest == kNone) return;
  for (const SiteNumber j : cell.to) in_slot_[j] = 1;
  in_slot_[site] = 1;
  if (some) {
    lower_rest(cell, mover, before, own);
  } else {
    lower_rest(cell, own, squared);
  }
  for (const SiteNumber j : cell.to) in_slot_[j] = 0;
  in_slot_[site] = 0;
}

/// A way for a point that has come.
void ExchangeGraph::add_move(SiteNumber site, std::size_t slot, const Move& move) {
  Cell& cell = cells_[site];
  cell.bound[slot] = std::min(cell.bound[slot], move.cost);
  // Not only where the bound falls: one of an edge whose known moves are all gone may be below its
  // page's.
  double& page = cell.page[slot / kPage];
  page = std::min(page, move.cost - weights_[cell.to[slot]]);
  if (cell.weighed[slot] == kNotWeighed) return;
  Moves& moves = moves_of(cell, slot);
  if (moves.beyond < move) return;
  const std::size_t kept = moves_kept(site);
  moves.cheapest.insert(std::upper_bound(moves.cheapest.begin(), moves.cheapest.end(), move), move);
  if (moves.cheapest.size() > 2 * kept) {
    moves.beyond = moves.cheapest[kept];
    moves.cheapest.resize(kept);
  }
}

/// For a point that has come, costs `own` here, and is no nearer to any site than `squared`.
void ExchangeGraph::lower_rest(Cell& cell, double own, std::span<const double> squared) {
  for (const SiteNumber j : sites_below(cells_.size())) {
    if (in_slot_[j] != 0) continue;
    cell.rest = std::min(cell.rest, squared[j] - own - weights_[j]);
  }
}

/// For one that came from another cell, where it cost `before`: what it costs at any site that is
/// in no slot there either is at least what the rest costs there. O(slots D).
void ExchangeGraph::lower_rest(Cell& cell, const Mover& mover, double before, double own) {
  const SiteNumber from = mover.from;
  const Cell& other = cells_[from];
  cell.rest = std::min(
      cell.rest, other.rest + before - own - costs_.rounding(before + own + std::abs(other.rest)));
  if (in_slot_[from] == 0) cell.rest = std::min(cell.rest, before - own - weights_[from]);
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.clear();
  std::copy_if(other.to.begin(), other.to.end(), std::back_inserter(sites),
               [&](SiteNumber j) { return in_slot_[j] == 0; });
  costs_.squared_to(mover.place, sites, scratch_.own, scratch_.costs);
  for (std::size_t k = 0; k < sites.size(); ++k) {
    cell.rest = std::min(cell.rest, scratch_.own[k] - own - weights_[sites[k]]);
  }
}

}  // namespace ccvt
