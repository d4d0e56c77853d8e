#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "weighted/mass_cells.h"

namespace ccvt {

/// What two cells do with their points: memory for it, one a worker.
///
/// The key of a point is |p - s_i|^2 - |p - s_j|^2: moving mass w from i to j saves w times the
/// key. Let e be what a cell is too heavy by. e_i + e_j stays what it is, whatever the two
/// exchange; what they may exchange is said by a window around its half that the new e_i has to lie
/// in. The window is wide enough that neither |e_i - e_j| nor the larger of |e_i| and |e_j| grows
/// beyond what it was, or beyond `slack` if that is more, and never lets either reach the mass of
/// the heaviest point.
template <class Scalar>
class MassPair {
 public:
  /// Of the mean mass of the points of both cells, what their errors may always be. Below 1, so
  /// that points of equal mass move by exchange alone. See benchmarks/README.md.
  static constexpr double kSlack = 0.9;

  /// Does the best of these, if it saves more than rounding can fake; returns how many points have
  /// moved. A cut of the points of both, in the order of their keys; the same of points so light
  /// that one of them cannot jump over the window; one point moved, or two exchanged.
  Index improve(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);

  /// Brings the errors of two cells nearer to each other, if they are farther apart than `slack`
  /// and a cut can do it. Returns whether it did.
  bool even_out(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);

 private:
  struct Member {
    double key;
    double mass;
    double reach;  ///< to which the rounding of the key is relative
    PointNumber point;
    bool in_first;  ///< in cell i, not j
  };
  /// The first `place` of the sorted members go to i.
  struct Cut {
    std::size_t place = 0;
    double first_error = 0;  ///< of cell i then
  };
  struct Window {
    double low;
    double high;
  };
  /// Members of i and j that change places; the number of members for none.
  struct Exchange {
    std::size_t from_first;
    std::size_t from_second;
    double gain;
  };

  void look(const MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);
  void sort_light(double heaviest);
  [[nodiscard]] Window window(const MassCells<Scalar>& cells, SiteNumber i, SiteNumber j) const;
  bool cheapest_cut(const Window& window, Cut& cut) const;
  void nearest_cut(double error, Cut& cut) const;
  [[nodiscard]] bool gains(const Cut& cut) const;
  [[nodiscard]] Exchange best_exchange(const Window& window) const;
  [[nodiscard]] bool gains(const Exchange& exchange) const;
  Index apply(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j, const Cut& cut);
  Index apply(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j, const Exchange& exchange);
  Index give(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);

  std::vector<Member> members_;         ///< of i by mass, then of j by mass
  std::size_t in_first_ = 0;            ///< members of i
  std::vector<std::uint32_t> sorted_;   ///< those light enough, by key
  std::vector<std::uint8_t> to_first_;  ///< of each member: to whom it goes
  double first_base_ = 0;  ///< the error of i when it owns none of those that are sorted
  double first_error_ = 0;
  double slack_ = 0;
  double margin_ = 0;
};

extern template class MassPair<float>;
extern template class MassPair<double>;

}  // namespace ccvt
