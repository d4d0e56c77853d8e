#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "random.h"
#include "streams.h"

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

/// A uniform draw from one of `bins` equal parts of [0, 1).
inline double draw_from(std::size_t bin, std::size_t bins, Random& random) {
  return (static_cast<double>(bin) + random.uniform()) / static_cast<double>(bins);
}

/// The random numbers of a bin, those of no other.
inline Random random_of_bin(std::uint64_t seed, std::uint64_t bin) {
  const bool far = bin >= streams::room;
  return Random(seed, (far ? streams::density_far_mass : streams::density_mass) + bin);
}

/// Independent uniform draws from [0, 1) in ascending order, which may be entered anywhere: draws
/// are first dealt to equal bins, then drawn and sorted within a bin. O(1) each.
class SortedDraws {
 public:
  SortedDraws(std::uint64_t seed, std::int64_t count, const Arena& arena) : seed_(seed) {
    constexpr std::size_t chunk = 65'536;
    const auto draws = static_cast<std::size_t>(count);
    before_.resize(draws / 16 + 2);
    arena.for_each((draws + chunk - 1) / chunk, 1, [&](std::size_t c) {
      Random random(seed, streams::density_deal + c);
      for (std::size_t k = c * chunk; k < std::min((c + 1) * chunk, draws); ++k) {
        // Counts are whole numbers: the order of threads does not show in them.
        std::atomic_ref(before_[random.below(bins()) + 1]).fetch_add(1, std::memory_order_relaxed);
      }
    });
    std::int64_t before = 0;
    for (std::size_t b = 0; b < before_.size(); ++b) {
      before += before_[b];
      if (b % kRow == 0) rows_.push_back(before);
      before_[b] = static_cast<std::uint32_t>(before - rows_.back());
    }
  }

  [[nodiscard]] std::size_t bins() const { return before_.size() - 1; }
  /// The number of draws in the bins before this one.
  [[nodiscard]] std::int64_t before(std::size_t bin) const {
    return rows_[bin / kRow] + before_[bin];
  }
  /// Puts the draws of a bin into `draws`.
  void open(std::size_t bin, std::vector<double>& draws) const {
    Random random = random_of_bin(seed_, bin);
    draws.resize(static_cast<std::size_t>(before(bin + 1) - before(bin)));
    for (double& draw : draws) draw = draw_from(bin, bins(), random);
    std::sort(draws.begin(), draws.end());
  }

 private:
  static constexpr std::size_t kRow = 65'536;

  std::uint64_t seed_;
  std::vector<std::int64_t> rows_;     ///< draws before each kRow bins
  std::vector<std::uint32_t> before_;  ///< and before each bin since then, a million on average
};

/// One uniform draw from each of `count` equal parts of [0, 1): bins of one draw each.
class StratifiedDraws {
 public:
  StratifiedDraws(std::uint64_t seed, std::int64_t count)
      : seed_(seed), bins_(static_cast<std::size_t>(count)) {}

  [[nodiscard]] std::size_t bins() const { return bins_; }
  [[nodiscard]] static std::int64_t before(std::size_t bin) {
    return static_cast<std::int64_t>(bin);
  }
  void open(std::size_t bin, std::vector<double>& draws) const {
    Random random = random_of_bin(seed_, bin);
    draws.assign(1, draw_from(bin, bins_, random));
  }

 private:
  std::uint64_t seed_;
  std::size_t bins_;
};

/// Where groups begin that share a line in proportion to their masses, of which some is positive.
struct Shares {
  explicit Shares(std::span<const double> masses) : begin(masses.size() + 1) {
    GroupedSum sum;
    for (std::size_t g = 0; g < masses.size(); ++g) {
      sum.add(masses[g]);
      begin[g + 1] = sum.value();
      if (begin[g + 1] > begin[g]) last = g;
    }
  }
  [[nodiscard]] double total() const { return begin.back(); }

  std::vector<double> begin;  ///< of each group, and one more
  std::size_t last = 0;       ///< the last group that can get any
};

/// Deals draws from [0, 1) to groups that share that line, and of these to `groups`, ascending.
/// Calls place(group, worker, first, targets) for every one of them that gets any, from several
/// threads: the number of its first draw, and for each of its draws, ascending, the mass of the
/// group that lies before it. Groups without mass get none, whatever the rounding.
template <class Draws, class Place>
void deal(const Shares& shares, std::span<const std::size_t> groups, const Draws& draws,
          const Arena& arena, const Place& place) {
  const std::vector<double>& begin = shares.begin;
  const double total = shares.total();
  const auto bins = static_cast<double>(draws.bins());
  arena.for_ranges(groups.size(), 16, [&](std::size_t from, std::size_t to, int worker) {
    std::vector<double> bin;
    std::vector<double> targets;
    for (const std::size_t g : groups.subspan(from, to - from)) {
      if (!(begin[g + 1] > begin[g])) continue;
      // One bin earlier than computed, in case that was rounded up.
      double earlier = std::max(0.0, std::floor(begin[g] / total * bins) - 1);
      auto b = static_cast<std::size_t>(earlier);
      std::int64_t first = draws.before(b);
      targets.clear();
      for (; b < draws.bins(); ++b, ++earlier) {
        if (g < shares.last && earlier / bins * total >= begin[g + 1]) break;
        draws.open(b, bin);
        for (const double draw : bin) {
          const double target = draw * total;
          if (target < begin[g]) {
            ++first;
          } else if (g == shares.last || target < begin[g + 1]) {
            targets.push_back(target - begin[g]);
          }
        }
      }
      if (!targets.empty()) place(g, worker, first, std::span<const double>(targets));
    }
  });
}

/// The same, to all groups.
template <class Draws, class Place>
void deal(std::span<const double> masses, const Draws& draws, const Arena& arena,
          const Place& place) {
  std::vector<std::size_t> groups(masses.size());
  std::iota(groups.begin(), groups.end(), std::size_t{0});
  deal(Shares(masses), groups, draws, arena, place);
}

/// Deals ascending targets to the cells of a group: visit_cells(f) calls f(cell, mass) for each
/// cell in order, and place(cell, hits) is called for those that get any. Cells without mass get
/// none, whatever the rounding.
template <class VisitCells, class Place>
void deal_to_cells(std::span<const double> targets, const VisitCells& visit_cells,
                   const Place& place) {
  GroupedSum reached;
  std::size_t dealt = 0;
  std::int64_t last = 0;
  visit_cells([&](std::int64_t cell, double mass) {
    if (!(mass > 0)) return;
    last = cell;
    reached.add(mass);
    const double end = reached.value();
    std::int64_t hits = 0;
    for (; dealt < targets.size() && targets[dealt] < end; ++dealt) ++hits;
    if (hits > 0) place(cell, hits);
  });
  // The sum in this order may fall short of the group's mass by its rounding error.
  const auto left = static_cast<std::int64_t>(targets.size() - dealt);
  if (left > 0) place(last, left);
}

}  // namespace ccvt
