#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/cell_bounds.h"
#include "exact/grouping.h"
#include "exact/weighted_sites.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/rank_part.h"
#include "parallel/rank_turns.h"

namespace ccvt {

class CellProduct;
struct PriceSums;

/// What pricing all points finds: of all ranks, where there are several. Sums are rounded
/// once, so that they hang on the points and the sites alone.
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

/// Which of several cheapest sites a point gets.
enum class Ties {
  in_turn,  ///< by the point's number: points in one place spread over the sites in one place
  by_place  ///< the same for all points in one place
};

/// Finds the site of least reduced cost for every point, exactly, among all sites.
///
/// Points are taken by cells of a grouping near the truth: with L the distance between two sites,
/// no point within r of site i costs site j less than site i plus L^2 - 2 L r + w_i - w_j (triangle
/// inequality), which leaves few sites in few dimensions. Where cells have few points, several near
/// each other are taken together, around a common centre, and only sites are looked at that may
/// cost some point less than its owner does. The rest goes through blocked products in float; their
/// rounding error is bounded, and what it leaves undecided is evaluated in double. O(m n D) at
/// worst; no m by n matrix is held.
template <class Scalar>
class Pricer {
 public:
  /// `part`: the points are those of a rank. All ranks then make the same calls; so they do where
  /// all have all points and the arena divides loops among them: then they share the work.
  Pricer(const Metric& metric, PointsView<Scalar> points, const Arena& arena,
         const RankPart& part = {});

  /// `owners`: of every point, used to group them, replaced by the cheapest site; a point stays
  /// where nothing is cheaper. Same result for any number of threads.
  ///
  /// `kept`: bounds of the cells, from the pricing before. Where they cover the owners given, only
  /// sites that they do not rule out are looked at; they cover those owners afterwards.
  Prices price(const WeightedSites& sites, std::vector<Index>& owners,
               CellBounds* kept = nullptr) const;

  /// The site of least reduced cost for every point; of a rank, for its own: others need not call.
  std::vector<Index> cheapest(const WeightedSites& sites, Ties ties = Ties::in_turn) const;

 private:
  struct Part;
  struct Scratch;
  struct Task;
  [[nodiscard]] Ranks* sharing() const { return ccvt::sharing(arena_, part_); }
  std::vector<Part> parts_of(Task& task, const Grouping& groups) const;
  std::vector<Part> parts_around(std::span<const double> centres, const Grouping& groups) const;
  [[nodiscard]] Prices total(PriceSums own) const;
  bool cheapest_by_groups(const WeightedSites& sites, Ties ties, std::vector<Index>& owners) const;
  PriceSums price_regions(const Task& task, std::span<const Index> region,
                          std::span<const double> centres) const;
  PriceSums price_cells(const WeightedSites& sites, std::vector<Index>& owners,
                        CellBounds* kept) const;
  PriceSums price_together(const WeightedSites& sites, std::vector<Index>& owners) const;
  PriceSums price_parts(const Task& task, std::vector<Part>& parts) const;
  void share_owners(std::span<const Index> given, std::vector<Index>& owners) const;
  static void keep(CellBounds& kept, const std::vector<Part>& parts);
  void price_part(const Task& task, Part& part, std::span<const double> apart,
                  Scratch& scratch) const;
  void select_sites(const Task& task, const Part& part, std::span<const double> apart,
                    Scratch& scratch) const;
  void select_by_groups(const Task& task, const Part& part, Scratch& scratch) const;
  void select_known(const Task& task, const Part& part, Scratch& scratch) const;
  void raise_bounds(const Task& task, const Part& part, const CellProduct& product) const;
  void survey(const Task& task, Part& part, Scratch& scratch) const;
  [[nodiscard]] double cost_of(PointNumber point, const Task& task, SiteNumber site) const;
  void decide(const Task& task, PointNumber point, std::span<const SiteNumber> found,
              PriceSums& sums) const;

  const Metric& metric_;
  PointsView<Scalar> points_;
  const Arena& arena_;
  RankPart part_;
};

extern template class Pricer<float>;
extern template class Pricer<double>;

}  // namespace ccvt
