#include "exact/exchange.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "cell_sizes.h"

namespace ccvt {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();
/// The slot of an edge of the hub, which has none.
constexpr std::size_t kNoSlot = 0;

}  // namespace

ExchangeGraph::ExchangeGraph(std::vector<Index>& capacities, bool floating,
                             std::vector<Index>& owners, std::vector<double>& weights)
    : capacities_(capacities),
      floating_(floating),
      owners_(owners),
      weights_(weights),
      cells_(capacities.size()),
      first_option_(owners.size(), kNoOption),
      own_key_(owners.size(), 0.0),
      loading_slots_(capacities.size(), kNoOption),
      count_(cell_sizes(owners, capacities.size())),
      start_(weights),
      distance_(capacities.size() + 1, kNone),
      parent_(capacities.size() + 1),
      state_(capacities.size() + 1, 0) {
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

std::size_t ExchangeGraph::slot_of(Cell& cell, SiteNumber to) {
  std::size_t slot = 0;
  while (slot < cell.to.size() && cell.to[slot] != to) ++slot;
  if (slot == cell.to.size()) {
    cell.to.push_back(to);
    cell.least.push_back(kNone);
    cell.least_point.push_back(kNoPoint);
    cell.heap.emplace_back();
  }
  return slot;
}

/// The same for many offers of one site after the other, without a search for each.
std::size_t ExchangeGraph::loading_slot(SiteNumber site, SiteNumber to) {
  if (site != loading_site_) {
    if (loading_site_ != SiteNumber::none()) {
      for (const SiteNumber j : cells_[loading_site_].to) loading_slots_[j] = kNoOption;
    }
    for (std::size_t slot = 0; slot < cells_[site].to.size(); ++slot) {
      loading_slots_[cells_[site].to[slot]] = slot;
    }
    loading_site_ = site;
  }
  if (loading_slots_[to] == kNoOption) loading_slots_[to] = slot_of(cells_[site], to);
  return loading_slots_[to];
}

/// Ends loading: all heaps at once, in linear time.
void ExchangeGraph::load() {
  if (!loading_) return;
  loading_ = false;
  for (Cell& c : cells_) {
    for (std::vector<Entry>& heap : c.heap) {
      std::make_heap(heap.begin(), heap.end(), std::greater<>());
    }
  }
}

void ExchangeGraph::insert(SiteNumber site, SiteNumber to, const Entry& entry) {
  Cell& c = cells_[site];
  const std::size_t slot = loading_ ? loading_slot(site, to) : slot_of(c, to);
  c.heap[slot].push_back(entry);
  if (!loading_) std::push_heap(c.heap[slot].begin(), c.heap[slot].end(), std::greater<>());
  ++c.entries;
  if (entry < Entry{c.least[slot], c.least_point[slot]} || c.least_point[slot] == kNoPoint) {
    c.least[slot] = entry.key;
    c.least_point[slot] = entry.point;
  }
}

/// Drops what is stale in front of a heap.
void ExchangeGraph::refresh(SiteNumber site, std::size_t slot) {
  Cell& c = cells_[site];
  std::vector<Entry>& heap = c.heap[slot];
  while (!heap.empty() && owner_of(heap.front().point) != site) {
    std::pop_heap(heap.begin(), heap.end(), std::greater<>());
    heap.pop_back();
    --c.entries;
    if (c.stale > 0) --c.stale;  // of a point that came back twice, one entry is counted
  }
  c.least[slot] = heap.empty() ? kNone : heap.front().key;
  c.least_point[slot] = heap.empty() ? kNoPoint : heap.front().point;
}

/// Drops all that is stale in a cell, and all but one entry of points that have come back to it.
void ExchangeGraph::sweep(SiteNumber site) {
  Cell& c = cells_[site];
  c.entries = 0;
  c.stale = 0;
  for (std::vector<Entry>& heap : c.heap) {
    std::erase_if(heap, [&](const Entry& entry) { return owner_of(entry.point) != site; });
    std::sort(heap.begin(), heap.end());
    heap.erase(std::unique(heap.begin(), heap.end()), heap.end());
    c.entries += heap.size();
  }
}

void ExchangeGraph::add(const Offer& offer) {
  std::size_t& first = first_option_[offer.point];
  if (first == kNoOption) {
    first = options_.size();
    options_.push_back({offer.owner, kNoOption, 0});
  }
  Option& owner = options_[first];
  const Option option{offer.to, owner.next, own_key_[offer.point] + offer.key};
  owner.next = options_.size();
  options_.push_back(option);
  insert(offer.owner, offer.to, {offer.key, offer.point});
}

void ExchangeGraph::move(PointNumber point, SiteNumber from, SiteNumber to) {
  owners_[point] = to.index();
  --count_[from];
  ++count_[to];
  double& own_key = own_key_[point];
  const auto for_options = [&](auto visit) {
    for (std::size_t o = first_option_[point]; o != kNoOption;) {
      const Option& option = options_[o];
      o = option.next;
      visit(option);
    }
  };
  for_options([&](const Option& option) {
    if (option.to == to) own_key = option.key;
  });
  Cell& source = cells_[from];
  for_options([&](const Option& option) {
    if (option.to != from) {
      ++source.stale;
      const std::size_t slot = slot_of(source, option.to);
      if (source.least_point[slot] == point) refresh(from, slot);
    }
    if (option.to != to) insert(to, option.to, {option.key - own_key, point});
  });
  if (source.stale > source.entries / 2) sweep(from);
}

/// Reaches `to` along an edge of `from`, if that is the shortest way so far.
void ExchangeGraph::relax(SiteNumber from, std::size_t slot, SiteNumber to, double distance) {
  if (!(distance < distance_[to])) return;
  if (state_[to] == 0) {
    state_[to] = 1;
    seen_.push_back(to);
  }
  distance_[to] = distance;
  parent_[to] = {from, slot};
  heap_.emplace_back(distance, to);
  std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
}

ExchangeGraph::Search ExchangeGraph::find_path(SiteNumber source, double budget, double& length) {
  for (const SiteNumber s : seen_) {
    state_[s] = 0;
    distance_[s] = kNone;
  }
  seen_.assign(1, source);
  settled_.clear();
  heap_.clear();
  distance_[source] = 0;
  heap_.emplace_back(0.0, source);
  // With a path of length l, the weight of a settled site falls by l less its distance.
  double longest = kNone;
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    const auto [distance, i] = heap_.back();
    heap_.pop_back();
    if (state_[i] == 2) continue;
    if (distance > longest) {
      length = longest;
      return Search::exhausted;
    }
    state_[i] = 2;
    settled_.push_back(i);
    // Never below `distance`, whatever rounding has done to a reduced cost.
    if (i == hub()) {
      const double base = distance + hub_weight_;
      for (const SiteNumber a : sites_below(cells_.size())) {
        if (has_more(a)) relax(i, kNoSlot, a, std::max(distance, base - weights_[a]));
      }
      continue;
    }
    if (surplus(i) < 0) {
      length = distance;
      return Search::found;
    }
    longest = std::min(longest, std::max(distance, budget + distance + weights_[i] - start_[i]));
    const Cell& c = cells_[i];
    const double base = distance + weights_[i];
    for (std::size_t slot = 0; slot < c.to.size(); ++slot) {
      const SiteNumber j = c.to[slot];
      relax(i, slot, j, std::max(distance, base + c.least[slot] - weights_[j]));
    }
    if (floating_ && !has_more(i)) relax(i, kNoSlot, hub(), std::max(distance, base - hub_weight_));
  }
  return Search::closed;
}

void ExchangeGraph::lower_weights(double length) {
  for (const SiteNumber s : settled_) {
    (s == hub() ? hub_weight_ : weights_[s]) += std::min(0.0, distance_[s] - length);
  }
}

void ExchangeGraph::lower_reached(double amount) {
  for (const SiteNumber s : settled_) {
    (s == hub() ? hub_weight_ : weights_[s]) -= amount;
    if (s != hub()) start_[s] -= amount;
  }
}

void ExchangeGraph::move_along_path(SiteNumber source, SiteNumber target) {
  for (SiteNumber j = target; j != source;) {
    const auto [i, slot] = parent_[j];
    if (j == hub()) {
      ++capacities_[i];
    } else if (i == hub()) {
      --capacities_[j];
    } else {
      move(cells_[i].least_point[slot], i, j);
    }
    j = i;
  }
  ++augmentations_;
}

ExchangeGraph::Outcome ExchangeGraph::settle(double budget, const Arena& arena) {
  load();
  Outcome outcome = Outcome::settled;
  for (const SiteNumber s : sites_below(cells_.size())) {
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
