#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/weighted_sites.h"
#include "numbers.h"

namespace ccvt {

/// What points near a centre cost at the sites near it, less what they would cost at a site there:
/// products in float, whose rounding is bounded. The centre of a cell is its site.
///
/// |p - s_j|^2 - w_j less the same for a site c of weight w is constant_j - x . 2 (s_j - c), with
/// x = p - c. In units in which no term is large.
class CellProduct {
 public:
  /// Points that are multiplied at a time: their costs stay in cache.
  static constexpr std::size_t kPoints = 64;

  void clear();
  /// A site that is near, at this squared distance from the centre.
  void add(SiteNumber site, double squared, double constant);
  [[nodiscard]] const std::vector<SiteNumber>& near() const { return near_; }
  [[nodiscard]] double constant(std::size_t n) const { return constant_[n]; }

  /// For points no farther from `centre` than `radius`.
  void prepare(const WeightedSites& sites, const double* centre, double radius);
  /// Up to kPoints of them.
  template <class Scalar>
  void multiply(PointsView<Scalar> points, std::span<const PointNumber> members);
  /// Of the points multiplied last, the sites that may be the cheapest one for the k-th.
  [[nodiscard]] const std::vector<SiteNumber>& cheapest(std::size_t k) const { return found_[k]; }
  /// No more than what any of the points since prepare() costs at near()[n].
  [[nodiscard]] double least(std::size_t n) const {
    return (fall_[n] - margin_) / (scale_ * scale_);
  }

 private:
  template <class Scalar>
  void gather(PointsView<Scalar> points, std::span<const PointNumber> members);
  void find_cheapest(Index first, Index rows, std::size_t points);

  std::vector<SiteNumber> near_;
  std::vector<double> constant_;  ///< L^2 + w - w_j, with L the distance from the centre
  double longest_ = 0;            ///< L^2
  const double* own_ = nullptr;   ///< the centre
  int dimension_ = 0;
  double scale_ = 1;      ///< brings the points into the range of float
  double margin_ = 0;     ///< bounds the error of scaled costs
  std::vector<float> v_;  ///< 2 (s_j - c), scaled, padded to whole tiles
  std::vector<float> c_;  ///< constants, scaled, padded
  std::vector<float> fall_;
  // Of the points at hand.
  Index stride_ = 0;
  std::vector<float> block_;
  std::vector<float> cost_;
  std::vector<float> lowest_;
  std::vector<float> limit_;
  std::vector<float> row_fall_;
  std::vector<Index> place_;
  std::vector<std::vector<SiteNumber>> found_;
};

}  // namespace ccvt
