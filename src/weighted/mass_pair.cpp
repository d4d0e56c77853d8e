#include "weighted/mass_pair.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "rounding.h"
#include "weighted/mass_sum.h"

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
  const Metric& metric = cells.metric();
  const double* const first = cells.sites().at(i);
  const double* const second = cells.sites().at(j);
  const double around = metric.largest_extent() * metric.largest_extent();
  members_.clear();
  for (const SiteNumber s : {i, j}) {
    for (const PointNumber p : cells.members(s)) {
      const double to_first = metric.squared_distance(cells.at(p), first);
      const double to_second = metric.squared_distance(cells.at(p), second);
      members_.push_back(
          {to_first - to_second, cells.mass(p), to_first + to_second + around, p, s == i});
    }
    if (s == i) in_first_ = members_.size();
  }
  first_error_ = cells.error(i);
  slack_ = kSlack * (cells.held(i) + cells.held(j)) / static_cast<double>(members_.size());
  margin_ = cells.margin(i) + cells.margin(j);
}

/// Sorts the members that are no heavier than that by key; the others stay where they are.
template <class Scalar>
void MassPair<Scalar>::sort_light(double heaviest) {
  sorted_.clear();
  MassSum sorted_in_first;
  for (std::size_t k = 0; k < members_.size(); ++k) {
    if (members_[k].mass > heaviest) continue;
    sorted_.push_back(static_cast<std::uint32_t>(k));
    if (members_[k].in_first) sorted_in_first.add(members_[k].mass);
  }
  first_base_ = first_error_ - sorted_in_first.value();
  std::sort(sorted_.begin(), sorted_.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Member& x = members_[a];
    const Member& y = members_[b];
    return x.key != y.key ? x.key < y.key : x.point < y.point;
  });
}

template <class Scalar>
typename MassPair<Scalar>::Window MassPair<Scalar>::window(const MassCells<Scalar>& cells,
                                                           SiteNumber i, SiteNumber j) const {
  const double first = cells.error(i);
  const double second = cells.error(j);
  const double middle = (first + second) / 2;
  const double apart = std::abs(first - second) / 2;
  const double largest = std::max({std::abs(first), std::abs(second), slack_});
  const double room = std::max(apart, std::min(slack_, largest - std::abs(middle))) +
                      kMassRounding * (cells.held(i) + cells.held(j));
  const double most = cells.error_bound();
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
    if (found && members_[sorted_[place]].key >= 0) break;
    error += members_[sorted_[place]].mass;
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
    reached += members_[sorted_[place]].mass;
    if (std::abs(reached - error) >= std::abs(cut.first_error - error)) continue;
    cut.place = place + 1;
    cut.first_error = reached;
  }
}

template <class Scalar>
bool MassPair<Scalar>::gains(const Cut& cut) const {
  double gain = 0;
  double reach = 0;
  for (std::size_t k = 0; k < sorted_.size(); ++k) {
    const Member& member = members_[sorted_[k]];
    if (member.in_first == (k < cut.place)) continue;
    gain += member.mass * (member.in_first ? member.key : -member.key);
    reach += member.mass * member.reach;
  }
  const double terms = static_cast<double>(sorted_.size()) + 16;
  return gain > margin_ + 4 * terms * kHalfUlp * reach;
}

/// Of moving one point, or exchanging two, such that the error of i is in the window, what saves
/// most. Both cells are run through by ascending mass: the points of j that one of i can be
/// exchanged for are then a stretch that only moves on, and the best of a stretch is the first of a
/// queue of those that no later one is better than. A point of no mass stands for none.
template <class Scalar>
typename MassPair<Scalar>::Exchange MassPair<Scalar>::best_exchange(const Window& window) const {
  const std::size_t none = members_.size();
  Exchange best{none, none, 0};
  // Index 0 is none; k is member k - 1 of the cell.
  const auto mass_in = [&](std::size_t cell_begin, std::size_t k) {
    return k == 0 ? 0.0 : members_[cell_begin + k - 1].mass;
  };
  const auto saved = [&](std::size_t k) {
    return k == 0 ? 0.0 : -members_[in_first_ + k - 1].mass * members_[in_first_ + k - 1].key;
  };
  const std::size_t others = members_.size() - in_first_ + 1;
  std::deque<std::size_t> queue;
  std::size_t next = 0;
  for (std::size_t a = 0; a <= in_first_; ++a) {
    const double given = mass_in(0, a);
    const double low = window.low - first_error_ + given;
    const double high = window.high - first_error_ + given;
    for (; next < others && mass_in(in_first_, next) <= high; ++next) {
      while (!queue.empty() && saved(queue.back()) < saved(next)) queue.pop_back();
      queue.push_back(next);
    }
    while (!queue.empty() && mass_in(in_first_, queue.front()) < low) queue.pop_front();
    if (queue.empty()) continue;
    const double gain =
        saved(queue.front()) + (a == 0 ? 0.0 : members_[a - 1].mass * members_[a - 1].key);
    if (!(gain > best.gain)) continue;
    best = {a == 0 ? none : a - 1, queue.front() == 0 ? none : in_first_ + queue.front() - 1, gain};
  }
  return best;
}

template <class Scalar>
bool MassPair<Scalar>::gains(const Exchange& exchange) const {
  double reach = 0;
  for (const std::size_t k : {exchange.from_first, exchange.from_second}) {
    if (k < members_.size()) reach += members_[k].mass * members_[k].reach;
  }
  return exchange.gain > margin_ + 64 * kHalfUlp * reach;
}

template <class Scalar>
Index MassPair<Scalar>::apply(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j,
                              const Cut& cut) {
  to_first_.resize(members_.size());
  for (std::size_t k = 0; k < members_.size(); ++k) to_first_[k] = members_[k].in_first ? 1 : 0;
  for (std::size_t k = 0; k < sorted_.size(); ++k) to_first_[sorted_[k]] = k < cut.place ? 1 : 0;
  return give(cells, i, j);
}

template <class Scalar>
Index MassPair<Scalar>::apply(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j,
                              const Exchange& exchange) {
  to_first_.resize(members_.size());
  for (std::size_t k = 0; k < members_.size(); ++k) to_first_[k] = members_[k].in_first ? 1 : 0;
  if (exchange.from_first < members_.size()) to_first_[exchange.from_first] = 0;
  if (exchange.from_second < members_.size()) to_first_[exchange.from_second] = 1;
  return give(cells, i, j);
}

template <class Scalar>
Index MassPair<Scalar>::give(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  std::vector<PointNumber> first;
  std::vector<PointNumber> second;
  Index moved = 0;
  for (std::size_t k = 0; k < members_.size(); ++k) {
    (to_first_[k] != 0 ? first : second).push_back(members_[k].point);
    if (members_[k].in_first != (to_first_[k] != 0)) ++moved;
  }
  cells.set_members(i, std::move(first));
  cells.set_members(j, std::move(second));
  return moved;
}

template <class Scalar>
Index MassPair<Scalar>::improve(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  look(cells, i, j);
  const Window allowed = window(cells, i, j);
  const double jump = allowed.high - allowed.low;
  for (const double heaviest : {std::numeric_limits<double>::infinity(), jump}) {
    Cut cut;
    sort_light(heaviest);
    if (cheapest_cut(allowed, cut) && gains(cut)) return apply(cells, i, j, cut);
    if (cells.heaviest() <= jump) break;  // the other would be the same
  }
  const Exchange exchange = best_exchange(allowed);
  return gains(exchange) ? apply(cells, i, j, exchange) : 0;
}

template <class Scalar>
bool MassPair<Scalar>::even_out(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) {
  const double middle = (cells.error(i) + cells.error(j)) / 2;
  const double apart = std::abs(cells.error(i) - middle);
  if (cells.members(i).empty() && cells.members(j).empty()) return false;
  look(cells, i, j);
  if (apart <= slack_) return false;
  for (const double heaviest : {std::numeric_limits<double>::infinity(), apart}) {
    Cut cut;
    sort_light(heaviest);
    nearest_cut(middle, cut);
    if (std::abs(cut.first_error - middle) > kNearer * apart) continue;
    apply(cells, i, j, cut);
    return true;
  }
  return false;
}

template class MassPair<float>;
template class MassPair<double>;

}  // namespace ccvt
