#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// What it costs to move points from cell to cell, without weights.
class MoveCosts {
 public:
  virtual ~MoveCosts() = default;

  /// Memory that a caller keeps from call to call; one for each thread.
  struct Scratch {
    std::vector<double> squared;
    std::vector<float> about;
    std::vector<double> own;
    std::vector<double> position;
    std::vector<double> bounds;
    // Of a cell: relative to its site, in float, a stream for each dimension; padded.
    std::vector<float> block;
    Index stride = 0;
    std::vector<float> offset;  ///< point . own site
    std::vector<float> largest;
    double radius = 0;  ///< of the points of the last bounds(), how far the farthest is at most
  };

  /// |p - s|^2 of some points; the same bits as squared_to().
  virtual void squared(std::span<const PointNumber> points, SiteNumber site,
                       std::vector<double>& out) const = 0;
  /// No more than that of each point to the first site, then to the next, and so on; of each site
  /// less by no more than `slack`: what takes less time where that is not 0.
  virtual void squared_at_least(std::span<const PointNumber> points,
                                std::span<const SiteNumber> sites, std::vector<double>& out,
                                std::vector<double>& slack) const = 0;
  /// For so many sites it takes not much longer than for one.
  [[nodiscard]] virtual std::size_t sites_at_once() const = 0;
  /// |point - s|^2 of some sites s.
  virtual void squared_to(PointNumber point, std::span<const SiteNumber> sites,
                          std::vector<double>& out, Scratch& scratch) const = 0;
  /// No more than that for each site, and the same on all ranks; in `scratch`.
  virtual std::span<const double> squared_at_least_to_all(PointNumber point,
                                                          Scratch& scratch) const = 0;
  /// By how much a sum of such squares may be off.
  [[nodiscard]] virtual double rounding(double sum) const = 0;
  /// For each site j, no more than the least over `members`, at least one, of |p - j|^2 - |p -
  /// site|^2; in `scratch`. O(members n D).
  virtual std::span<const double> bounds(SiteNumber site, std::span<const PointNumber> members,
                                         Scratch& scratch) const = 0;
  /// Positions of points of whatever rank, by their numbers among all, for squared_to() and
  /// squared_at_least_to_all(). Returns what they are to be called there; those of other ranks are
  /// known until the next call. All ranks ask for the same.
  virtual std::vector<PointNumber> bring(std::span<const Index> points, const RankPart& part) = 0;
  /// squared() of a cell's points takes so many calls, about, until it takes as long as bounds().
  [[nodiscard]] virtual std::size_t weighings() const = 0;
};

/// For fixed sites. All in double but for bounds: they are in float, and low enough for its
/// rounding.
template <class Scalar>
class SquaredDistances final : public MoveCosts {
 public:
  /// `sites`: positions, one after the other; they, `metric` and the points must outlive the
  /// object.
  SquaredDistances(const Metric& metric, PointsView<Scalar> points, std::span<const double> sites);

  void squared(std::span<const PointNumber> points, SiteNumber site,
               std::vector<double>& out) const override;
  void squared_at_least(std::span<const PointNumber> points, std::span<const SiteNumber> sites,
                        std::vector<double>& out, std::vector<double>& slack) const override;
  [[nodiscard]] std::size_t sites_at_once() const override;
  void squared_to(PointNumber point, std::span<const SiteNumber> sites, std::vector<double>& out,
                  Scratch& scratch) const override;
  std::span<const double> squared_at_least_to_all(PointNumber point,
                                                  Scratch& scratch) const override;
  [[nodiscard]] double rounding(double sum) const override;
  std::vector<PointNumber> bring(std::span<const Index> points, const RankPart& part) override;
  std::span<const double> bounds(SiteNumber site, std::span<const PointNumber> members,
                                 Scratch& scratch) const override;
  [[nodiscard]] std::size_t weighings() const override;

 private:
  [[nodiscard]] std::size_t dimension() const {
    return static_cast<std::size_t>(points_.dimension);
  }
  void round_sites();
  struct Margin {
    double share;
    double beside;
  };
  [[nodiscard]] Margin margin(double largest, double off) const;
  [[nodiscard]] const double* at(SiteNumber site) const {
    return sites_.data() + site * dimension();
  }
  [[nodiscard]] std::size_t count() const { return sites_.size() / dimension(); }
  /// Of a point, or of one that was brought.
  [[nodiscard]] const Scalar* row(PointNumber point) const;
  void squares(const double* from, Scratch& scratch) const;
  [[nodiscard]] double squared_spacing() const;
  void lower_bounds(SiteNumber site, std::span<const PointNumber> members, Scratch& scratch) const;
  double gather(SiteNumber site, std::span<const PointNumber> members, Scratch& scratch) const;

  const Metric& metric_;
  PointsView<Scalar> points_;
  std::vector<Scalar> brought_;
  std::span<const double> sites_;
  std::vector<double> packs_;  ///< positions, for the kernel
  // Positions in float, and how far off they are; none where distances are not looked at in float:
  // points in double, few dimensions, or sites far from the origin that are near each other.
  std::vector<float> rounded_;
  std::vector<float> rounded_packs_;
  std::vector<double> off_;
  double most_off_ = 0;
  // Relative to the mean of the sites, in units in which no site is far; padded.
  std::vector<double> mean_;
  double scale_ = 1;
  std::vector<float> centred_;
  std::vector<double> norm_;
};

extern template class SquaredDistances<float>;
extern template class SquaredDistances<double>;

}  // namespace ccvt
