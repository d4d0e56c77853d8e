#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/metric.h"
#include "kernels/keys.h"
#include "relax/site_state.h"

namespace ccvt {

/// The cut between the cells of a pair of sites: the plane half way between the sites; on a torus,
/// what takes its place. Points are told apart by their keys: half of their energy at site i less
/// half of that at site j [eq. 6]. Holds one pair at a time.
template <class Scalar>
class PairCut {
 public:
  /// `coordinate_bound`: on the absolute values of all coordinates.
  PairCut(const Metric& metric, double coordinate_bound);

  /// Sets up the cut between sites i and j, whose state must not change while it is in use. O(D).
  void place(const SiteState& sites, SiteNumber i, SiteNumber j) { (this->*place_)(sites, i, j); }

  /// Which of the two cells a point is in.
  enum class Side { i, j };

  /// The key of a point in double; and added to `keys`, those of all `count` points of a cell, a
  /// stream at a time: the same sums in the same order.
  [[nodiscard]] double key(Side side, const Scalar* block, Index count, Index place) const;
  void add_keys(Side side, const Scalar* block, Index count, double* keys) const;

  /// Calls `visit` with the cut as the kernels see it from cell i and from cell j.
  template <class Visit>
  auto with_kernels(const Visit& visit) const;

  /// Whether the cut is a plane for both cells as they stand, and points of both sides can be
  /// bounded by boxes around them.
  [[nodiscard]] bool straight() const { return frame_ == Frame::plain; }
  /// Where it is: as the kernels see it from one side.
  [[nodiscard]] kernels::Cut<Scalar> straight_cut(Side side) const {
    return {(side == Side::i ? scalar_middle_i_ : scalar_middle_j_).data(), scalar_normal_.data()};
  }
  /// Where the cut is straight: bounds on the kernels' keys of points in boxes, from above for side
  /// i and from below for side j. `low` and `high` are the boxes' ends, a stream for each
  /// dimension; the last box is around all others, and has no bound.
  void bound_keys(Side side, std::span<const Scalar> low, std::span<const Scalar> high,
                  std::vector<double>& bounds) const;

  /// By how much the kernels' keys of a side are above those in double, but for the tolerance.
  [[nodiscard]] double kernels_differ(Side side) const;
  /// A straight cut as the kernels saw it from one side, and a box around points.
  struct Kept {
    /// Of each dimension the cut's middle; then its normal, then the box's lower and upper ends.
    std::vector<Scalar> numbers;
    double tolerance = 0;
    [[nodiscard]] std::size_t dimension() const { return numbers.size() / 4; }
    [[nodiscard]] kernels::Cut<Scalar> cut() const {
      return {numbers.data(), numbers.data() + dimension()};
    }
    [[nodiscard]] const Scalar* low() const { return numbers.data() + 2 * dimension(); }
    [[nodiscard]] const Scalar* high() const { return numbers.data() + 3 * dimension(); }
    /// `ends`: a lower and an upper one for each dimension.
    void extend(std::span<const Scalar> ends) {
      Scalar* const low = numbers.data() + 2 * dimension();
      Scalar* const high = low + dimension();
      for (std::size_t d = 0; d < dimension(); ++d) {
        low[d] = std::min(low[d], ends[2 * d]);
        high[d] = std::max(high[d], ends[2 * d + 1]);
      }
    }
  };
  /// Keeps the cut, with the last of some boxes.
  void keep(Side side, std::span<const Scalar> low, std::span<const Scalar> high, Kept& kept) const;
  /// Where the cut is straight: what bounds the kernels' keys now of the points in the box, and
  /// their keys in double, from above for side i and from below for side j, when `limit` bounds
  /// their keys by a cut that was kept.
  struct Bounds {
    double of_kernels;
    double exact;
  };
  [[nodiscard]] Bounds bounds_since(Side side, const Kept& kept, double limit) const;

  /// The distance between the two sites.
  [[nodiscard]] double length() const { return length_; }
  /// A bound on the error of the kernels' keys, and on that of keys in double; but for what all
  /// keys of the pair share, which differs: the two kinds must not be compared.
  [[nodiscard]] double tolerance() const { return tolerance_; }
  [[nodiscard]] double rounding() const { return rounding_; }
  /// Whether a point that changes its owner may need wrapping at its new site.
  [[nodiscard]] bool crosses_faces() const { return crosses_faces_; }

 private:
  /// How the two cells lie: as they stand in one frame, or in two that a shift of one makes one; in
  /// one frame, but across the box's faces in one dimension or in several; or in none, being too
  /// large for the torus.
  enum class Frame { plain, one_face, wrapped, none };

  template <std::size_t Dimension, bool Periodic>
  void place_in(const SiteState& sites, SiteNumber i, SiteNumber j);
  Frame frame_across(double radius, bool compact, bool small);
  void bound_errors(double radius);
  [[nodiscard]] const std::vector<double>& middle(Side side) const {
    return side == Side::i ? middle_i_ : middle_j_;
  }

  using Place = void (PairCut::*)(const SiteState&, SiteNumber, SiteNumber);
  template <bool Periodic>
  [[nodiscard]] static Place place_for(int dimension);

  const Metric& metric_;
  Place place_;  ///< for the dimension and domain
  double least_extent_;
  double largest_wrapped_ = 0;  ///< of the extent: two cells in a wrapped frame
  double placement_;            ///< bounds what coordinates are rounded as
  double rounding_of_size_;     ///< factors of both error bounds
  double tolerance_of_size_;
  double least_rounding_;  ///< what underflow adds to them
  double least_tolerance_;

  Frame frame_ = Frame::plain;
  std::size_t across_ = 0;  ///< the dimension of Frame::one_face
  bool crosses_faces_ = false;
  double length_ = 0;
  double tolerance_ = 0;
  double rounding_ = 0;
  const double* site_i_ = nullptr;
  const double* site_j_ = nullptr;
  std::vector<double> normal_;
  std::vector<double> middle_i_;
  std::vector<double> middle_j_;
  std::vector<Scalar> scalar_normal_;
  std::vector<Scalar> scalar_middle_i_;
  std::vector<Scalar> scalar_middle_j_;
  std::vector<Scalar> extent_;
  std::vector<Scalar> inverse_extent_;
  std::vector<Scalar> turn_;  ///< of coordinates, in a wrapped frame
};

template <class Scalar>
template <class Visit>
auto PairCut<Scalar>::with_kernels(const Visit& visit) const {
  switch (frame_) {
    case Frame::plain:
      break;
    case Frame::one_face: {
      const kernels::FaceCut<Scalar> cut{scalar_middle_i_.data(), scalar_normal_.data(),
                                         turn_[across_], extent_[across_] * scalar_normal_[across_],
                                         static_cast<int>(across_)};
      return visit(cut, cut);
    }
    case Frame::wrapped: {
      const kernels::WrappedCut<Scalar> cut{scalar_middle_i_.data(), scalar_normal_.data(),
                                            turn_.data(), extent_.data()};
      return visit(cut, cut);
    }
    case Frame::none: {
      const kernels::TorusCut<Scalar> cut{scalar_middle_i_.data(), scalar_middle_j_.data(),
                                          extent_.data(), inverse_extent_.data()};
      return visit(cut, cut);
    }
  }
  return visit(straight_cut(Side::i), straight_cut(Side::j));
}

extern template class PairCut<float>;
extern template class PairCut<double>;

}  // namespace ccvt
