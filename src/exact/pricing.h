#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/grouping.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// n sites with a weight each; a point p costs site s the reduced cost |p - s|^2 - weight[s].
struct WeightedSites {
  WeightedSites(std::span<const double> positions, std::span<const double> weights)
      : position(positions), weight(weights), dimension(positions.size() / weights.size()) {}

  [[nodiscard]] std::size_t count() const { return weight.size(); }
  [[nodiscard]] const double* at(SiteNumber site) const {
    return position.data() + site * dimension;
  }

  std::span<const double> position;  ///< one site after the other
  std::span<const double> weight;
  std::size_t dimension;
};

/// What pricing all points finds.
struct Prices {
  /// By how much the owners given cost more than the cheapest sites: the sum and the largest over
  /// the points of the difference of reduced costs, in double. When every site owns as many points
  /// as its capacity, the sum is primal less dual objective of the transportation problem: the
  /// duality gap.
  double gap = 0;
  double worst = 0;
  std::int64_t moved = 0;  ///< points that cost less at another site than their owner
  /// The sum of |p - owner|^2 over the points, for the owners given and for those found.
  double energy = 0;
  double cheapest_energy = 0;
};

/// Finds the site of least reduced cost for every point, exactly, among all sites.
///
/// Points are taken by cells of a grouping near the truth: with L the distance between two sites,
/// no point within r of site i costs site j less than site i plus L^2 - 2 L r + w_i - w_j (triangle
/// inequality), which leaves few sites in few dimensions. The rest goes through blocked products in
/// float; their rounding error is bounded, and what it leaves undecided is evaluated in double.
/// O(m n D) at worst; no m by n matrix is held.
template <class Scalar>
class Pricer {
 public:
  Pricer(const Metric& metric, PointsView<Scalar> points, const Arena& arena);

  /// `owners`: of every point, used to group them, replaced by the cheapest site; a point stays
  /// where nothing is cheaper. Same result for any number of threads.
  Prices price(const WeightedSites& sites, std::vector<Index>& owners) const;

  /// The site of least reduced cost for every point.
  std::vector<Index> cheapest(const WeightedSites& sites) const;

 private:
  struct Cell;
  struct Scratch;
  struct Task;
  std::vector<Cell> price_cells(const Task& task, const Grouping& groups) const;
  void price_cell(const Task& task, std::span<const PointNumber> members, SiteNumber site,
                  Scratch& scratch, Cell& result) const;
  void select_sites(const Task& task, SiteNumber site, double radius, Scratch& scratch) const;
  void prepare_product(const Task& task, SiteNumber site, double radius, Scratch& scratch) const;
  void price_block(const Task& task, std::span<const PointNumber> members, const double* x,
                   SiteNumber site, Scratch& scratch, Cell& result) const;
  void decide(const Task& task, PointNumber point, SiteNumber site,
              std::span<const SiteNumber> found, Cell& result) const;

  const Metric& metric_;
  PointsView<Scalar> points_;
  const Arena& arena_;
};

extern template class Pricer<float>;
extern template class Pricer<double>;

}  // namespace ccvt
