#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/volume.h"
#include "sampling/cell_densities.h"

namespace ccvt {

namespace {

constexpr int kGap = 8;  // pixels between the pictures
constexpr std::array<double, 3> kDot = {255, 140, 0};
constexpr double kOpacity = 0.75;
/// Of a picture: what dots may cover. Few samples get larger dots, up to 5 pixels wide.
constexpr double kCovered = 0.1;
constexpr int kMostHalfWidth = 2;
constexpr double kBrightest = 150;  // of the field, so that dots stand out

/// A projection along one axis: `across` runs to the right, `up` upwards.
struct Projection {
  std::size_t across;
  std::size_t up;
  std::vector<double> sums;  // `across` varies fastest
};

/// The densities summed along each axis, in one sweep.
std::array<Projection, 3> project(const DensityGrid& grid) {
  const auto x = static_cast<std::size_t>(grid.shape[0]);
  const auto y = static_cast<std::size_t>(grid.shape[1]);
  const auto z = static_cast<std::size_t>(grid.shape[2]);
  std::array<Projection, 3> result{{{0, 1, std::vector<double>(x * y)},
                                    {0, 2, std::vector<double>(x * z)},
                                    {1, 2, std::vector<double>(y * z)}}};
  const CellDensities densities(grid);
  std::vector<double> row(x);
  for (std::size_t k = 0; k < z; ++k) {
    for (std::size_t j = 0; j < y; ++j) {
      const std::size_t first = (k * y + j) * x;
      double sum = 0;
      densities.visit_row(static_cast<std::int64_t>(first), grid.shape[0],
                          [&](std::int64_t cell, double density) {
                            row[static_cast<std::size_t>(cell) - first] = density;
                            sum += density;
                          });
      for (std::size_t i = 0; i < x; ++i) {
        result[0].sums[j * x + i] += row[i];
        result[1].sums[k * x + i] += row[i];
      }
      result[2].sums[k * y + j] += sum;
    }
  }
  return result;
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

/// Pixels on each side of a dot's middle.
int half_width_of_dots(Index samples, int width, int height) {
  const double each = kCovered * width * height / static_cast<double>(std::max<Index>(1, samples));
  return std::clamp(static_cast<int>(std::sqrt(each) / 2), 0, kMostHalfWidth);
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

  const auto place_of = [&](Index s) {
    return Eigen::Vector3d(sites[s][0], sites[s][1], sites[s][2]);
  };
  const std::array<Projection, 3> projections = project(density);
  ColourImage image;
  image.width = 2 * kGap;
  for (const Projection& p : projections) {
    image.width += lines[p.across].pixels;
    image.height = std::max(image.height, lines[p.up].pixels);
  }
  image.rgb.assign(
      3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 0);
  int left = 0;
  for (const Projection& p : projections) {
    const Line& across = lines[p.across];
    const Line& up = lines[p.up];
    draw_field(p, across, up, left, image);
    const int half = half_width_of_dots(sites.count, across.pixels, up.pixels);
    for (Index s = 0; s < sites.count; ++s) {
      const Eigen::Vector3d place =
          (to_box * (place_of(s) - offset) - density.box.lower.eigen()).cwiseQuotient(extent);
      const auto column =
          static_cast<int>(place[static_cast<Eigen::Index>(p.across)] * across.pixels);
      const auto row = static_cast<int>((1 - place[static_cast<Eigen::Index>(p.up)]) * up.pixels);
      if (column < 0 || column >= across.pixels || row < 0 || row >= up.pixels) continue;
      for (int y = std::max(0, row - half); y <= std::min(up.pixels - 1, row + half); ++y) {
        for (int x = std::max(0, column - half); x <= std::min(across.pixels - 1, column + half);
             ++x) {
          const std::size_t pixel = address(image, left, up.pixels, x, y);
          for (std::size_t c = 0; c < 3; ++c) {
            image.rgb[pixel + c] = static_cast<std::uint8_t>((1 - kOpacity) * image.rgb[pixel + c] +
                                                             kOpacity * kDot[c]);
          }
        }
      }
    }
    left += across.pixels + kGap;
  }
  return image;
}

template CCVT_EXPORT ColourImage preview<float>(const DensityGrid&, PointsView<float>, int);
template CCVT_EXPORT ColourImage preview<double>(const DensityGrid&, PointsView<double>, int);

}  // namespace ccvt
