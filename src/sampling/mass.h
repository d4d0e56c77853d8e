#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "ccvt/types.h"
#include "random.h"

namespace ccvt {

/// Adds up many terms in groups, which keeps rounding errors near those of a single group.
class GroupedSum {
 public:
  void add(double term) {
    group_ += term;
    if (++terms_ == 1024) {
      done_ += group_;
      group_ = 0;
      terms_ = 0;
    }
  }
  [[nodiscard]] double value() const { return done_ + group_; }

 private:
  double done_ = 0;
  double group_ = 0;
  int terms_ = 0;
};

/// Independent uniform draws from [0, 1) in ascending order, in O(1) each: the draws are first
/// dealt to equal bins, then drawn and sorted within one bin after the other.
class SortedDraws {
 public:
  SortedDraws(const Random& random, Index count)
      : random_(random), bins_(static_cast<std::size_t>(count) / 16 + 1) {
    for (Index k = 0; k < count; ++k) ++bins_[random_.below(bins_.size())];
  }

  /// May be called `count` times.
  double next() {
    while (pending_.empty()) {
      pending_.resize(bins_[bin_]);
      for (double& draw : pending_) draw = random_.uniform();
      std::sort(pending_.begin(), pending_.end(), std::greater<>());
      ++bin_;
    }
    const double within = pending_.back();
    pending_.pop_back();
    return (static_cast<double>(bin_ - 1) + within) / static_cast<double>(bins_.size());
  }

 private:
  Random random_;
  std::vector<std::uint32_t> bins_;  // draws in each
  std::size_t bin_ = 0;              // the next one to open
  std::vector<double> pending_;      // what is left of the open bin, descending
};

/// One uniform draw from each of `count` equal parts of [0, 1), in ascending order.
class StratifiedDraws {
 public:
  StratifiedDraws(const Random& random, Index count) : random_(random), count_(count) {}

  double next() {
    const double within = random_.uniform();
    return (static_cast<double>(part_++) + within) / count_;
  }

 private:
  Random random_;
  double count_;
  Index part_ = 0;
};

/// Deals `count` draws to cells by mass: visit_cells(f) calls f(cell, mass) for each cell in order,
/// `total` is the sum of the masses, and place(cell, hits) is called for cells that get any. Cells
/// without mass get none, whatever the rounding.
template <class VisitCells, class Draws, class Place>
void deal(double total, Index count, const VisitCells& visit_cells, Draws draws,
          const Place& place) {
  GroupedSum reached;
  Index dealt = 0;
  std::int64_t last = 0;
  double target = draws.next() * total;
  visit_cells([&](std::int64_t cell, double mass) {
    if (!(mass > 0)) return;
    last = cell;
    reached.add(mass);
    const double end = reached.value();
    Index hits = 0;
    while (dealt < count && target < end) {
      ++hits;
      if (++dealt < count) target = draws.next() * total;
    }
    if (hits > 0) place(cell, hits);
  });
  // The sum in this order may fall short of `total` by its rounding error.
  if (dealt < count) place(last, count - dealt);
}

}  // namespace ccvt
