#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "numbers.h"
#include "parallel/arena.h"
#include "relax/apart.h"
#include "relax/cells.h"
#include "relax/pair_cut.h"
#include "relax/patches.h"

namespace ccvt {

/// Of one cell of a pair, the points near the cut, copied: while the cut does not move farther than
/// the band is wide, no other point can be exchanged. Of a cell that is not divided all points are
/// looked at where they are. A copy may outlive its point in the cell
/// where rounding decides whether that was near: its key is not beyond `limit` then, and like those
/// of all points outside it never counts.
template <class Scalar>
struct BandSide {
  using Cut = typename PairCut<Scalar>::Kept;
  bool of_all = false;  ///< the cell is not divided
  bool copied = false;
  Cut cut;                    ///< as it was
  double limit = 0;           ///< on the keys, by that cut, of all points that are not in the band
  double width = 0;           ///< in keys; 0: not known yet
  std::uint32_t version = 0;  ///< of the cell's changes, and how many of them are known
  std::size_t known = 0;
  std::vector<Index> places;
  std::vector<Scalar> block;  ///< coordinates, a stream of `room` for each dimension
  std::size_t room = 0;

  /// Where a place is among `places`; their number, where it is not. Compares a few at once, by
  /// vector instructions: this is asked for each point that comes near or goes.
  [[nodiscard]] std::size_t find(Index place) const {
    constexpr std::size_t kAtOnce = 16;
    std::size_t at = 0;
    for (; at + kAtOnce <= places.size(); at += kAtOnce) {
      int found = 0;
      for (std::size_t k = 0; k < kAtOnce; ++k) found |= places[at + k] == place ? 1 : 0;
      if (found != 0) break;
    }
    while (at < places.size() && places[at] != place) ++at;
    return at;
  }

  /// Another point has come to a place of the cell; null: one that is not near the cut. False
  /// where there is no room.
  bool replace(Index place, const Scalar* coordinates, std::size_t stride, std::size_t dimension) {
    const std::size_t at = find(place);
    if (coordinates == nullptr) {
      if (at == places.size()) return true;
      places[at] = places.back();
      places.pop_back();
      for (std::size_t d = 0; d < dimension; ++d) {
        block[d * room + at] = block[d * room + places.size()];
      }
      return true;
    }
    if (at == room) return false;
    if (at == places.size()) places.push_back(place);
    for (std::size_t d = 0; d < dimension; ++d) block[d * room + at] = coordinates[d * stride];
    return true;
  }
};

template <class Scalar>
struct Band {
  double level = 0;    ///< the key where the cells met, the last time
  bool valid = false;  ///< the sides are as they should be
  SiteNumber first;    ///< whose side is i
  int uses = 0;        ///< since it was made
  int wait = 0;        ///< looks at the pair until it is made again
  int failures = 0;    ///< in a row, of bands just made
  BandSide<Scalar> i;
  BandSide<Scalar> j;
};

/// What is known of a pair of cells of which one is divided, or both are.
template <class Scalar>
struct KnownPair {
  SiteNumber other;        ///< than the smaller one
  std::uint32_t pass = 0;  ///< in which it was looked at last
  int searches = 0;        ///< of both cells, before it had a band
  Apart<Scalar> apart{};
  std::unique_ptr<Band<Scalar>> band{};
};

/// What is known of all such pairs, but for some where a cell has many. That of pairs that have no
/// cell in common may be used at the same time.
template <class Scalar>
class Bands {
 public:
  explicit Bands(std::size_t sites) : of_(sites) {}

  /// Before each pass over pairs. Where much is known, that of pairs goes which were not looked at
  /// for long, now and then. O(sites).
  void begin_pass(const Arena& arena) {
    ++pass_;
    if (pass_ % kPasses != 0) return;
    arena.for_each(of_.size(), kSitesPerGrain, [&](std::size_t s) {
      auto& pairs = of_[SiteNumber(s)];
      if (pairs.size() <= kFew) return;
      std::erase_if(pairs, [&](const auto& pair) { return pass_ - pair.pass > kPasses; });
    });
  }

  /// What is known of a pair, kept with the smaller cell. Null in the first pass, in which most
  /// pairs may meet that never do again, and where that cell has too many.
  KnownPair<Scalar>* of(const Cells<Scalar>& cells, SiteNumber i, SiteNumber j) {
    if (pass_ < 2) return nullptr;
    const auto [keeper, other] = keeper_first(cells, i, j);
    for (KnownPair<Scalar>& pair : of_[keeper]) {
      if (pair.other != other) continue;
      pair.pass = pass_;
      return &pair;
    }
    if (of_[keeper].size() >= kMost) return nullptr;
    return &of_[keeper].emplace_back(KnownPair<Scalar>{other, pass_});
  }
  /// Null where nothing is known.
  [[nodiscard]] const KnownPair<Scalar>* find(const Cells<Scalar>& cells, SiteNumber i,
                                              SiteNumber j) const {
    const auto [keeper, other] = keeper_first(cells, i, j);
    for (const KnownPair<Scalar>& pair : of_[keeper]) {
      if (pair.other == other) return &pair;
    }
    return nullptr;
  }
  void forget() noexcept {
    for (auto& pairs : of_) pairs.clear();
    pass_ = 0;
  }
  /// Has the list of the pair's keeper fetched from memory.
  void prefetch(const Cells<Scalar>& cells, SiteNumber i, SiteNumber j) const {
    __builtin_prefetch(of_[keeper_first(cells, i, j).first].data());
  }

 private:
  /// Of one cell, pairs; beyond kFew those go that were not looked at in so many passes.
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kFew = 16;
  static constexpr std::uint32_t kPasses = 16;
  static constexpr std::size_t kSitesPerGrain = 1024;

  static std::pair<SiteNumber, SiteNumber> keeper_first(const Cells<Scalar>& cells, SiteNumber i,
                                                        SiteNumber j) {
    const auto order = [&](SiteNumber s) { return std::pair(cells.size(s), s); };
    return order(i) < order(j) ? std::pair(i, j) : std::pair(j, i);
  }
  std::vector<std::vector<KnownPair<Scalar>>> of_;
  std::uint32_t pass_ = 0;
};

/// Looks at pairs a little later, when their bands have come from memory: one after the other these
/// would be waited for longer than they take.
template <class Scalar>
class PairsAhead {
 public:
  PairsAhead(const Bands<Scalar>& bands, const Patches<Scalar>& patches, const Cells<Scalar>& cells)
      : bands_(bands), patches_(patches), cells_(cells) {}

  /// `likely`: that there will be something to look at.
  template <class Look>
  void push(SiteNumber i, SiteNumber j, bool likely, const Look& look) {
    if (likely) bands_.prefetch(cells_, i, j);
    pairs_[pushed_ % kAhead] = {i, j, likely, nullptr};
    ++pushed_;
    if (pushed_ >= 2) fetch_band(pairs_[(pushed_ - 2) % kAhead]);
    if (pushed_ >= 3) fetch_points(pairs_[(pushed_ - 3) % kAhead]);
    if (pushed_ >= kAhead) pop(look);
  }
  /// Looks at those that are left.
  template <class Look>
  void finish(const Look& look) {
    while (popped_ < pushed_) pop(look);
  }

 private:
  static constexpr std::size_t kAhead = 4;
  struct Pair {
    SiteNumber i;
    SiteNumber j;
    bool likely;
    const Band<Scalar>* band;
  };

  template <class Look>
  void pop(const Look& look) {
    const Pair& pair = pairs_[popped_++ % kAhead];
    look(pair.i, pair.j);
  }
  static void fetch(const void* begin, std::size_t bytes) {
    for (std::size_t b = 0; b < bytes; b += 64) {
      __builtin_prefetch(static_cast<const char*>(begin) + b);
    }
  }
  void fetch_band(Pair& pair) const {
    if (!pair.likely) return;
    const KnownPair<Scalar>* const known = bands_.find(cells_, pair.i, pair.j);
    pair.band = known != nullptr ? known->band.get() : nullptr;
    if (pair.band != nullptr) fetch(pair.band, sizeof(Band<Scalar>));
  }
  void fetch_points(const Pair& pair) const {
    if (pair.band == nullptr || !pair.band->valid) return;
    patches_.prefetch_changes(pair.i, pair.band->i.known);
    patches_.prefetch_changes(pair.j, pair.band->j.known);
    for (const BandSide<Scalar>* side : {&pair.band->i, &pair.band->j}) {
      fetch(side->cut.numbers.data(), side->cut.numbers.size() * sizeof(Scalar));
      fetch(side->block.data(), std::min(side->block.size() * sizeof(Scalar), kMostBytes));
    }
  }
  static constexpr std::size_t kMostBytes = 2048;

  const Bands<Scalar>& bands_;
  const Patches<Scalar>& patches_;
  const Cells<Scalar>& cells_;
  std::array<Pair, kAhead> pairs_;
  std::size_t pushed_ = 0;
  std::size_t popped_ = 0;
};

}  // namespace ccvt
