#include "ccvt/problem.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "bounds.h"
#include "checks.h"
#include "geometry/coordinate_range.h"
#include "geometry/range_of_ranks.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/together.h"
#include "scales.h"
#include "thread_count.h"

namespace ccvt {
namespace {

/// Fewer points are checked by one thread: others would not have started before the end.
constexpr Index kPointsForThreads = 1 << 18;

/// Points are not looked at one by one unless one of them is outside, as the box around all tells.
template <class Scalar>
void require_inside(const char* argument, const PointsView<Scalar>& points,
                    std::int64_t first_number, const Box& box, const Box& around) {
  bool inside = true;
  for (int d = 0; d < box.dimension(); ++d) {
    inside = inside && around.lower[d] >= box.lower[d] && around.upper[d] <= box.upper[d];
  }
  for (Index p = 0; p < points.count && !inside; ++p) {
    for (int d = 0; d < points.dimension; ++d) {
      const double value = points[p][d];
      if (value >= box.lower[d] && value <= box.upper[d]) continue;
      throw InvalidInput(std::string(argument) + ": coordinate " + std::to_string(d) + " of " +
                         argument + "[" + std::to_string(first_number + p) + "] is " + text(value) +
                         ": it must lie in the box, from " + text(box.lower[d]) + " to " +
                         text(box.upper[d]));
    }
  }
}

template <class Scalar>
void require_scale(const Domain& domain) {
  const Box& box = domain.box();
  const double largest = largest_coordinate<Scalar>(box.dimension());
  const auto check = [largest](const char* corner, const Coordinates& x) {
    for (std::ptrdiff_t d = 0; d < x.size(); ++d) {
      if (std::abs(x[d]) <= largest) continue;
      throw InvalidInput("domain: coordinate " + std::to_string(d) + " of its box's " + corner +
                         " corner is " + text(x[d]) + ": it must be at most " + text(largest) +
                         " in magnitude");
    }
  };
  check("lower", box.lower);
  check("upper", box.upper);
  for (int d = 0; d < box.dimension(); ++d) {
    if (!domain.is_periodic(d)) continue;
    const double extent = box.upper[d] - box.lower[d];
    if (extent >= kSmallestExtent<Scalar>) continue;
    throw InvalidInput("domain: the extent of its box in dimension " + std::to_string(d) + " is " +
                       text(extent) + ": that of a periodic one must be at least " +
                       text(kSmallestExtent<Scalar>));
  }
}

/// The domain with a box that is wider by what rounding its corners to Scalar makes of it, where
/// points, which `around` is around, lie on those: on its faces, as near as coordinates tell.
template <class Scalar>
Domain with_points_on_faces(const Domain& domain, const Box& around) {
  Box box = domain.box();
  std::vector<bool> along;
  for (int d = 0; d < box.dimension(); ++d) {
    along.push_back(domain.is_periodic(d));
    if (around.lower[d] == static_cast<Scalar>(box.lower[d])) {
      box.lower[d] = std::min(box.lower[d], around.lower[d]);
    }
    if (around.upper[d] == static_cast<Scalar>(box.upper[d])) {
      box.upper[d] = std::max(box.upper[d], around.upper[d]);
    }
  }
  return Domain::periodic(std::move(box), along);
}

template <class Scalar>
void require_view(const PointsView<Scalar>& points) {
  if (points.dimension < 1) throw InvalidInput("points: they have no dimension");
  require_data("points", points);
}

}  // namespace

template <class Scalar>
Problem<Scalar>::Problem(PointsView<Scalar> points, Index sites, int threads)
    : points_(points), threads_(points.count < kPointsForThreads ? 1 : threads) {
  require_threads(threads);
  require_view(points);
  if (points.count < 1) throw InvalidInput("points: there are none");
  capacities_ = equal_capacities(points.count, sites);
  require_scale("points", points, Arena(threads_));
}

template <class Scalar>
Problem<Scalar>::Problem(Ranks& ranks, PointsView<Scalar> own, Index sites, int threads)
    : points_(own), threads_(own.count < kPointsForThreads ? 1 : threads) {
  agree(&ranks, [&] {
    require_threads(threads);
    require_view(own);
  });
  struct Shape {
    std::int64_t dimension;
    std::int64_t points;
    std::int64_t sites;
  };
  const std::vector<Shape> all = of_all(&ranks, Shape{own.dimension, own.count, sites});
  std::int64_t count = 0;
  std::int64_t first = 0;
  for (std::size_t r = 0; r < all.size(); ++r) {
    if (all[r].dimension != all[0].dimension || all[r].sites != all[0].sites) {
      throw InvalidInput("ranks: rank " + std::to_string(r) + " has points of " +
                         std::to_string(all[r].dimension) + " dimensions for " +
                         std::to_string(all[r].sites) + " sites, rank 0 has " +
                         std::to_string(all[0].dimension) + " for " + std::to_string(all[0].sites) +
                         ": they must be equal");
    }
    if (std::cmp_less(r, ranks.rank())) first += all[r].points;
    count += all[r].points;
  }
  if (count < 1) throw InvalidInput("points: there are none");
  if (count > kMostPointsOfAll) {
    throw InvalidInput("points: there are " + std::to_string(count) +
                       " of them on all ranks, but at most " + std::to_string(kMostPointsOfAll) +
                       " are supported");
  }
  capacities_ = equal_capacities(count, sites);
  const Arena arena(threads_);
  agree(&ranks, [&] { require_moderate("points", own, arena, first); });
  const Box around = box_of_all(ranks, own, arena);
  require_extent<Scalar>("points", around.extent().maxCoeff());
  if (ranks.count() == 1) return;
  part_ = std::make_shared<const Part>(Part{&ranks, first, count, around});
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_domain(Domain domain) {
  if (domain.has_box()) {
    if (domain.box().dimension() != dimension()) {
      throw InvalidInput("domain: its box has " + std::to_string(domain.box().dimension()) +
                         " dimensions, the points have " + std::to_string(dimension()));
    }
    require_scale<Scalar>(domain);
    const Box around = ranks() != nullptr ? box_of_ranks() : box_around(points_, Arena(threads_));
    domain = with_points_on_faces<Scalar>(domain, around);
    agree(ranks(),
          [&] { require_inside("points", points(), first_own_point(), domain.box(), around); });
  }
  domain_ = std::move(domain);
  return *this;
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_capacities(std::vector<Index> capacities) {
  if (capacities.size() != capacities_.size()) {
    throw InvalidInput("capacities: there are " + std::to_string(capacities.size()) + " for " +
                       std::to_string(site_count()) + " sites: there must be one per site");
  }
  validate_capacities(capacities, point_count());
  // Owners that are there own as many points as the capacities in force say; of ranks a run sees.
  const bool owned = !initial_owners_.empty() && ranks() == nullptr;
  for (std::size_t s = 0; s < capacities.size() && owned; ++s) {
    if (capacities[s] == capacities_[s]) continue;
    throw InvalidInput("capacities[" + std::to_string(s) + "] is " + std::to_string(capacities[s]) +
                       ", but the initial_owners set before give that site " +
                       std::to_string(capacities_[s]) +
                       " points: the two must be equal; set capacities first");
  }
  capacities_ = std::move(capacities);
  return *this;
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_initial_sites(Columns<Scalar> sites) {
  if (sites.cols() != site_count() || sites.rows() != dimension()) {
    throw InvalidInput("initial_sites: the matrix is " + std::to_string(sites.rows()) + " by " +
                       std::to_string(sites.cols()) + ": it must be " +
                       std::to_string(dimension()) + " by " + std::to_string(site_count()) +
                       ", one column per site");
  }
  require_moderate("initial_sites", view_points(sites));
  initial_sites_ = std::move(sites);
  return *this;
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_fixed_sites(Columns<Scalar> sites) {
  if (sites.cols() > site_count()) {
    throw InvalidInput("fixed_sites: there are " + std::to_string(sites.cols()) +
                       " of them, but the problem has " + std::to_string(site_count()) +
                       " sites in all");
  }
  if (sites.cols() > 0 && sites.rows() != dimension()) {
    throw InvalidInput("fixed_sites: they have " + std::to_string(sites.rows()) +
                       " dimensions, the points have " + std::to_string(dimension()));
  }
  require_moderate("fixed_sites", view_points(sites));
  fixed_sites_ = std::move(sites);
  return *this;
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_initial_owners(std::vector<Index> owners) {
  std::vector<Index> room = capacities_;
  agree(ranks(), [&] {
    if (std::cmp_not_equal(owners.size(), points().count)) {
      throw InvalidInput("initial_owners: there are " + std::to_string(owners.size()) + " for " +
                         std::to_string(points().count) + " points: there must be one per point");
    }
    for (std::size_t p = 0; p < owners.size(); ++p) {
      const auto owner_is = [&] {
        const std::size_t number = static_cast<std::size_t>(first_own_point()) + p;
        return concat("initial_owners[", number, "] is ", owners[p]);
      };
      if (owners[p] < 0 || owners[p] >= site_count()) {
        throw InvalidInput(owner_is() + ": it must be in 0.." + std::to_string(site_count() - 1));
      }
      const SiteNumber owner(owners[p]);
      if (room[owner]-- == 0) {
        throw InvalidInput(owner_is() + ": that site owns more points than its capacity " +
                           std::to_string(capacities_[owner]) +
                           "; capacities that are not equal must be set first");
      }
    }
  });
  initial_owners_ = std::move(owners);
  return *this;
}

template <class Scalar>
Box Problem<Scalar>::bounding_box() const {
  return ccvt::bounding_box(*this, Arena(threads_));
}

// Each member that is compiled here; a whole class would bring along what is inline.
template CCVT_EXPORT Problem<float>::Problem(PointsView<float>, Index, int);
template CCVT_EXPORT Problem<double>::Problem(PointsView<double>, Index, int);
template CCVT_EXPORT Problem<float>::Problem(Ranks&, PointsView<float>, Index, int);
template CCVT_EXPORT Problem<double>::Problem(Ranks&, PointsView<double>, Index, int);
template CCVT_EXPORT Problem<float>& Problem<float>::set_domain(Domain);
template CCVT_EXPORT Problem<double>& Problem<double>::set_domain(Domain);
template CCVT_EXPORT Problem<float>& Problem<float>::set_capacities(std::vector<Index>);
template CCVT_EXPORT Problem<double>& Problem<double>::set_capacities(std::vector<Index>);
template CCVT_EXPORT Problem<float>& Problem<float>::set_initial_sites(Columns<float>);
template CCVT_EXPORT Problem<double>& Problem<double>::set_initial_sites(Columns<double>);
template CCVT_EXPORT Problem<float>& Problem<float>::set_fixed_sites(Columns<float>);
template CCVT_EXPORT Problem<double>& Problem<double>::set_fixed_sites(Columns<double>);
template CCVT_EXPORT Problem<float>& Problem<float>::set_initial_owners(std::vector<Index>);
template CCVT_EXPORT Problem<double>& Problem<double>::set_initial_owners(std::vector<Index>);
template CCVT_EXPORT Box Problem<float>::bounding_box() const;
template CCVT_EXPORT Box Problem<double>::bounding_box() const;

}  // namespace ccvt
