#include "ccvt/stipple.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/domain.h"
#include "ccvt/problem.h"
#include "ccvt/region.h"
#include "ccvt/solver.h"
#include "number_text.h"
#include "parallel/arena.h"
#include "point_count.h"
#include "thread_count.h"

namespace ccvt {

namespace {

void require_gamma(double gamma) {
  if (gamma > 0 && std::isfinite(gamma)) return;
  throw InvalidInput("gamma: is " + text(gamma) + "; must be positive and finite");
}

void require_pixels(const Image& image) {
  const std::int64_t width = image.width;
  if (image.width >= 1 && image.height >= 1 && std::ssize(image.values) == width * image.height) {
    return;
  }
  throw InvalidInput("image: has " + std::to_string(image.values.size()) + " values for " +
                     std::to_string(image.width) + " x " + std::to_string(image.height) +
                     " pixels; needs at least one pixel, and one value for each");
}

/// Moves dots on paper that is to stay blank to the nearest of their points.
template <class Scalar>
void put_back(const Points<Scalar>& points, const Solver<Scalar>& solver,
              std::span<const float> dark, Stippling<Scalar>& stippling) {
  const auto pixel = [](double x, int count) {
    return static_cast<std::size_t>(std::clamp(x, 0.0, count - 1.0));
  };
  const auto inked = [&](double x, double y) {
    const std::size_t row = pixel(y, stippling.height) * static_cast<std::size_t>(stippling.width);
    return dark[row + pixel(x, stippling.width)] > 0;
  };
  bool all_inked = true;  // as in most photographs: then it need not be known who owns what
  for (Index dot = 0; dot < stippling.dots.cols(); ++dot) {
    all_inked = all_inked && inked(stippling.dots(0, dot), stippling.dots(1, dot));
  }
  if (all_inked) return;
  const std::span<Scalar> dots(stippling.dots.data(),
                               static_cast<std::size_t>(stippling.dots.size()));
  const Region region = [&](std::span<const double> dot) { return inked(dot[0], dot[1]); };
  const PutBack moved =
      detail::put_back(view_points(points), solver.owners(), dots, region, Domain());
  stippling.put_back = moved.sites;
  stippling.farthest_put_back = moved.farthest;
}

}  // namespace

void StippleOptions::validate() const {
  if (points_per_site < 1) {
    throw InvalidInput("points_per_site: is " + std::to_string(points_per_site) +
                       "; must be at least 1");
  }
  require_gamma(gamma);
  if (!(dot_radius >= 0 && std::isfinite(dot_radius))) {
    throw InvalidInput("dot_radius: is " + text(dot_radius) + "; must be at least 0 and finite");
  }
  tessellation.validate();
}

std::vector<float> darkness(const Image& image, bool invert, double gamma, int threads) {
  require_threads(threads);
  require_gamma(gamma);
  require_pixels(image);
  constexpr std::size_t kPixelsPerGrain = std::size_t{1} << 14;
  std::vector<float> result(image.values);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (result[i] >= 0 && result[i] <= 1) continue;
    throw InvalidInput("image: value " + std::to_string(i) + " is " + text(result[i]) +
                       "; must be in [0, 1]");
  }
  const Arena arena(result.size() <= kPixelsPerGrain ? 1 : threads);
  arena.for_each(result.size(), kPixelsPerGrain, [&](std::size_t i) {
    const float dark = invert ? result[i] : 1 - result[i];
    result[i] = gamma == 1 ? dark : static_cast<float>(std::pow(dark, gamma));
  });
  return result;
}

template <class Scalar>
Stippling<Scalar> stipple(const Image& image, Index sites, const StippleOptions& options) {
  options.validate();
  const Index points = checked_point_count(sites, options.points_per_site);
  const std::vector<float> dark =
      darkness(image, options.invert, options.gamma, options.tessellation.threads);
  const double ink = std::accumulate(dark.begin(), dark.end(), 0.0);
  if (!(ink > 0)) {
    throw InvalidInput(std::string("image: is ") + (options.invert ? "black" : "white") +
                       " everywhere" +
                       (options.gamma > 1 ? " with gamma " + text(options.gamma) : "") +
                       "; there is nothing to stipple");
  }
  Box box{{0, 0}, {1.0 * image.width, 1.0 * image.height}};
  const DensityGrid density{std::span<const float>(dark), {image.width, image.height}, box};

  Stippling<Scalar> result;
  result.width = image.width;
  result.height = image.height;
  {
    const Points<Scalar> sampled = sample_density<Scalar>(
        density, points, options.tessellation.seed, DensitySampling::stratified,
        options.tessellation.threads, options.tessellation.cancelled);
    Problem<Scalar> problem(sampled, sites, options.tessellation.threads);
    problem.set_domain(Domain::euclidean(std::move(box)));
    Solver<Scalar> solver(std::move(problem), options.tessellation);
    solver.run();
    result.dots = solver.sites();
    result.summary = solver.summary();
    put_back(sampled, solver, dark, result);
  }
  result.dot_radius = options.dot_radius > 0 ? options.dot_radius
                                             : dot_radius_for(view_points(result.dots), image.width,
                                                              image.height, ink);
  return result;
}

template CCVT_EXPORT Stippling<float> stipple<float>(const Image&, Index, const StippleOptions&);
template CCVT_EXPORT Stippling<double> stipple<double>(const Image&, Index, const StippleOptions&);

}  // namespace ccvt
