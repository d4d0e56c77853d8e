#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "geometry/metric.h"
#include "kernels/keys.h"
#include "relax/cells.h"
#include "relax/pair_cut.h"
#include "relax/patches.h"
#include "relax/site_state.h"

namespace ccvt {

/// Of a divided cell and one that is not, whose points lay on their sides of a cut, how far from it
/// they lay. Until the sites have moved too far since, only points that have come to the cells need
/// be looked at.
///
/// Of points q of the large cell and p of the small one, with n from site i to site j, the
/// difference of keys is (q - p) n. It changes by no more than |q - p| times what the sites move.
template <class Scalar>
class Apart {
 public:
  using Side = typename PairCut<Scalar>::Side;

  /// A pair of cells, and their cut. The large cell is the divided one.
  struct Pair {
    const Metric& metric;
    const PairCut<Scalar>& cut;
    const Cells<Scalar>& cells;
    const Patches<Scalar>& patches;
    const SiteState& sites;
    SiteNumber i;
    SiteNumber j;
    [[nodiscard]] bool large_is_i() const { return patches.has(i); }
    [[nodiscard]] SiteNumber large() const { return large_is_i() ? i : j; }
    [[nodiscard]] SiteNumber small() const { return large_is_i() ? j : i; }
  };

  /// Notes where the points are. Of the large cell some are given, those near the cut: so many, in
  /// streams of a block that are `stride` apart; and what bounds the kernels' keys of all others.
  void note(const Pair& pair, const Scalar* near, Index stride, Index count, double others);

  /// Whether no points of the pair can gain by an exchange, as far as is known here. False for all
  /// times when it is false once, until it is noted anew. The pair is given as it was then. O(D +
  /// points that have come to the large cell); O(D * size) when one has come to the small cell.
  bool holds(const Pair& pair);

  [[nodiscard]] bool is_known() const { return known_; }

 private:
  /// Larger cells are hardly ever divided in more.
  static constexpr std::size_t kMostDimensions = 3;

  /// Of some points a bound on their keys, negative on the side of the large cell, and one on how
  /// far they are from where the small cell's site was.
  struct Part {
    double key;
    double reach;
  };
  [[nodiscard]] static bool possible(const Pair& pair);
  [[nodiscard]] double key(const Pair& pair, SiteNumber cell, const Scalar* block, Index stride,
                           Index count) const;
  [[nodiscard]] double moved(const Pair& pair) const;
  void look_at_changes(const Pair& pair, double moved);

  bool known_ = false;
  std::uint32_t exchanged_ = 0;  ///< of the small cell: see Patches::exchanged()
  std::uint32_t version_ = 0;    ///< of the large cell's changes, and how many of them are known
  std::uint32_t changes_ = 0;
  double tolerance_ = 0;  ///< of the cut
  Part own_{};            ///< the small cell, from below
  Part near_{};  ///< of the large cell, the points near the cut, from above; and all others
  Part far_{};
  std::array<double, 2 * kMostDimensions> sites_{};  ///< where site i was, and site j
  std::array<Scalar, kMostDimensions> middle_{};     ///< of the cut, as it was
  std::array<Scalar, kMostDimensions> normal_{};
};

extern template class Apart<float>;
extern template class Apart<double>;

}  // namespace ccvt
