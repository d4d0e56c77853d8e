#include <cmath>
#include <string>
#include <utility>

#include "ccvt/capacity.h"
#include "ccvt/metrics.h"
#include "checks.h"
#include "geometry/fitted.h"
#include "geometry/metric.h"
#include "metrics/sets.h"
#include "number_text.h"
#include "numbers.h"
#include "scales.h"

namespace ccvt {

namespace {

/// (|box| / count)^(1/D), by logarithms: a volume in high dimension is soon out of range.
double spacing_in(const Box& box, double count) {
  return std::exp((box.extent().array().log().sum() - std::log(count)) / box.dimension());
}

}  // namespace

template <class Scalar>
double energy(PointsView<Scalar> points, PointsView<Scalar> sites, std::span<const Index> owners,
              const Domain& domain) {
  require_data("points", points);
  require_data("sites", sites);
  if (points.dimension != sites.dimension) {
    throw InvalidInput("sites: have " + std::to_string(sites.dimension) +
                       " coordinates, points have " + std::to_string(points.dimension) +
                       ": the two must be equal");
  }
  if (domain.has_box() && domain.box().dimension() != points.dimension) {
    throw InvalidInput("domain: has " + std::to_string(domain.box().dimension()) +
                       " dimensions, points have " + std::to_string(points.dimension) +
                       ": the two must be equal");
  }
  if (std::ssize(owners) != points.count) {
    throw InvalidInput("owners: there are " + std::to_string(owners.size()) + " for " +
                       std::to_string(points.count) + " points: the two must be equal");
  }
  if (sites.count < 1) throw InvalidInput("sites: there are none");
  const Metric metric(points.dimension, measured_domain(domain, points, sites));
  double sum = 0;
  for (const PointNumber p : points_below(points.count)) {
    const Index owner = owners[p];
    if (owner < 0 || owner >= sites.count) {
      throw InvalidInput("owners[" + std::to_string(p.index()) + "] is " + std::to_string(owner) +
                         ": it must be in 0.." + std::to_string(sites.count - 1));
    }
    sum += metric.squared_distance_of_images(points[p.index()], sites[owner]);
  }
  if (!std::isfinite(sum)) {
    throw InvalidInput(
        "points, sites: coordinates are not finite, or the sum of their squared "
        "distances exceeds the range of double");
  }
  return sum;
}

double normalized_energy(double energy, std::int64_t points, Index sites, const Box& box) {
  if (!(energy >= 0)) {
    throw InvalidInput("energy: is " + text(energy) + "; must be at least 0");
  }
  if (points < 1) throw InvalidInput("points: " + std::to_string(points) + " is not positive");
  if (sites < 1) throw InvalidInput("sites: " + std::to_string(sites) + " is not positive");
  if (box.dimension() < 1) throw InvalidInput("box: has no dimension");
  require_corners(box);
  for (int d = 0; d < box.dimension(); ++d) {
    if (box.upper[d] > box.lower[d]) continue;
    throw InvalidInput("box: dimension " + std::to_string(d) + " goes from " + text(box.lower[d]) +
                       " to " + text(box.upper[d]) + "; its extent must be positive");
  }
  const double spacing = spacing_in(box, sites);
  const double squared = spacing * spacing;
  // In a box so thin that the square underflows.
  const auto m = static_cast<double>(points);
  if (!std::isnormal(squared)) return energy / m / spacing / spacing;
  return energy / m / squared;
}

double imbalance_factor(std::span<const Index> owners, Index sites) {
  return 1 + capacity_error(owners, sites);
}

PointSet::PointSet(Columns<double> points, Domain domain)
    : points_(std::move(points)), domain_(std::move(domain)) {
  if (points_.rows() < 1) throw InvalidInput("points: have no dimensions");
  if (points_.cols() > INT32_MAX) {
    throw InvalidInput("points: there are " + std::to_string(points_.cols()) +
                       " of them, but at most 2147483647 are supported");
  }
  if (points_.cols() < 2) {
    throw InvalidInput("points: there " + std::string(points_.cols() == 1 ? "is one" : "are none") +
                       "; at least two are needed");
  }
  if (!domain_.has_box()) {
    throw InvalidInput("domain: has no box; the box that the points fill is needed");
  }
  if (domain_.is_partly_periodic()) {
    throw InvalidInput(
        "domain: some dimensions are periodic and others are not: spectra are defined for all or "
        "none");
  }
  const Box& box = domain_.box();
  if (box.dimension() != dimension()) {
    throw InvalidInput("domain: has " + std::to_string(box.dimension()) +
                       " dimensions, points have " + std::to_string(dimension()) +
                       ": the two must be equal");
  }
  const double largest = largest_coordinate<double>(dimension());
  for (int d = 0; d < dimension(); ++d) {
    const double extent = box.upper[d] - box.lower[d];
    if (std::abs(box.lower[d]) <= largest && std::abs(box.upper[d]) <= largest &&
        extent >= kSmallestExtent<double>) {
      continue;
    }
    throw InvalidInput("domain: dimension " + std::to_string(d) + " of its box goes from " +
                       text(box.lower[d]) + " to " + text(box.upper[d]) +
                       ": both must be at most " + text(largest) + " in magnitude, and " +
                       text(kSmallestExtent<double>) + " or more apart");
  }
  for (Eigen::Index p = 0; p < points_.cols(); ++p) {
    for (Eigen::Index d = 0; d < points_.rows(); ++d) {
      const double x = points_(d, p);
      if (x >= box.lower[d] && x <= box.upper[d]) continue;
      throw InvalidInput("points: coordinate " + std::to_string(d) + " of point " +
                         std::to_string(p) + " is " + text(x) + ", outside the box, which goes " +
                         "from " + text(box.lower[d]) + " to " + text(box.upper[d]));
    }
  }
  if ((points_.eigen().colwise() - points_.col(0)).isZero(0)) {
    throw InvalidInput("points: all " + std::to_string(points_.cols()) +
                       " of them are equal; at least two must differ");
  }
  mean_spacing_ = spacing_in(box, count());
}

void check_alike(std::span<const PointSet> sets) {
  if (sets.empty()) throw InvalidInput("sets: there are none");
  for (const PointSet& set : sets) require_points(set);
  const PointSet& first = sets.front();
  for (std::size_t s = 1; s < sets.size(); ++s) {
    const PointSet& set = sets[s];
    const std::string name = "sets[" + std::to_string(s) + "] ";
    if (set.dimension() != first.dimension()) {
      throw InvalidInput(name + "has " + std::to_string(set.dimension()) + " dimensions, sets[0] " +
                         std::to_string(first.dimension()) + ": sets of one kind must agree");
    }
    if (set.count() != first.count()) {
      throw InvalidInput(name + "has " + std::to_string(set.count()) + " points, sets[0] " +
                         std::to_string(first.count()) + ": sets of one kind must agree");
    }
    const Domain& a = set.domain();
    const Domain& b = first.domain();
    if (a.is_periodic() != b.is_periodic() || a.box().lower != b.box().lower ||
        a.box().upper != b.box().upper) {
      throw InvalidInput(name + "has another domain than sets[0]: sets of one kind must agree");
    }
  }
}

template CCVT_EXPORT double energy<float>(PointsView<float>, PointsView<float>,
                                          std::span<const Index>, const Domain&);
template CCVT_EXPORT double energy<double>(PointsView<double>, PointsView<double>,
                                           std::span<const Index>, const Domain&);

}  // namespace ccvt
