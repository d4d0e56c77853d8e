#pragma once

#include <array>
#include <cstddef>
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
  /// that points of equal mass move by exchange alone; of 0.5 and 0.9 see benchmarks/README.md.
  static constexpr double kSlack = 0.5;

  /// Does the best of these, if it saves more than rounding can fake; returns how many points have
  /// moved. A cut of the points of both, in the order of their keys; the same of points so light
  /// that one of them cannot jump over the window; one point moved, or two exchanged.
  Index improve(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);

  /// Brings the errors of two cells nearer to each other, if they are farther apart than `slack`
  /// and a cut can do it. Returns whether it did.
  bool even_out(MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);

 private:
  /// A member of the two cells: those of i come first.
  using Member = std::size_t;
  struct Window {
    double low;
    double high;
  };
  struct Place {
    double key;
    Member member;
  };
  /// The first `place` of the sorted members go to i.
  struct Cut {
    std::size_t place = 0;
    double first_error = 0;  ///< of cell i then
  };
  /// Members of i and j that change places; the number of members for none.
  struct Exchange {
    Member from_first;
    Member from_second;
    double gain;
  };

  void look(const MassCells<Scalar>& cells, SiteNumber i, SiteNumber j);
  void find_keys(SiteNumber site);
  [[nodiscard]] Window window() const;
  [[nodiscard]] bool in_first(Member k) const { return k < first_masses_.size(); }
  [[nodiscard]] double mass(Member k) const {
    return in_first(k) ? first_masses_[k] : second_masses_[k - first_masses_.size()];
  }
  [[nodiscard]] PointNumber point(Member k) const;
  /// To which the rounding of what a member's move saves is relative.
  [[nodiscard]] double reach(Member k) const;
  /// What it saves to move the member.
  [[nodiscard]] double saved(Member k) const {
    return in_first(k) ? mass(k) * keys_[k] : -mass(k) * keys_[k];
  }

  [[nodiscard]] bool before(const Place& a, const Place& b) const;
  void sort_all();
  void sort_border(double heaviest, const Window& window);
  void keep_light(double heaviest);
  void find_base();
  bool cheapest_cut(const Window& window, Cut& cut) const;
  void nearest_cut(double error, Cut& cut) const;
  [[nodiscard]] bool gains(const Cut& cut) const;
  void keep_promising();
  [[nodiscard]] Exchange best_exchange(const Window& window);
  [[nodiscard]] bool gains(const Exchange& exchange) const;
  void stay();
  Index apply(MassCells<Scalar>& cells, const Cut& cut);
  Index apply(MassCells<Scalar>& cells, const Exchange& exchange);
  Index give(MassCells<Scalar>& cells);

  // Of the pair that is looked at:
  const MassCells<Scalar>* cells_ = nullptr;
  SiteNumber i_, j_;
  std::span<const double> first_masses_, second_masses_;
  double slack_ = 0;
  double margin_ = 0;
  std::vector<double> keys_;
  double highest_in_first_ = 0;  ///< key
  double lowest_in_second_ = 0;

  std::vector<Place> sorted_;  ///< by key, those that a cut may move
  double first_base_ = 0;      ///< the error of i when it owns none of these
  std::vector<Place> next_;
  std::vector<Member> promising_;  ///< members that may be part of the best exchange, of i first
  std::size_t promising_in_first_ = 0;
  std::vector<std::size_t> queue_;
  std::vector<std::uint8_t> to_first_;  ///< of each member: to whom it goes
  std::array<std::vector<Member>, 2> groups_;
};

extern template class MassPair<float>;
extern template class MassPair<double>;

}  // namespace ccvt
