#include "ccvt/problem.h"

#include <cmath>
#include <string>
#include <utility>

#include "bounds.h"
#include "number_text.h"
#include "numbers.h"
#include "scales.h"
#include "thread_count.h"

namespace ccvt {
namespace {

/// Fewer points are checked by one thread: others would not have started before the end.
constexpr Index kPointsForThreads = 1 << 18;

/// Points are not looked at one by one unless one of them is outside.
template <class Scalar>
void require_inside(const char* argument, const PointsView<Scalar>& points, const Box& box,
                    const Arena& arena) {
  const CoordinateRange<Scalar> range = coordinate_range(points, arena);
  bool inside = true;
  for (std::size_t d = 0; d < range.lower.size(); ++d) {
    inside =
        inside && range.lower[d] >= box.lower.data()[d] && range.upper[d] <= box.upper.data()[d];
  }
  for (Index p = 0; p < points.count && !inside; ++p) {
    for (int d = 0; d < points.dimension; ++d) {
      const double value = points[p][d];
      if (value >= box.lower[d] && value <= box.upper[d]) continue;
      throw InvalidInput(std::string(argument) + ": coordinate " + std::to_string(d) + " of " +
                         argument + "[" + std::to_string(p) + "] is " + text(value) +
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

}  // namespace

template <class Scalar>
Problem<Scalar>::Problem(PointsView<Scalar> points, Index sites, int threads)
    : points_(points), threads_(points.count < kPointsForThreads ? 1 : threads) {
  require_threads(threads);
  if (points.dimension < 1) throw InvalidInput("points: they have no dimension");
  if (points.count < 1) throw InvalidInput("points: there are none");
  if (points.data == nullptr) throw InvalidInput("points: the view has no data");
  if (points.dimension > 1 && points.stride < points.dimension) {
    throw InvalidInput("points: the stride is " + std::to_string(points.stride) +
                       ": it must be at least the dimension, " + std::to_string(points.dimension));
  }
  capacities_ = equal_capacities(points.count, sites);
  require_scale("points", points, Arena(threads_));
}

template <class Scalar>
Problem<Scalar>& Problem<Scalar>::set_domain(Domain domain) {
  if (domain.has_box()) {
    if (domain.box().dimension() != dimension()) {
      throw InvalidInput("domain: its box has " + std::to_string(domain.box().dimension()) +
                         " dimensions, the points have " + std::to_string(dimension()));
    }
    require_scale<Scalar>(domain);
    require_inside("points", points_, domain.box(), Arena(threads_));
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
  // Owners that are there own as many points as the capacities in force say.
  for (std::size_t s = 0; s < capacities.size() && !initial_owners_.empty(); ++s) {
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
  if (std::cmp_not_equal(owners.size(), point_count())) {
    throw InvalidInput("initial_owners: there are " + std::to_string(owners.size()) + " for " +
                       std::to_string(point_count()) + " points: there must be one per point");
  }
  std::vector<Index> room = capacities_;
  for (std::size_t p = 0; p < owners.size(); ++p) {
    const std::string element = "initial_owners[" + std::to_string(p) + "]";
    if (owners[p] < 0 || owners[p] >= site_count()) {
      throw InvalidInput(element + " is " + std::to_string(owners[p]) + ": it must be in 0.." +
                         std::to_string(site_count() - 1));
    }
    const SiteNumber owner(owners[p]);
    if (room[owner]-- == 0) {
      throw InvalidInput(element + " is " + std::to_string(owners[p]) +
                         ": that site owns more points than its capacity " +
                         std::to_string(capacities_[owner]) +
                         "; capacities that are not equal must be set first");
    }
  }
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
