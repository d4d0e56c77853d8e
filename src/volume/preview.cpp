#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "ccvt/volume.h"
#include "sampling/cell_densities.h"

namespace ccvt {

namespace {

constexpr int kGap = 8;  // pixels between the pictures
constexpr std::array<double, 3> kDot = {255, 140, 0};
constexpr double kOpacity = 0.85;
constexpr double kBrightest = 150;  // of the field, so that dots stand out
/// Of a picture: what dots may cover. Few samples get larger dots; many a slab, see choose_dots().
constexpr double kCovered = 0.08;
constexpr double kLeastRadius = 1.5;
constexpr double kMostRadius = 2.5;
/// Samples in a slab that is as thick as they are apart, over #samples^(2/3).
constexpr double kLayer = 1.5;

/// The samples that a picture shows: where they are along its third axis, as shares of the box.
struct Dots {
  double low = 0;
  double high = 1;
  double radius = kMostRadius;  // in pixels
};

/// All samples, as large as kCovered allows; or, where that is too small, those of a slab around
/// their middle that is about as thick as they are apart.
Dots choose_dots(const Eigen::Matrix3Xd& places, Eigen::Index along, double pixels) {
  const auto count = static_cast<double>(places.cols());
  const auto radius_of = [&](double shown) {
    return std::min(std::sqrt(kCovered * pixels / (std::numbers::pi * shown)), kMostRadius);
  };
  if (places.cols() == 0 || radius_of(count) >= kLeastRadius) return {0, 1, radius_of(count)};
  const double shown =
      std::min(kLayer * std::pow(count, 2.0 / 3),
               kCovered * pixels / (std::numbers::pi * kLeastRadius * kLeastRadius));
  const double middle = places.row(along).mean();
  std::vector<double> away(static_cast<std::size_t>(places.cols()));
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    away[static_cast<std::size_t>(s)] = std::abs(places(along, s) - middle);
  }
  const auto last = away.begin() + static_cast<std::ptrdiff_t>(std::clamp(shown, 0.0, count - 1));
  std::nth_element(away.begin(), last, away.end());
  return {middle - *last, middle + *last, radius_of(shown)};
}

/// A projection along one axis: `across` runs to the right, `up` upwards.
struct Projection {
  std::size_t across;
  std::size_t up;
  std::size_t along;
  Dots dots;
  std::vector<double> sums;  // `across` varies fastest

  /// Whether the cells of a layer along the third axis are shown.
  [[nodiscard]] bool shows(std::size_t layer, std::size_t layers) const {
    const auto first = static_cast<double>(layer) / static_cast<double>(layers);
    const auto end = static_cast<double>(layer + 1) / static_cast<double>(layers);
    return first <= dots.high && end > dots.low;
  }
};

/// The densities of the cells that are shown, summed along each axis, in one sweep.
void project(const DensityGrid& grid, std::array<Projection, 3>& result) {
  const auto x = static_cast<std::size_t>(grid.shape[0]);
  const auto y = static_cast<std::size_t>(grid.shape[1]);
  const auto z = static_cast<std::size_t>(grid.shape[2]);
  result[0].sums.resize(x * y);
  result[1].sums.resize(x * z);
  result[2].sums.resize(y * z);
  const CellDensities densities(grid);
  std::vector<double> row(x);
  for (std::size_t k = 0; k < z; ++k) {
    const bool shows_layer = result[0].shows(k, z);
    for (std::size_t j = 0; j < y; ++j) {
      const bool shows_row = result[1].shows(j, y);
      const std::size_t first = (k * y + j) * x;
      densities.visit_row(static_cast<std::int64_t>(first), grid.shape[0],
                          [&](std::int64_t cell, double density) {
                            row[static_cast<std::size_t>(cell) - first] = density;
                          });
      for (std::size_t i = 0; i < x; ++i) {
        if (shows_layer) result[0].sums[j * x + i] += row[i];
        if (shows_row) result[1].sums[k * x + i] += row[i];
        if (result[2].shows(i, x)) result[2].sums[k * y + j] += row[i];
      }
    }
  }
}

/// Where the cells of an axis lie on the pixels of a picture.
struct Line {
  std::size_t cells;
  int pixels;

  struct Between {
    std::size_t low;
    std::size_t high;
    double share;
  };
  [[nodiscard]] Between at(int pixel) const {
    const double position = std::clamp((pixel + 0.5) / pixels * static_cast<double>(cells) - 0.5,
                                       0.0, static_cast<double>(cells - 1));
    const auto low = static_cast<std::size_t>(position);
    return {low, std::min(low + 1, cells - 1), position - static_cast<double>(low)};
  }
};

/// The first byte of a pixel of a picture that starts at column `left` and is `height` high; it is
/// centred in the image.
std::size_t address(const ColourImage& image, int left, int height, int column, int row) {
  const int y = (image.height - height) / 2 + row;
  return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
              static_cast<std::size_t>(left + column));
}

void draw_field(const Projection& projection, const Line& across, const Line& up, int left,
                ColourImage& image) {
  const double most =
      std::max(*std::max_element(projection.sums.begin(), projection.sums.end()), 1e-300);
  const auto value = [&](std::size_t i, std::size_t j) {
    return projection.sums[j * across.cells + i] / most;
  };
  for (int row = 0; row < up.pixels; ++row) {
    const auto [j, j1, v] = up.at(up.pixels - 1 - row);
    for (int column = 0; column < across.pixels; ++column) {
      const auto [i, i1, u] = across.at(column);
      const double grey = (1 - v) * ((1 - u) * value(i, j) + u * value(i1, j)) +
                          v * ((1 - u) * value(i, j1) + u * value(i1, j1));
      const std::size_t pixel = address(image, left, up.pixels, column, row);
      std::fill_n(image.rgb.begin() + static_cast<std::ptrdiff_t>(pixel), 3,
                  static_cast<std::uint8_t>(kBrightest * std::clamp(grey, 0.0, 1.0)));
    }
  }
}

/// A disc; pixels on its edge are covered in part.
void draw_dot(double x, double y, double radius, int width, int height, int left,
              ColourImage& image) {
  const double reach = radius + 0.5;
  const int last_row = std::min(height - 1, static_cast<int>(std::floor(y + reach)));
  const int last_column = std::min(width - 1, static_cast<int>(std::floor(x + reach)));
  for (int row = std::max(0, static_cast<int>(y - reach)); row <= last_row; ++row) {
    for (int column = std::max(0, static_cast<int>(x - reach)); column <= last_column; ++column) {
      const double distance = std::hypot(column + 0.5 - x, row + 0.5 - y);
      const double opacity = kOpacity * std::clamp(reach - distance, 0.0, 1.0);
      const std::size_t pixel = address(image, left, height, column, row);
      for (std::size_t c = 0; c < 3; ++c) {
        image.rgb[pixel + c] = static_cast<std::uint8_t>(
            std::lround((1 - opacity) * image.rgb[pixel + c] + opacity * kDot[c]));
      }
    }
  }
}

/// The samples that a projection shows, over it.
void draw_dots(const Projection& projection, const Eigen::Matrix3Xd& places, int width, int height,
               int left, ColourImage& image) {
  const Dots& dots = projection.dots;
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    const double deep = places(static_cast<Eigen::Index>(projection.along), s);
    const double x = places(static_cast<Eigen::Index>(projection.across), s);
    const double y = 1 - places(static_cast<Eigen::Index>(projection.up), s);
    const auto inside = [](double share) { return share >= 0 && share <= 1; };
    if (!inside(x) || !inside(y) || deep < dots.low || deep > dots.high) continue;
    draw_dot(x * width, y * height, dots.radius, width, height, left, image);
  }
}

}  // namespace

template <class Scalar>
ColourImage preview(const DensityGrid& density, PointsView<Scalar> sites, int size) {
  detail::check_density(density, 1, Eigen::Dynamic, sizeof(Scalar));
  if (density.shape.size() != 3 || sites.dimension != 3) {
    throw InvalidInput("preview: the grid has " + std::to_string(density.shape.size()) +
                       " dimensions and the sites have " + std::to_string(sites.dimension) +
                       "; both need 3");
  }
  if (size < 16 || size > 4096) {
    throw InvalidInput("size: is " + std::to_string(size) + "; must be from 16 to 4096");
  }
  const Eigen::Vector3d extent = density.box.extent();
  Eigen::Matrix3d to_box = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  Eigen::Vector3d sides = extent;
  if (density.to_world) {
    to_box = Eigen::Matrix3d(density.to_world->matrix.eigen()).inverse();
    offset = density.to_world->offset.eigen();
    sides = extent.cwiseProduct(density.to_world->matrix.eigen().colwise().norm().transpose());
  }
  std::array<Line, 3> lines{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double share = sides[static_cast<Eigen::Index>(d)] / sides.maxCoeff();
    lines[d] = {static_cast<std::size_t>(density.shape[d]),
                std::max(1, static_cast<int>(std::lround(share * size)))};
  }

  Eigen::Matrix3Xd places(3, sites.count);
  for (Index s = 0; s < sites.count; ++s) {
    const Eigen::Vector3d site(sites[s][0], sites[s][1], sites[s][2]);
    places.col(s) = (to_box * (site - offset) - density.box.lower.eigen()).cwiseQuotient(extent);
  }
  std::array<Projection, 3> projections{{{0, 1, 2, {}, {}}, {0, 2, 1, {}, {}}, {1, 2, 0, {}, {}}}};
  ColourImage image;
  image.width = 2 * kGap;
  for (Projection& p : projections) {
    const double pixels = static_cast<double>(lines[p.across].pixels) * lines[p.up].pixels;
    p.dots = choose_dots(places, static_cast<Eigen::Index>(p.along), pixels);
    image.width += lines[p.across].pixels;
    image.height = std::max(image.height, lines[p.up].pixels);
  }
  project(density, projections);
  image.rgb.assign(
      3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 0);
  int left = 0;
  for (const Projection& p : projections) {
    draw_field(p, lines[p.across], lines[p.up], left, image);
    draw_dots(p, places, lines[p.across].pixels, lines[p.up].pixels, left, image);
    left += lines[p.across].pixels + kGap;
  }
  return image;
}

template CCVT_EXPORT ColourImage preview<float>(const DensityGrid&, PointsView<float>, int);
template CCVT_EXPORT ColourImage preview<double>(const DensityGrid&, PointsView<double>, int);

}  // namespace ccvt
