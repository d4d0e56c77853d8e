#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/ranks.h"
#include "ccvt/types.h"

namespace ccvt {

/// What is to be tessellated: m points, n sites with capacities that sum to m, and a domain.
///
/// The points are not copied: they must outlive the problem and every solver made from it.
/// Each setter checks its argument at once, against what was set before too, and throws
/// InvalidInput: a Problem that exists is valid, and no order of setters drops anything.
///
///     ccvt::Problem problem(points, 1000);
///     problem.set_domain(ccvt::Domain::periodic(ccvt::Box::unit(2)));
template <class Scalar>
class CCVT_EXPORT Problem {
 public:
  /// `points`: #dimensions by m, at least one dimension; coordinates at most 1e17 (double: 1e140)
  /// in magnitude, less beyond 8192 dimensions, by 1 / sqrt(dimensions / 8192); all equal, or 1e-30
  /// (double: 1e-140) or more apart somewhere. `sites`: 1 <= n <= m. `threads` look at the points
  /// when there are many; 0: one per processor, at most 4096.
  template <class Derived>
  Problem(const Eigen::DenseBase<Derived>& points, Index sites, int threads = 1)
      : Problem(view_points(points), sites, threads) {}
  template <class Derived>
  Problem(Eigen::PlainObjectBase<Derived>&& points, Index sites, int threads = 1) = delete;
  template <class Derived>
  Problem(const Eigen::PlainObjectBase<Derived>&& points, Index sites, int threads = 1) = delete;
  Problem(const Columns<Scalar>& points, Index sites, int threads = 1)
      : Problem(view_points(points), sites, threads) {}
  Problem(const Columns<Scalar>&& points, Index sites, int threads = 1) = delete;
  Problem(PointsView<Scalar> points, Index sites, int threads = 1);
  /// A problem that `ranks`, which must outlive it, solve together. `own` are the points of this
  /// rank, perhaps none; their numbers follow those of the lower ranks. What else there is of the
  /// problem, its setters and the options of its solvers must be the same on all ranks; so are then
  /// the sites, to the bit those of one process with all points, and owners are those of a rank's
  /// own points. A rank has at most 2^31 - 1 points, all together 2^40, and addresses for the
  /// coordinates of all twice. Each rank has in memory its points, about as many points of whole
  /// cells, and what there is of all sites. Not: other starts than from initial owners or the
  /// balanced one, which at most 8 dimensions have.
  Problem(Ranks& ranks, PointsView<Scalar> own, Index sites, int threads = 1);

  /// Default: Euclidean space. A box must have the points' dimension and contain all points (a
  /// periodic box: both faces included); its corners are as moderate as coordinates, and a periodic
  /// one extends over 1e-30 (double: 1e-140) or more in each dimension. Points may lie on corners
  /// rounded to Scalar, as coordinates are: where some do outside the box, it is widened to them.
  Problem& set_domain(Domain domain);
  /// Default: equal, see equal_capacities(). One positive number per site, summing to m, and after
  /// set_initial_owners() as many as each site owns.
  Problem& set_capacities(std::vector<Index> capacities);
  /// Default: n distinct points drawn by Options::seed. #dimensions by n, as moderate as points.
  /// Beside initial owners, set before or after, they are no more than hints: sites start at the
  /// centroids of their cells, of which a cell that winds round a periodic domain has several; it
  /// is given the one that its hint leads to.
  template <class Derived>
  Problem& set_initial_sites(const Eigen::DenseBase<Derived>& sites) {
    static_assert(!std::is_integral_v<typename Derived::Scalar>,
                  "ccvt: sites must be float or double: convert them by sites.cast<float>()");
    return set_initial_sites(Columns<Scalar>(sites));
  }
  Problem& set_initial_sites(Columns<Scalar> sites);
  /// Sites that stay where they are: 0..k-1, of `sites`, #dimensions by k, k <= n, as moderate as
  /// points, two of them at one place or not. They own points as the others do, as many as their
  /// capacities, but do not move to the centroids of their cells; the others find places around
  /// them. Default: none. Of initial sites, the first k then count for nothing. In a periodic
  /// domain the images in the box are meant; on its upper face they come back as they were given.
  template <class Derived>
  Problem& set_fixed_sites(const Eigen::DenseBase<Derived>& sites) {
    static_assert(!std::is_integral_v<typename Derived::Scalar>,
                  "ccvt: sites must be float or double: convert them by sites.cast<float>()");
    return set_fixed_sites(Columns<Scalar>(sites));
  }
  Problem& set_fixed_sites(Columns<Scalar> sites);
  /// A warm start: the owner of every point, in 0..n-1, each site owning as many points as its
  /// capacity; capacities that are not equal must be set first. Sites that are not fixed start at
  /// the centroids of the cells. Of ranks each gives those of its own points, and errors number
  /// them as those of all; a run finds out, and throws InvalidInput, where they do not meet the
  /// capacities together.
  Problem& set_initial_owners(std::vector<Index> owners);

  /// Of a problem of ranks, those of this rank; and how many all have.
  [[nodiscard]] const PointsView<Scalar>& points() const { return points_; }
  [[nodiscard]] std::int64_t point_count() const { return part_ ? part_->all : points_.count; }
  [[nodiscard]] int dimension() const { return points_.dimension; }
  [[nodiscard]] Index site_count() const { return static_cast<Index>(capacities_.size()); }
  [[nodiscard]] const Domain& domain() const { return domain_; }
  [[nodiscard]] const std::vector<Index>& capacities() const { return capacities_; }
  /// Empty unless set.
  [[nodiscard]] const Columns<Scalar>& initial_sites() const { return initial_sites_; }
  /// Of as many columns as there are such; empty unless set.
  [[nodiscard]] const Columns<Scalar>& fixed_sites() const { return fixed_sites_; }
  /// Empty unless set.
  [[nodiscard]] const std::vector<Index>& initial_owners() const { return initial_owners_; }
  /// The domain's box, or the bounding box of the points.
  [[nodiscard]] Box bounding_box() const;
  /// Null where there is one process.
  [[nodiscard]] Ranks* ranks() const { return part_ ? part_->ranks : nullptr; }
  /// The number of this rank's first point among those of all: without ranks, 0.
  [[nodiscard]] std::int64_t first_own_point() const { return part_ ? part_->first : 0; }
  /// The bounding box of the points of all ranks; where there is one process, bounding_box().
  [[nodiscard]] Box box_of_ranks() const { return part_ ? part_->around : bounding_box(); }

 private:
  /// @cond of the points of a rank
  struct Part {
    Ranks* ranks;
    std::int64_t first;
    std::int64_t all;
    Box around;  ///< the points of all ranks
  };
  /// @endcond
  PointsView<Scalar> points_;
  std::shared_ptr<const Part> part_;
  int threads_;
  Domain domain_;
  std::vector<Index> capacities_;
  Columns<Scalar> initial_sites_;
  Columns<Scalar> fixed_sites_;
  std::vector<Index> initial_owners_;
};

template <class Derived>
Problem(const Eigen::DenseBase<Derived>&, Index, int = 1) -> Problem<typename Derived::Scalar>;

}  // namespace ccvt
