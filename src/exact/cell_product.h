#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/weighted_sites.h"
#include "numbers.h"

namespace ccvt {

/// What the points of a cell cost at the sites near it, less what they cost at their own: products
/// in float, whose rounding is bounded.
///
/// |p - s_j|^2 - w_j less the same for the cell's site i is constant_j - x . 2 (s_j - s_i), with
/// x = p - s_i. In units in which no term is large.
class CellProduct {
 public:
  /// Points that are multiplied at a time: their costs stay in cache.
  static constexpr std::size_t kPoints = 64;

  void clear();
  /// A site that is near, at this squared distance from the cell's.
  void add(SiteNumber site, double squared, double constant);
  [[nodiscard]] const std::vector<SiteNumber>& near() const { return near_; }
  [[nodiscard]] double constant(std::size_t n) const { return constant_[n]; }

  /// For the cell of `site`, whose points are no farther from it than `radius`.
  void prepare(const WeightedSites& sites, SiteNumber site, double radius);
  /// Up to kPoints of the cell.
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
  std::vector<double> constant_;  ///< L^2 + w_i - w_j, with L the distance between the sites
  double longest_ = 0;            ///< L^2
  const double* own_ = nullptr;   ///< position of the cell's site
  int dimension_ = 0;
  double scale_ = 1;      ///< brings the cell into the range of float
  double margin_ = 0;     ///< bounds the error of scaled costs
  std::vector<float> v_;  ///< 2 (s_j - s_i), scaled, padded to whole tiles
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
