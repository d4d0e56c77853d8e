#include "ccvt/region.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "geometry/fitted.h"
#include "geometry/metric.h"
#include "put_back.h"
#include "scales.h"

namespace ccvt {
namespace {

template <class Scalar>
PutBack put_back_to(PointsView<Scalar> points, std::span<const Index> owners,
                    std::span<Scalar> sites, const Region& region, const Domain& domain) {
  if (!region) throw InvalidInput("region: is empty, but must be callable");
  if (std::cmp_not_equal(owners.size(), points.count)) {
    throw InvalidInput("owners: there are " + std::to_string(owners.size()) + " for " +
                       std::to_string(points.count) + " points: there must be one per point");
  }
  if (points.dimension < 1) throw InvalidInput("points: they have no dimension");
  if (sites.empty()) throw InvalidInput("sites: there are none");
  if (domain.has_box() && domain.box().dimension() != points.dimension) {
    throw InvalidInput("domain: its box has " + std::to_string(domain.box().dimension()) +
                       " dimensions, the points have " + std::to_string(points.dimension));
  }
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const std::size_t count = sites.size() / dimension;
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] >= 0 && std::cmp_less(owners[p], count)) continue;
    throw InvalidInput("owners[" + std::to_string(p) + "] is " + std::to_string(owners[p]) +
                       ": it must be in 0.." + std::to_string(count - 1));
  }
  const PointsView<Scalar> all_sites{sites.data(), points.dimension, static_cast<Index>(count),
                                     points.dimension};
  require_moderate("points", points);
  require_moderate("sites", all_sites);
  const Metric metric(points.dimension, measured_domain(domain, points, all_sites));
  const auto at = [&](SiteNumber s) { return sites.data() + s * dimension; };
  std::vector<double> position(dimension);
  return put_back_sites(
      owners, count, Arena(1),
      [&](SiteNumber s) {
        std::copy_n(at(s), dimension, position.begin());
        return !region(position);
      },
      [&](PointNumber p, SiteNumber s) {
        return metric.squared_distance_of_images(points[p.index()], at(s));
      },
      [&](SiteNumber s, PointNumber p) { std::copy_n(points[p.index()], dimension, at(s)); });
}

}  // namespace

namespace detail {

std::string about_region(const std::string& message) {
  const std::string density = "density: ";
  if (message.rfind(density, 0) != 0) return message;
  return "region: has no points in the box, or too few to be found: the density that is 1 in it " +
         message.substr(density.size());
}

PutBack put_back(PointsView<float> points, std::span<const Index> owners, std::span<float> sites,
                 const Region& region, const Domain& domain) {
  return put_back_to(points, owners, sites, region, domain);
}

PutBack put_back(PointsView<double> points, std::span<const Index> owners, std::span<double> sites,
                 const Region& region, const Domain& domain) {
  return put_back_to(points, owners, sites, region, domain);
}

}  // namespace detail
}  // namespace ccvt
