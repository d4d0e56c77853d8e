// The edges of an exchange graph: their bounds, and what becomes of them, and of what they weigh,
// when a point moves.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "exact/exchange.h"

namespace ccvt {
namespace {

/// Where edges that cost least are looked for by a sample, so many of them are to be in it.
constexpr std::size_t kLeastSampled = 24;
/// With so many times as many sites as slots it takes longer to look at all sites for a point that
/// comes than what loose bounds of those in no slot cost later.
constexpr std::size_t kManySites = 8;

}  // namespace

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
  return ranked(scratch.reduced, step, edges / step, scratch.own);
}

/// Of every `step`-th value, the one that `rank` others precede; infinity where there is none.
double ExchangeGraph::ranked(std::span<const double> values, std::size_t step, std::size_t rank,
                             std::vector<double>& sample) {
  sample.clear();
  for (std::size_t k = 0; k < values.size(); k += step) sample.push_back(values[k]);
  if (rank >= sample.size()) return kNone;
  const auto at = sample.begin() + static_cast<std::ptrdiff_t>(rank);
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
    cell.bound[slot] = is_weighed(cell, slot) ? moves_of(site, slot).cheapest.front().cost : bound;
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
    Moves& moves = moves_of(mover.from, slot);
    std::erase_if(moves.cheapest, [&](const Move& m) { return m.point == mover.point; });
    cell.bound[slot] = (moves.cheapest.empty() ? moves.beyond : moves.cheapest.front()).cost;
  }
}

void ExchangeGraph::insert(const Mover& mover) {
  Cell& cell = cells_[mover.to];
  ++cell.size;
  if (is_own(mover.place)) cell.members.push_back(mover.place);
  if (!cell.bounded) return;
  const bool all = cell.rest == kNone;  // edges have slots
  if (!all) {
    for (const SiteNumber j : cell.to) in_slot_[j] = 1;
    in_slot_[mover.to] = 1;
  }
  // Where most are in no slot, they are bounded by those of `from`; not by several ranks, whose
  // bounds that are kept would not be alike.
  const bool most =
      kept_ == nullptr || (part_.ranks == nullptr && cells_.size() >= kManySites * cell.to.size());
  if (most && !all && cells_[mover.from].rest < kNone) {
    add_to_slots(mover);
  } else {
    add_to_all(mover);
  }
  if (all) return;
  for (const SiteNumber j : cell.to) in_slot_[j] = 0;
  in_slot_[mover.to] = 0;
}

/// The ways of a point that has come along all edges in slots; the others are bounded by those of
/// the site it came from.
void ExchangeGraph::add_to_slots(const Mover& mover) {
  Cell& cell = cells_[mover.to];
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.assign({mover.to, mover.from});
  sites.insert(sites.end(), cell.to.begin(), cell.to.end());
  std::vector<double>& squared = scratch_.there;
  costs_.squared_to(mover.place, sites, squared, scratch_.costs);
  const double own = squared[0];
  if (is_own(mover.place)) {
    own_cost_[mover.place] = own;
    if (kept_ != nullptr) kept_->widen(mover.to, own);
  }
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    add_move(mover.to, slot, {squared[slot + 2] - own, mover.point});
  }
  lower_rest(cell, mover, squared[1], own);
}

/// The ways of a point that has come along all edges: to the last bit where it may be one of the
/// cheapest moves known, for the others bounds will do.
void ExchangeGraph::add_to_all(const Mover& mover) {
  Cell& cell = cells_[mover.to];
  const auto& [point, place, from, site] = mover;
  std::vector<double>& exact = scratch_.there;
  costs_.squared_to(place, {&site, 1}, exact, scratch_.costs);
  const double own = exact.front();
  const std::span<const double> squared = costs_.squared_at_least_to_all(place, scratch_.costs);
  if (is_own(place)) {
    own_cost_[place] = own;
    if (kept_ != nullptr) kept_->include(site, place, squared, own);
  }
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.clear();
  slots_.clear();
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    const SiteNumber j = cell.to[slot];
    if (cell.weighed[slot] == kNotWeighed) {
      add_move(site, slot, {squared[j] - own, point});
    } else if (!is_weighed(cell, slot) || !(squared[j] - own > moves_of(site, slot).beyond.cost)) {
      sites.push_back(j);
      slots_.push_back(slot);
    }
  }
  costs_.squared_to(place, sites, exact, scratch_.costs);
  for (std::size_t k = 0; k < slots_.size(); ++k) {
    add_move(site, slots_[k], {exact[k] - own, point});
  }
  if (cell.rest < kNone) lower_rest(cell, own, squared);
}

/// A way for a point that has come.
void ExchangeGraph::add_move(SiteNumber site, std::size_t slot, const Move& move) {
  Cell& cell = cells_[site];
  cell.bound[slot] = std::min(cell.bound[slot], move.cost);
  // Not only where the bound falls: one of an edge whose known moves are all gone may be below its
  // page's.
  const double reduced = move.cost - weights_[cell.to[slot]];
  for (std::size_t page = slot / kPage + 1; page > 0 && cell.page[page - 1] > reduced; --page) {
    cell.page[page - 1] = reduced;
  }
  if (cell.weighed[slot] == kNotWeighed) return;
  Moves& moves = moves_of(site, slot);
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
