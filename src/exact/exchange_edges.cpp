// The edges of an exchange graph: their bounds, what they weigh, and what becomes of both when a
// point moves.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "exact/exchange.h"

namespace ccvt {
namespace {

/// Of an edge that is weighed again so many moves are kept, or this share of the root of the
/// members; of one that is weighed for the first time, the cheapest.
constexpr double kMoves = 8;
constexpr double kMovesPerRoot = 0.5;

std::size_t moves_kept(std::size_t members) {
  const auto size = static_cast<double>(members);
  return static_cast<std::size_t>(std::max(kMoves, kMovesPerRoot * std::sqrt(size)));
}

}  // namespace

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

/// `from`: where the point comes from.
void ExchangeGraph::insert(PointNumber point, SiteNumber from, SiteNumber site) {
  Cell& cell = cells_[site];
  cell.members.push_back(point);
  if (!cell.bounded) return;
  // Without bounds of all edges, those that are in no slot are bounded by those of `from`.
  const bool some = kept_ == nullptr && cell.rest < kNone && cells_[from].rest < kNone;
  const double before = own_cost_[point];
  std::span<const double> squared;
  if (some) {
    std::vector<SiteNumber>& sites = scratch_.others;
    sites.assign(1, site);
    sites.insert(sites.end(), cell.to.begin(), cell.to.end());
    costs_.squared_to(point, sites, scratch_.own);
    own_cost_[point] = scratch_.own.front();
  } else {
    squared = costs_.squared_to_all(point, scratch_.costs);
    own_cost_[point] = squared[site];
  }
  if (kept_ != nullptr) kept_->include(site, point, squared);
  for (std::size_t slot = 0; slot < cell.to.size(); ++slot) {
    const double there = some ? scratch_.own[slot + 1] : squared[cell.to[slot]];
    add_move(cell, slot, {there - own_cost_[point], point});
  }
  if (cell.rest == kNone) return;
  for (const SiteNumber j : cell.to) in_slot_[j] = 1;
  in_slot_[site] = 1;
  if (some) {
    lower_rest(cell, point, from, before);
  } else {
    lower_rest(cell, site, squared);
  }
  for (const SiteNumber j : cell.to) in_slot_[j] = 0;
  in_slot_[site] = 0;
}

/// A way for a point that has come.
void ExchangeGraph::add_move(Cell& cell, std::size_t slot, const Move& move) {
  if (move.cost < cell.bound[slot]) {
    cell.bound[slot] = move.cost;
    double& page = cell.page[slot / kPage];
    page = std::min(page, move.cost - weights_[cell.to[slot]]);
  }
  if (cell.weighed[slot] == kNotWeighed) return;
  Moves& moves = moves_of(cell, slot);
  if (move.cost >= moves.beyond) return;
  const std::size_t kept = moves_kept(cell.members.size());
  moves.cheapest.insert(std::upper_bound(moves.cheapest.begin(), moves.cheapest.end(), move), move);
  if (moves.cheapest.size() > 2 * kept) {
    moves.beyond = moves.cheapest[kept].cost;
    moves.cheapest.resize(kept);
  }
}

/// For a point that has come, of which the squared distances to all sites are known.
void ExchangeGraph::lower_rest(Cell& cell, SiteNumber site, std::span<const double> squared) {
  for (const SiteNumber j : sites_below(cells_.size())) {
    if (in_slot_[j] == 0) cell.rest = std::min(cell.rest, squared[j] - squared[site] - weights_[j]);
  }
}

/// For one that came from another cell, where it cost `before`: what it costs at any site that is
/// in no slot there either is at least what the rest costs there. O(slots D).
void ExchangeGraph::lower_rest(Cell& cell, PointNumber point, SiteNumber from, double before) {
  const Cell& other = cells_[from];
  const double own = own_cost_[point];
  cell.rest = std::min(cell.rest, other.rest + before - own);
  if (in_slot_[from] == 0) cell.rest = std::min(cell.rest, before - own - weights_[from]);
  std::vector<SiteNumber>& sites = scratch_.others;
  sites.clear();
  std::copy_if(other.to.begin(), other.to.end(), std::back_inserter(sites),
               [&](SiteNumber j) { return in_slot_[j] == 0; });
  costs_.squared_to(point, sites, scratch_.own);
  for (std::size_t k = 0; k < sites.size(); ++k) {
    cell.rest = std::min(cell.rest, scratch_.own[k] - own - weights_[sites[k]]);
  }
}

}  // namespace ccvt
