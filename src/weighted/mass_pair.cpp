#include "weighted/mass_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensated_sum.h"
#include "rounding.h"

namespace ccvt {
namespace {

/// Sums of masses are off by so much of them, or less.
constexpr double kMassRounding = 64 * kHalfUlp;
/// Errors have come nearer when no more than this share of their distance is left.
constexpr double kNearer = 0.75;

}  // namespace

/// The keys of the points of both, and what is known of the pair.
template <class Scalar>
void MassPair<Scalar>::look(const MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  cells_ = &cells;
  i_ = i;
  j_ = j;
  first_masses_ = cells.masses(i);
  second_masses_ = cells.masses(j);
  keys_.assign(first_masses_.size() + second_masses_.size(), 0.0);
  find_keys(i);
  find_keys(j);
  highest_in_first_ = -std::numeric_limits<double>::infinity();
  lowest_in_second_ = std::numeric_limits<double>::infinity();
  const std::size_t count = first_masses_.size();
  for (std::size_t k = 0; k < count; ++k) highest_in_first_ = std::max(highest_in_first_, keys_[k]);
  for (std::size_t k = count; k < keys_.size(); ++k) {
    lowest_in_second_ = std::min(lowest_in_second_, keys_[k]);
  }
  slack_ = kSlack * (cells.held(i) + cells.held(j)) / static_cast<double>(keys_.size());
  margin_ = cells.margin(i) + cells.margin(j);
}

/// With a = p - s_i and b = p - s_j the key is a^2 - b^2 = (s_j - s_i) (a + b), dimension by
/// dimension.
template <class Scalar>
void MassPair<Scalar>::find_keys(SiteNumber site) {
  const Metric& metric = cells_->metric();
  const std::size_t count = cells_->members(site).size();
  const double* const first = cells_->sites().at(i_);
  const double* const second = cells_->sites().at(j_);
  double* const keys = keys_.data() + (site == i_ ? 0 : first_masses_.size());
  const Scalar* stream = cells_->block(site);
  for (int d = 0; d < metric.dimension(); ++d, stream += count) {
    const double to_first = first[d];
    const double to_second = second[d];
    const double between = to_second - to_first;
    if (!metric.periodic()) {
      for (std::size_t k = 0; k < count; ++k) {
        const double x = stream[k];
        keys[k] += between * ((x - to_first) + (x - to_second));
      }
      continue;
    }
    const double extent = metric.extent()[d];
    for (std::size_t k = 0; k < count; ++k) {
      const double x = stream[k];
      const double a = shortest_distance(x - to_first, extent);
      const double b = shortest_distance(x - to_second, extent);
      keys[k] += (a - b) * (a + b);
    }
  }
}

template <class Scalar>
PointNumber MassPair<Scalar>::point(Member k) const {
  return in_first(k) ? cells_->members(i_)[k] : cells_->members(j_)[k - first_masses_.size()];
}

template <class Scalar>
double MassPair<Scalar>::reach(Member k) const {
  const Metric& metric = cells_->metric();
  const Scalar* const x = cells_->at(point(k));
  const double around = metric.largest_extent() * metric.largest_extent();
  return mass(k) * (metric.squared_distance(x, cells_->sites().at(i_)) +
                    metric.squared_distance(x, cells_->sites().at(j_)) + around);
}

template <class Scalar>
bool MassPair<Scalar>::before(const Place& a, const Place& b) const {
  return a.key != b.key ? a.key < b.key : point(a.member) < point(b.member);
}

template <class Scalar>
void MassPair<Scalar>::sort_all() {
  sorted_.clear();
  for (Member k = 0; k < keys_.size(); ++k) sorted_.push_back({keys_[k], k});
  std::sort(sorted_.begin(), sorted_.end(),
            [this](const Place& a, const Place& b) { return before(a, b); });
  find_base();
}

/// Sorts what a cut of the members no heavier than `heaviest` may move that leaves the error of i
/// in the window. Of i these are those with keys from the lowest of j on, and, as a cut below that
/// takes from i and gives it nothing, the next ones until together they are heavier than what i may
/// lose; of j likewise.
template <class Scalar>
void MassPair<Scalar>::sort_border(double heaviest, const Window& window) {
  sorted_.clear();
  // turn: 1 for cell i, of which the highest keys are next; -1 for j.
  const auto take = [&](Member begin, Member end, double turn, double beyond, double room) {
    next_.clear();  // the best one first
    double taken = 0;
    const auto better = [&](const Place& a, const Place& b) {
      return turn > 0 ? before(b, a) : before(a, b);
    };
    for (Member k = begin; k < end; ++k) {
      const Place own{keys_[k], k};
      if (mass(k) > heaviest) continue;
      if (turn * own.key >= turn * beyond) {
        sorted_.push_back(own);
        continue;
      }
      if (taken > room && !better(own, next_.back())) continue;
      next_.insert(std::lower_bound(next_.begin(), next_.end(), own, better), own);
      taken += mass(k);
      while (next_.size() > 1 && taken - mass(next_.back().member) > room) {
        taken -= mass(next_.back().member);
        next_.pop_back();
      }
    }
    sorted_.insert(sorted_.end(), next_.begin(), next_.end());
  };
  const double error = cells_->error(i_);
  const std::size_t count = first_masses_.size();
  take(0, count, 1, lowest_in_second_, std::max(0.0, error - window.low));
  take(count, keys_.size(), -1, highest_in_first_, std::max(0.0, window.high - error));
  std::sort(sorted_.begin(), sorted_.end(),
            [this](const Place& a, const Place& b) { return before(a, b); });
  find_base();
}

/// Leaves the members that are heavier where they are.
template <class Scalar>
void MassPair<Scalar>::keep_light(double heaviest) {
  std::erase_if(sorted_, [&](const Place& k) { return mass(k.member) > heaviest; });
  find_base();
}

template <class Scalar>
void MassPair<Scalar>::find_base() {
  CompensatedSum sorted_in_first;
  for (const Place& k : sorted_) {
    if (in_first(k.member)) sorted_in_first.add(mass(k.member));
  }
  first_base_ = cells_->error(i_) - sorted_in_first.value();
}

template <class Scalar>
typename MassPair<Scalar>::Window MassPair<Scalar>::window() const {
  const double first = cells_->error(i_);
  const double second = cells_->error(j_);
  const double middle = (first + second) / 2;
  const double apart = std::abs(first - second) / 2;
  const double largest = std::max({std::abs(first), std::abs(second), slack_});
  const double room = std::max(apart, std::min(slack_, largest - std::abs(middle))) +
                      kMassRounding * (cells_->held(i_) + cells_->held(j_));
  const double most = cells_->error_bound();
  return {std::max({middle - room, -most, 2 * middle - most}),
          std::min({middle + room, most, 2 * middle + most})};
}

/// Of the cuts that leave the error of i in the window, the one with the least energy: where keys
/// change their sign, or as near to that as the window allows. False when there is none.
template <class Scalar>
bool MassPair<Scalar>::cheapest_cut(const Window& window, Cut& cut) const {
  double error = first_base_;
  bool found = false;
  for (std::size_t place = 0;; ++place) {
    if (error > window.high) break;
    if (error >= window.low) {
      found = true;
      cut.place = place;
      cut.first_error = error;
    }
    if (place == sorted_.size()) break;
    if (found && sorted_[place].key >= 0) break;
    error += mass(sorted_[place].member);
  }
  return found;
}

/// The cut that leaves the error of i nearest to `error`.
template <class Scalar>
void MassPair<Scalar>::nearest_cut(double error, Cut& cut) const {
  double reached = first_base_;
  cut.place = 0;
  cut.first_error = reached;
  for (std::size_t place = 0; place < sorted_.size(); ++place) {
    reached += mass(sorted_[place].member);
    if (std::abs(reached - error) >= std::abs(cut.first_error - error)) continue;
    cut.place = place + 1;
    cut.first_error = reached;
  }
}

template <class Scalar>
bool MassPair<Scalar>::gains(const Cut& cut) const {
  double gain = 0;
  for (std::size_t k = 0; k < sorted_.size(); ++k) {
    if (in_first(sorted_[k].member) != (k < cut.place)) gain += saved(sorted_[k].member);
  }
  if (!(gain > margin_)) return false;
  double all_reach = 0;
  for (std::size_t k = 0; k < sorted_.size(); ++k) {
    if (in_first(sorted_[k].member) != (k < cut.place)) all_reach += reach(sorted_[k].member);
  }
  const double terms = static_cast<double>(sorted_.size()) + 16 + cells_->metric().dimension();
  return gain > margin_ + 8 * terms * kHalfUlp * all_reach;
}

/// The members that, with the best of the other cell, could save more than rounding.
template <class Scalar>
void MassPair<Scalar>::keep_promising() {
  const std::size_t count = first_masses_.size();
  double most_of_first = 0;
  double most_of_second = 0;
  for (Member k = 0; k < count; ++k) {
    most_of_first = std::max(most_of_first, first_masses_[k] * keys_[k]);
  }
  for (Member k = count; k < keys_.size(); ++k) {
    most_of_second = std::max(most_of_second, -second_masses_[k - count] * keys_[k]);
  }
  promising_.clear();
  for (Member k = 0; k < count; ++k) {
    if (first_masses_[k] * keys_[k] + most_of_second > margin_) promising_.push_back(k);
  }
  promising_in_first_ = promising_.size();
  for (Member k = count; k < keys_.size(); ++k) {
    if (most_of_first - second_masses_[k - count] * keys_[k] > margin_) promising_.push_back(k);
  }
}

/// Of moving one point, or exchanging two, such that the error of i is in the window, what saves
/// most. Both cells are run through by ascending mass: the points of j that one of i can be
/// exchanged for are then a stretch that only moves on, and the best of a stretch is the first of a
/// queue of those that no later one is better than. A point of no mass stands for none.
template <class Scalar>
typename MassPair<Scalar>::Exchange MassPair<Scalar>::best_exchange(const Window& window) {
  const Member none = keys_.size();
  Exchange best{none, none, 0};
  keep_promising();
  const std::span<const Member> all(promising_);
  const auto first = all.first(promising_in_first_);
  const auto second = all.subspan(promising_in_first_);
  // 0 is none; k is the (k - 1)-th of them.
  const auto mass_in = [&](std::span<const Member> of, std::size_t k) {
    return k == 0 ? 0.0 : mass(of[k - 1]);
  };
  const auto lost = [&](std::span<const Member> of, std::size_t k) {
    return k == 0 ? 0.0 : mass(of[k - 1]) * keys_[of[k - 1]];
  };
  queue_.clear();
  std::size_t front = 0;
  std::size_t next = 0;
  const double error = cells_->error(i_);
  for (std::size_t a = 0; a <= first.size(); ++a) {
    const double low = window.low - error + mass_in(first, a);
    const double high = window.high - error + mass_in(first, a);
    for (; next <= second.size() && mass_in(second, next) <= high; ++next) {
      while (queue_.size() > front && lost(second, queue_.back()) > lost(second, next)) {
        queue_.pop_back();
      }
      queue_.push_back(next);
    }
    while (front < queue_.size() && mass_in(second, queue_[front]) < low) ++front;
    if (front == queue_.size()) continue;
    const std::size_t b = queue_[front];
    const double gain = lost(first, a) - lost(second, b);
    if (!(gain > best.gain)) continue;
    best = {a == 0 ? none : first[a - 1], b == 0 ? none : second[b - 1], gain};
  }
  return best;
}

template <class Scalar>
bool MassPair<Scalar>::gains(const Exchange& exchange) const {
  if (!(exchange.gain > margin_)) return false;
  double both = 0;
  for (const Member k : {exchange.from_first, exchange.from_second}) {
    if (k < keys_.size()) both += reach(k);
  }
  const double terms = 16 + cells_->metric().dimension();
  return exchange.gain > margin_ + 8 * terms * kHalfUlp * both;
}

template <class Scalar>
void MassPair<Scalar>::stay() {
  to_first_.assign(keys_.size(), 0);
  std::fill_n(to_first_.begin(), first_masses_.size(), std::uint8_t{1});
}

template <class Scalar>
Index MassPair<Scalar>::apply(MassCells<Scalar>& cells, const Cut& cut) {
  stay();
  for (std::size_t k = 0; k < sorted_.size(); ++k) {
    to_first_[sorted_[k].member] = k < cut.place ? 1 : 0;
  }
  return give(cells);
}

template <class Scalar>
Index MassPair<Scalar>::apply(MassCells<Scalar>& cells, const Exchange& exchange) {
  stay();
  if (exchange.from_first < keys_.size()) to_first_[exchange.from_first] = 0;
  if (exchange.from_second < keys_.size()) to_first_[exchange.from_second] = 1;
  return give(cells);
}

template <class Scalar>
Index MassPair<Scalar>::give(MassCells<Scalar>& cells) {
  const std::size_t count = first_masses_.size();
  const auto by_mass = [&](Member a, Member b) {
    return mass(a) != mass(b) ? mass(a) < mass(b) : point(a) < point(b);
  };
  groups_[0].clear();
  groups_[1].clear();
  Index moved = 0;
  for (Member a = 0, b = count; a < count || b < keys_.size();) {
    const bool from_first = b == keys_.size() || (a < count && by_mass(a, b));
    const Member k = from_first ? a++ : b++;
    const bool goes_first = to_first_[k] != 0;
    groups_[goes_first ? 0 : 1].push_back(k);
    if (goes_first != from_first) ++moved;
  }
  cells.regroup(i_, j_, groups_[0], groups_[1]);
  return moved;
}

template <class Scalar>
Index MassPair<Scalar>::improve(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  look(cells, i, j);
  if (highest_in_first_ <= 0 && lowest_in_second_ >= 0) return 0;  // each point is where it is best
  const Window allowed = window();
  const double jump = allowed.high - allowed.low;
  sort_border(std::numeric_limits<double>::infinity(), allowed);
  Cut cut;
  if (cheapest_cut(allowed, cut) && gains(cut)) return apply(cells, cut);
  if (cells.heaviest() > jump) {
    sort_border(jump, allowed);
    if (cheapest_cut(allowed, cut) && gains(cut)) return apply(cells, cut);
  }
  const Exchange exchange = best_exchange(allowed);
  return gains(exchange) ? apply(cells, exchange) : 0;
}

template <class Scalar>
bool MassPair<Scalar>::even_out(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  if (cells.members(i).empty() && cells.members(j).empty()) return false;
  const double middle = (cells.error(i) + cells.error(j)) / 2;
  const double apart = std::abs(cells.error(i) - middle);
  const auto mean = (cells.held(i) + cells.held(j)) /
                    static_cast<double>(cells.members(i).size() + cells.members(j).size());
  if (apart <= kSlack * mean) return false;
  look(cells, i, j);
  sort_all();
  for (const bool light : {false, true}) {
    Cut cut;
    if (light) keep_light(apart);
    nearest_cut(middle, cut);
    if (std::abs(cut.first_error - middle) > kNearer * apart) continue;
    apply(cells, cut);
    return true;
  }
  return false;
}

template class MassPair<float>;
template class MassPair<double>;

}  // namespace ccvt
