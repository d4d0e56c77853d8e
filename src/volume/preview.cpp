#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>

#include "ccvt/volume.h"
#include "checks.h"
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
  const double count = view_points(places).count;
  const auto radius_of = [&](double shown) {
    return std::min(std::sqrt(kCovered * pixels / (std::numbers::pi * shown)), kMostRadius);
  };
  if (count == 0 || radius_of(count) >= kLeastRadius) return {0, 1, radius_of(count)};
  const double shown =
      std::min(kLayer * std::pow(count, 2.0 / 3),
               kCovered * pixels / (std::numbers::pi * kLeastRadius * kLeastRadius));
  const double middle = places.row(along).mean();
  Eigen::VectorXd away = (places.row(along).array() - middle).abs();
  const auto last = away.begin() + static_cast<Eigen::Index>(std::clamp(shown, 0.0, count - 1));
  std::nth_element(away.begin(), last, away.end());
  return {middle - *last, middle + *last, radius_of(shown)};
}

/// Where the cells of an axis lie on the pixels of a picture.
struct Line {
  Eigen::Index cells;
  int pixels;

  struct Between {
    Eigen::Index low;
    Eigen::Index high;
    double share;
  };
  [[nodiscard]] Between at(int pixel) const {
    const auto count = static_cast<double>(cells);
    const double position = std::clamp((pixel + 0.5) / pixels * count - 0.5, 0.0, count - 1);
    const double below = std::floor(position);
    const auto low = static_cast<Eigen::Index>(below);
    return {low, std::min(low + 1, cells - 1), position - below};
  }
};

/// A projection along one axis: `across` runs to the right, `up` upwards.
struct Projection {
  Eigen::Index across;
  Eigen::Index up;
  Eigen::Index along;
  Line columns = {};  // of the picture, along `across`
  Line rows = {};
  Dots dots = {};
  Eigen::ArrayXXd sums = {};  // across by up

  /// Which layers of cells along the third axis are shown.
  [[nodiscard]] Eigen::ArrayX<bool> shown(Eigen::Index layers) const {
    Eigen::ArrayX<bool> result(layers);
    const auto count = static_cast<double>(layers);
    double layer = 0;
    for (bool& shows : result) {
      shows = layer / count <= dots.high && (layer + 1) / count > dots.low;
      ++layer;
    }
    return result;
  }
};

/// The densities of the cells that are shown, summed along each axis, in one sweep.
void project(const DensityGrid& grid, std::array<Projection, 3>& result) {
  const Eigen::Index x = grid.shape[0];
  const Eigen::Index y = grid.shape[1];
  const Eigen::Index z = grid.shape[2];
  auto& [front, top, side] = result;
  front.sums.setZero(x, y);
  top.sums.setZero(x, z);
  side.sums.setZero(y, z);
  const Eigen::ArrayX<bool> shows_layer = front.shown(z);
  const Eigen::ArrayX<bool> shows_row = top.shown(y);
  const Eigen::ArrayX<bool> shows_cell = side.shown(x);
  const CellDensities densities(grid);
  Eigen::ArrayXd row(x);
  for (Eigen::Index k = 0; k < z; ++k) {
    for (Eigen::Index j = 0; j < y; ++j) {
      const std::int64_t first = (k * y + j) * x;
      densities.row(first, std::span(row.data(), row.data() + x));
      if (shows_layer[k]) front.sums.col(j) += row;
      if (shows_row[j]) top.sums.col(k) += row;
      for (Eigen::Index i = 0; i < x; ++i) {
        if (shows_cell[i]) side.sums(j, k) += row[i];
      }
    }
  }
}

/// The first byte of a pixel of a picture that starts at column `left` and is `height` high; it is
/// centred in the image.
std::uint8_t* address(ColourImage& image, int left, int height, int column, int row) {
  const std::ptrdiff_t y = (image.height - height) / 2 + row;
  return image.rgb.data() + 3 * (y * image.width + left + column);
}

/// Fractions are cut off.
void paint(const std::array<double, 3>& colour, std::uint8_t* pixel) {
  for (std::size_t c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(colour[c]);
}

void draw_field(const Projection& projection, int left, ColourImage& image) {
  const Line& columns = projection.columns;
  const Line& rows = projection.rows;
  const Eigen::ArrayXXd& sums = projection.sums;
  const double most = std::max(*std::max_element(sums.data(), sums.data() + sums.size()), 1e-300);
  const auto value = [&](Eigen::Index i, Eigen::Index j) { return sums(i, j) / most; };
  for (int row = 0; row < rows.pixels; ++row) {
    const auto [j, j1, v] = rows.at(rows.pixels - 1 - row);
    for (int column = 0; column < columns.pixels; ++column) {
      const auto [i, i1, u] = columns.at(column);
      const double grey = (1 - v) * ((1 - u) * value(i, j) + u * value(i1, j)) +
                          v * ((1 - u) * value(i, j1) + u * value(i1, j1));
      const double shade = kBrightest * std::clamp(grey, 0.0, 1.0);
      paint({shade, shade, shade}, address(image, left, rows.pixels, column, row));
    }
  }
}

/// The row or column of pixels that a coordinate lies in.
int pixel_at(double coordinate) { return static_cast<int>(std::floor(coordinate)); }

/// A disc; pixels on its edge are covered in part.
void draw_dot(double x, double y, double radius, int width, int height, int left,
              ColourImage& image) {
  const double reach = radius + 0.5;
  const int last_row = std::min(height - 1, pixel_at(y + reach));
  const int last_column = std::min(width - 1, pixel_at(x + reach));
  for (int row = std::max(0, pixel_at(y - reach)); row <= last_row; ++row) {
    for (int column = std::max(0, pixel_at(x - reach)); column <= last_column; ++column) {
      const double distance = std::hypot(column + 0.5 - x, row + 0.5 - y);
      const double opacity = kOpacity * std::clamp(reach - distance, 0.0, 1.0);
      std::uint8_t* const pixel = address(image, left, height, column, row);
      const auto over = [&](std::size_t c) {
        return std::round((1 - opacity) * pixel[c] + opacity * kDot[c]);
      };
      paint({over(0), over(1), over(2)}, pixel);
    }
  }
}

/// The samples that a projection shows, over it.
void draw_dots(const Projection& projection, const Eigen::Matrix3Xd& places, int left,
               ColourImage& image) {
  const Dots& dots = projection.dots;
  const int width = projection.columns.pixels;
  const int height = projection.rows.pixels;
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    const double deep = places(projection.along, s);
    const double x = places(projection.across, s);
    const double y = 1 - places(projection.up, s);
    const auto inside = [](double share) { return share >= 0 && share <= 1; };
    if (!inside(x) || !inside(y) || deep < dots.low || deep > dots.high) continue;
    draw_dot(x * width, y * height, dots.radius, width, height, left, image);
  }
}

}  // namespace

template <class Scalar>
ColourImage preview(const DensityGrid& density, PointsView<Scalar> sites, int size) {
  detail::check_density(density, 1, Eigen::Dynamic, sizeof(Scalar));
  require_data("sites", sites);
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
  const double longest = sides.maxCoeff();
  std::array<Line, 3> lines{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double share = sides.data()[d] / longest;
    lines[d] = {density.shape[d], std::max(1, static_cast<int>(std::lround(share * size)))};
  }

  Eigen::Matrix3Xd places(3, sites.count);
  for (Index s = 0; s < sites.count; ++s) {
    const Eigen::Vector3d site(sites[s][0], sites[s][1], sites[s][2]);
    if (!site.allFinite()) {
      throw InvalidInput("sites: site " + std::to_string(s) +
                         " has a coordinate that is not finite");
    }
    places.col(s) = (to_box * (site - offset) - density.box.lower.eigen()).cwiseQuotient(extent);
  }
  std::array<Projection, 3> projections{{{0, 1, 2, lines[0], lines[1]},
                                         {0, 2, 1, lines[0], lines[2]},
                                         {1, 2, 0, lines[1], lines[2]}}};
  ColourImage image;
  image.width = 2 * kGap;
  for (Projection& p : projections) {
    p.dots = choose_dots(places, p.along, 1.0 * p.columns.pixels * p.rows.pixels);
    image.width += p.columns.pixels;
    image.height = std::max(image.height, p.rows.pixels);
  }
  project(density, projections);
  const std::int64_t width = image.width;
  image.rgb.assign(static_cast<std::size_t>(3 * width * image.height), 0);
  int left = 0;
  for (const Projection& p : projections) {
    draw_field(p, left, image);
    draw_dots(p, places, left, image);
    left += p.columns.pixels + kGap;
  }
  return image;
}

template CCVT_EXPORT ColourImage preview<float>(const DensityGrid&, PointsView<float>, int);
template CCVT_EXPORT ColourImage preview<double>(const DensityGrid&, PointsView<double>, int);

}  // namespace ccvt
