#include "exact/exchange.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace ccvt {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

ExchangeGraph::ExchangeGraph(std::vector<Index>& capacities, bool floating,
                             std::vector<Index>& owners, std::vector<double>& weights)
    : capacities_(capacities),
      floating_(floating),
      owners_(owners),
      weights_(weights),
      cells_(capacities.size()),
      first_option_(owners.size(), -1),
      own_key_(owners.size(), 0.0),
      count_(capacities.size(), 0),
      start_(weights),
      distance_(capacities.size() + 1, kNone),
      parent_(capacities.size() + 1),
      state_(capacities.size() + 1, 0) {
  for (const Index owner : owners) ++count_[at(owner)];
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

Index ExchangeGraph::slot_of(Cell& cell, Index to) {
  const auto found = std::find(cell.to.begin(), cell.to.end(), to);
  const auto slot = static_cast<Index>(found - cell.to.begin());
  if (found == cell.to.end()) {
    cell.to.push_back(to);
    cell.least.push_back(kNone);
    cell.least_point.push_back(-1);
    cell.heap.emplace_back();
  }
  return slot;
}

void ExchangeGraph::insert(Index site, Index to, const Entry& entry) {
  Cell& c = cell(site);
  const std::size_t slot = at(slot_of(c, to));
  c.heap[slot].push_back(entry);
  std::push_heap(c.heap[slot].begin(), c.heap[slot].end(), std::greater<>());
  ++c.entries;
  if (entry < Entry{c.least[slot], c.least_point[slot]} || c.least_point[slot] < 0) {
    c.least[slot] = entry.key;
    c.least_point[slot] = entry.point;
  }
}

/// Drops what is stale in front of a heap.
void ExchangeGraph::refresh(Index site, std::size_t slot) {
  Cell& c = cell(site);
  std::vector<Entry>& heap = c.heap[slot];
  while (!heap.empty() && owners_[at(heap.front().point)] != site) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    heap.pop_back();
    --c.entries;
    if (c.stale > 0) --c.stale;  // of a point that came back twice, one entry is counted
  }
  c.least[slot] = heap.empty() ? kNone : heap.front().key;
  c.least_point[slot] = heap.empty() ? -1 : heap.front().point;
}

/// Drops all that is stale in a cell, and all but one entry of points that have come back to it.
void ExchangeGraph::sweep(Index site) {
  Cell& c = cell(site);
  c.entries = 0;
  c.stale = 0;
  for (std::vector<Entry>& heap : c.heap) {
    std::erase_if(heap, [&](const Entry& entry) { return owners_[at(entry.point)] != site; });
    std::sort(heap.begin(), heap.end());
    heap.erase(std::unique(heap.begin(), heap.end()), heap.end());
    c.entries += heap.size();
  }
}

void ExchangeGraph::add(const Offer& offer) {
  std::int64_t& first = first_option_[at(offer.point)];
  if (first < 0) {
    first = static_cast<std::int64_t>(options_.size());
    options_.push_back({offer.owner, -1, 0});
  }
  Option& owner = options_[static_cast<std::size_t>(first)];
  const Option option{offer.to, owner.next, own_key_[at(offer.point)] + offer.key};
  owner.next = static_cast<std::int64_t>(options_.size());
  options_.push_back(option);
  insert(offer.owner, offer.to, {offer.key, offer.point});
}

void ExchangeGraph::move(Index point, Index from, Index to) {
  owners_[at(point)] = to;
  --count_[at(from)];
  ++count_[at(to)];
  double& own_key = own_key_[at(point)];
  const auto for_options = [&](auto visit) {
    for (std::int64_t o = first_option_[at(point)]; o >= 0;) {
      const Option& option = options_[static_cast<std::size_t>(o)];
      o = option.next;
      visit(option);
    }
  };
  for_options([&](const Option& option) {
    if (option.to == to) own_key = option.key;
  });
  Cell& source = cell(from);
  for_options([&](const Option& option) {
    if (option.to != from) {
      ++source.stale;
      const std::size_t slot = at(slot_of(source, option.to));
      if (source.least_point[slot] == point) refresh(from, slot);
    }
    if (option.to != to) insert(to, option.to, {option.key - own_key, point});
  });
  if (source.stale > source.entries / 2) sweep(from);
}

/// Reaches `to` along an edge of `from`, if that is the shortest way so far.
void ExchangeGraph::relax(Index from, Index slot, Index to, double distance) {
  if (!(distance < distance_[at(to)])) return;
  if (state_[at(to)] == 0) {
    state_[at(to)] = 1;
    seen_.push_back(to);
  }
  distance_[at(to)] = distance;
  parent_[at(to)] = {from, slot};
  heap_.emplace_back(distance, to);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

ExchangeGraph::Search ExchangeGraph::find_path(Index source, double budget, double& length) {
  for (const Index s : seen_) {
    state_[at(s)] = 0;
    distance_[at(s)] = kNone;
  }
  seen_.assign(1, source);
  settled_.clear();
  heap_.clear();
  distance_[at(source)] = 0;
  heap_.emplace_back(0.0, source);
  // With a path of length l, the weight of a settled site falls by l less its distance.
  double longest = kNone;
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const auto [distance, i] = heap_.back();
    heap_.pop_back();
    if (state_[at(i)] == 2) continue;
    if (distance > longest) {
      length = longest;
      return Search::exhausted;
    }
    state_[at(i)] = 2;
    settled_.push_back(i);
    // Never below `distance`, whatever rounding has done to a reduced cost.
    if (i == hub()) {
      const double base = distance + hub_weight_;
      for (Index a = 0; a < hub(); ++a) {
        if (has_more(a)) relax(i, -1, a, std::max(distance, base - weights_[at(a)]));
      }
      continue;
    }
    if (surplus(i) < 0) {
      length = distance;
      return Search::found;
    }
    longest =
        std::min(longest, std::max(distance, budget + distance + weights_[at(i)] - start_[at(i)]));
    const Cell& c = cell(i);
    const double base = distance + weights_[at(i)];
    for (std::size_t slot = 0; slot < c.to.size(); ++slot) {
      const Index j = c.to[slot];
      relax(i, static_cast<Index>(slot), j,
            std::max(distance, base + c.least[slot] - weights_[at(j)]));
    }
    if (floating_ && !has_more(i)) relax(i, -1, hub(), std::max(distance, base - hub_weight_));
  }
  return Search::closed;
}

void ExchangeGraph::lower_weights(double length) {
  for (const Index s : settled_) {
    (s == hub() ? hub_weight_ : weights_[at(s)]) += std::min(0.0, distance_[at(s)] - length);
  }
}

void ExchangeGraph::lower_reached(double amount) {
  for (const Index s : settled_) {
    (s == hub() ? hub_weight_ : weights_[at(s)]) -= amount;
    if (s != hub()) start_[at(s)] -= amount;
  }
}

void ExchangeGraph::move_along_path(Index source, Index target) {
  for (Index j = target; j != source;) {
    const auto [i, slot] = parent_[at(j)];
    if (j == hub()) {
      ++capacities_[at(i)];
    } else if (i == hub()) {
      --capacities_[at(j)];
    } else {
      move(cell(i).least_point[at(slot)], i, j);
    }
    j = i;
  }
  ++augmentations_;
}

ExchangeGraph::Outcome ExchangeGraph::settle(double budget, const Arena& arena) {
  Outcome outcome = Outcome::settled;
  for (Index s = 0; s < static_cast<Index>(cells_.size()); ++s) {
    while (surplus(s) > 0) {
      arena.check();
      double length = 0;
      const Search search = find_path(s, budget, length);
      if (search == Search::closed) return Outcome::closed;
      lower_weights(length);
      if (search == Search::exhausted) {
        outcome = Outcome::exhausted;
        break;
      }
      move_along_path(s, settled_.back());
    }
  }
  return outcome;
}

}  // namespace ccvt
