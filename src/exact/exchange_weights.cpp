// What the edges of an exchange graph weigh: the cheapest moves along each.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "exact/exchange.h"
#include "parallel/loops.h"

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
/// From so many members on, as many moves are kept of an edge the first time: to look at all
/// members again takes longer than to keep them.
constexpr Index kLargeCell = 2048;
constexpr std::size_t kMembersPerGrain = 8192;
/// Of as many the cheapest are found by a sample of at least so many.
constexpr std::size_t kSampled = 1024;

}  // namespace

std::size_t ExchangeGraph::moves_kept(SiteNumber site) const {
  const double root = std::sqrt(double{1} * cells_[site].size);
  const double many = std::max(double{1} * surplus(site), moves_expected_);
  const double of_many = std::min(many, kMostMovesPerRoot * root);
  return static_cast<std::size_t>(std::max({kMoves, kMovesPerRoot * root, of_many}));
}

/// Whether cheapest moves are known.
bool ExchangeGraph::is_weighed(const Cell& cell, std::size_t slot) {
  const std::int32_t weighed = cell.weighed[slot];
  return weighed != kNotWeighed && !cell.moves[static_cast<std::size_t>(weighed)].cheapest.empty();
}

ExchangeGraph::Moves& ExchangeGraph::moves_of(SiteNumber site, std::size_t slot) {
  Cell& cell = cells_[site];
  std::int32_t& weighed = cell.weighed[slot];
  if (weighed == kNotWeighed) {
    weighed = static_cast<std::int32_t>(cell.moves.size());
    cell.moves.emplace_back();
    cell.moves.back().kept = cell.size < kLargeCell ? 1 : moves_kept(site);
  }
  return cell.moves[static_cast<std::size_t>(weighed)];
}

/// The cheapest moves along an edge.
ExchangeGraph::Moves& ExchangeGraph::weigh(SiteNumber site, std::size_t slot) {
  Cell& cell = cells_[site];
  if (is_weighed(cell, slot)) return moves_of(site, slot);
  if (part_.ranks != nullptr) {
    weigh_together(site, slot);
  } else {
    choose_slots(site, slot, costs_.sites_at_once());
    weigh_own(site);
    for (const std::size_t chosen : slots_) set_weighed(site, chosen);
  }
  return moves_of(site, slot);
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
  find_least(cell.members, sites);
  std::span<double> least = scratch_.least;
  for (std::size_t k = 0; k < slots_.size(); ++k, least = least.subspan(cell.members.size())) {
    keep_cheapest(site, slots_[k], least.first(cell.members.size()), scratch_.slack[k]);
  }
}

/// What members cost where they are, and no more than their squares at other sites: of a large cell
/// some members after the other, by all threads.
void ExchangeGraph::find_least(std::span<const PointNumber> members,
                               std::span<const SiteNumber> sites) {
  const std::size_t size = members.size();
  scratch_.here.resize(size);
  const auto find_here = [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) scratch_.here[k] = own_cost_[members[k]];
  };
  if (arena_ == nullptr || arena_->threads() == 1 || size < 2 * kMembersPerGrain) {
    find_here(0, size);
    return costs_.squared_at_least(members, sites, scratch_.least, scratch_.slack);
  }
  scratch_.least.resize(sites.size() * size);
  struct Part {
    std::vector<double> least;
    std::vector<double> slack;
    std::vector<double> most;
  };
  PerWorker<Part> parts(*arena_, {{}, {}, std::vector<double>(sites.size(), 0.0)});
  arena_->for_ranges(size, kMembersPerGrain, [&](std::size_t begin, std::size_t end, int worker) {
    Part& part = parts[worker];
    find_here(begin, end);
    costs_.squared_at_least(members.subspan(begin, end - begin), sites, part.least, part.slack);
    for (std::size_t s = 0; s < sites.size(); ++s) {
      part.most[s] = std::max(part.most[s], part.slack[s]);
      const std::span<const double> own = std::span(part.least).subspan(s * (end - begin));
      std::copy_n(own.begin(), end - begin, scratch_.least.data() + s * size + begin);
    }
  });
  scratch_.slack.assign(sites.size(), 0.0);
  for (int worker = 0; worker < arena_->threads(); ++worker) {
    for (std::size_t s = 0; s < sites.size(); ++s) {
      scratch_.slack[s] = std::max(scratch_.slack[s], parts[worker].most[s]);
    }
  }
}

/// Along an edge. `least`: no more than the members' squares there, and less by `slack` at most.
void ExchangeGraph::keep_cheapest(SiteNumber site, std::size_t slot, std::span<double> least,
                                  double slack) {
  Cell& cell = cells_[site];
  Moves& moves = moves_of(site, slot);
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

/// No less than the `count`-th of the values, 0 < count <= values.size(). Of many, about that, by a
/// sample.
double ExchangeGraph::at_least(std::span<const double> values, std::size_t count,
                               Scratch& scratch) {
  if (const std::size_t step = values.size() / kSampled; step > 1) {
    const double about = static_cast<double>(count) / static_cast<double>(step);
    const auto rank = static_cast<std::size_t>(about + 2 * std::sqrt(about) + 1);
    const double limit = ranked(values, step, rank, scratch.there);
    std::size_t found = 0;
    for (const double value : values) found += value <= limit ? 1 : 0;
    if (limit < kNone && found >= count) return limit;
  }
  return ranked(values, 1, count - 1, scratch.there);
}

/// The members of which moving may be one of the `count` cheapest ways, in `nearest`; no other way
/// is before the one that is returned.
ExchangeGraph::Move ExchangeGraph::find_nearest(const Cell& cell, std::size_t count,
                                                std::span<double> least, double slack) {
  Move beyond = {kNone, 0};
  if (cell.members.size() <= count) {
    scratch_.nearest = cell.members;
    return beyond;
  }
  for (std::size_t k = 0; k < least.size(); ++k) least[k] -= scratch_.here[k];
  double limit =
      count > 1 ? at_least(least, count, scratch_) : *std::min_element(least.begin(), least.end());
  limit += slack + 1e-15 * (std::abs(limit) + slack);
  scratch_.nearest.clear();
  double next = kNone;
  for (std::size_t k = 0; k < least.size(); ++k) {
    if (least[k] <= limit) {
      scratch_.nearest.push_back(cell.members[k]);
    } else if (least[k] <= next) {
      const Move move{least[k], number(cell.members[k])};
      beyond = std::min(beyond, move);
      next = least[k];
    }
  }
  return beyond;
}

void ExchangeGraph::set_weighed(SiteNumber site, std::size_t slot) {
  Cell& cell = cells_[site];
  Moves& moves = moves_of(site, slot);
  moves.kept = moves_kept(site);
  cell.bound[slot] = moves.cheapest.empty() ? kNone : moves.cheapest.front().cost;
}

}  // namespace ccvt
