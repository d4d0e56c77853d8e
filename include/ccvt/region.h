#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "ccvt/density.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/types.h"

/// Samples of a region of any shape, with holes or not, that a predicate describes:
///
///     const auto ring = [](std::span<const double> x) {
///       const double r = std::hypot(x[0], x[1]);
///       return r > 0.4 && r < 1;
///     };
///     const ccvt::Box box{{-1, -1}, {1, 1}};
///     const auto points = ccvt::sample_region<double, 2>(ring, box, 256'000);
///     auto [sites, owners, summary] = ccvt::tessellate(points, 1000, ccvt::Options::samples());
///     ccvt::put_back(points, owners, sites, ring);
namespace ccvt {

/// Whether a point of a box lies in the region. Where several threads are used, it is called by
/// several at once.
using Region = std::function<bool(std::span<const double>)>;

namespace detail {
/// What is said of a density that is 1 in the region, said of the region.
CCVT_EXPORT std::string about_region(const std::string& message);
}  // namespace detail

/// Exactly `count` points, #dimensions by #points, that spread uniformly over the region in `box`:
/// sample_function() of a density that is 1 there and 0 elsewhere, with what is said there on time,
/// memory, threads and exceptions. Every point, rounded to Scalar, lies in the region.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_region(
    const Region& region, const Box& box, Index count, std::uint64_t seed = 0,
    DensitySampling sampling = DensitySampling::stratified, int threads = 1,
    const std::function<bool()>& cancelled = {}) {
  if (!region) throw InvalidInput("region: is empty, but must be callable");
  const auto density = [&region](std::span<const double> x) { return region(x) ? 1.0 : 0.0; };
  try {
    return sample_function<Scalar, Dimension>(density, 1, box, count, seed, sampling, threads,
                                              cancelled);
  } catch (const InvalidInput& error) {
    throw InvalidInput(detail::about_region(error.what()));
  }
}

/// What put_back() has done.
struct PutBack {
  Index sites = 0;      ///< how many were moved
  double farthest = 0;  ///< how far, at most
};

namespace detail {
CCVT_EXPORT PutBack put_back(PointsView<float> points, std::span<const Index> owners,
                             std::span<float> sites, const Region& region, const Domain& domain);
CCVT_EXPORT PutBack put_back(PointsView<double> points, std::span<const Index> owners,
                             std::span<double> sites, const Region& region, const Domain& domain);
}  // namespace detail

/// Moves the sites that lie outside the region, such as the centroid of a cell that bends round a
/// hole, to the nearest of their own points; of several, to the first. A site without points stays.
/// `points`: #dimensions by m; `owners`: m numbers in 0..n-1; `sites`: #dimensions by n, one at
/// least. Asks the region once a site. O(m). Throws InvalidInput where these do not agree, are not
/// finite, or too large (see Problem).
template <class Derived, int Dimension>
PutBack put_back(const Eigen::DenseBase<Derived>& points, std::span<const Index> owners,
                 Eigen::Matrix<typename Derived::Scalar, Dimension, Eigen::Dynamic>& sites,
                 const Region& region, const Domain& domain = {}) {
  const auto view = view_points(points);
  if (sites.rows() != view.dimension) {
    throw InvalidInput("sites: have " + std::to_string(sites.rows()) + " dimensions, the points " +
                       std::to_string(view.dimension) + ": the two must be equal");
  }
  using Scalar = typename Derived::Scalar;
  return detail::put_back(view, owners,
                          std::span<Scalar>(sites.data(), static_cast<std::size_t>(sites.size())),
                          region, domain);
}

}  // namespace ccvt
