#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "ccvt/surface.h"
#include "number_text.h"
#include "surface/triangles.h"

namespace ccvt {

namespace {

constexpr int kFine = 2;  // pixels of the canvas along each side of one of the picture
constexpr double kMargin = 0.03;
constexpr double kDot = 0.27;      // the radius of a dot, in spacings
constexpr double kLeastDot = 1.1;  // in pixels of the picture
constexpr double kFlattest = 0.1;  // a dot seen more from the side is not drawn
/// A surface whose normal differs from that of a dot by no more than 60 degrees bends away from it,
/// and may be nearer than a dot that shows; any other hides it, but for rounding.
constexpr double kBends = 0.5;
constexpr double kRounding = 0.5;  // in pixels of the canvas
constexpr std::array<double, 3> kSurface = {216, 222, 230};
constexpr std::array<double, 3> kInk = {190, 60, 10};
constexpr std::array<std::uint8_t, 3> kBackground = {255, 255, 255};

/// Where things are on the canvas: x to the right and y down in its pixels, z towards the viewer,
/// in pixels too.
class View {
 public:
  View(const Triangles& triangles, int size, int up) {
    const Eigen::Vector3d towards = Eigen::Vector3d(0.5, -0.75, 0.5).normalized();
    const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(towards).normalized();
    turn_.row(0) = right;
    turn_.row(1) = -towards.cross(right);
    turn_.row(2) = towards;
    Eigen::Matrix3d upright = Eigen::Matrix3d::Zero();  // what points up becomes z
    for (int d = 0; d < 3; ++d) upright(d, (up + 1 + d) % 3) = 1;
    turn_ *= upright;
    const auto turned = [&](const Eigen::Vector3d& corner) -> Eigen::Vector3d {
      return turn_ * (corner - triangles.middle());
    };
    const Eigen::AlignedBox3d seen = box_around(triangles.mesh(), turned);
    const Eigen::Vector3d extent = seen.sizes();
    const double longest = extent.head<2>().maxCoeff() * (1 + 2 * kMargin);
    scale_ = size * kFine / longest;
    const auto pixels = [&](double side) {
      const double wanted =
          std::ceil((side + 2 * kMargin * extent.head<2>().maxCoeff()) / longest * size);
      return std::clamp(static_cast<int>(wanted), 1, size);
    };
    width = kFine * pixels(extent[0]);
    height = kFine * pixels(extent[1]);
    offset_ = Eigen::Vector3d(width, height, 0) / 2 - scale_ * (seen.min() + seen.max()) / 2;
  }

  /// Of a place relative to the middle of the mesh.
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& at) const {
    return scale_ * (turn_ * at) + offset_;
  }
  [[nodiscard]] Eigen::Vector3d direction(const Eigen::Vector3d& normal) const {
    return turn_ * normal;
  }
  [[nodiscard]] double scale() const { return scale_; }

  int width = 0;
  int height = 0;

 private:
  Eigen::Matrix3d turn_;
  double scale_ = 1;
  Eigen::Vector3d offset_;
};

/// Colours, how near to the viewer what they show is, and which way it faces.
class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        near_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
              -std::numeric_limits<float>::infinity()),
        facing_(near_.size()),
        colours_(near_.size(), kBackground) {}

  /// Calls visit(x, y, pixel) for the pixels whose centres are in a box, x and y being those.
  template <class Visit>
  void visit(const Eigen::Vector2d& lower, const Eigen::Vector2d& upper, const Visit& visit) const {
    const auto first = [](double at, int pixels) {
      return static_cast<int>(std::clamp<double>(std::ceil(at - 0.5), 0, pixels));
    };
    const auto last = [](double at, int pixels) {
      return static_cast<int>(std::clamp<double>(std::floor(at - 0.5), -1, pixels - 1));
    };
    for (int row = first(lower[1], height_); row <= last(upper[1], height_); ++row) {
      for (int column = first(lower[0], width_); column <= last(upper[0], width_); ++column) {
        visit(column + 0.5, row + 0.5,
              static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                  static_cast<std::size_t>(column));
      }
    }
  }
  /// Corners as View::place() gives them, one a column.
  void draw_triangle(const Eigen::Matrix3d& at, const Eigen::Vector3d& normal);
  /// A disk around a place, across a normal. Hidden where a surface that faces another way is
  /// nearer, or one that faces as it does by more than its radius, and where it is too far away to
  /// be a number.
  void draw_disk(const Eigen::Vector3d& at, const Eigen::Vector3d& normal, double radius);

  [[nodiscard]] ColourImage picture() const;

 private:
  int width_;
  int height_;
  std::vector<float> near_;
  std::vector<Eigen::Vector3<std::int8_t>> facing_;  ///< the normal, in 127ths
  std::vector<std::array<std::uint8_t, 3>> colours_;
};

std::array<std::uint8_t, 3> shaded(const std::array<double, 3>& colour, double light) {
  std::array<std::uint8_t, 3> result{};
  for (std::size_t c = 0; c < 3; ++c) {
    result[c] = static_cast<std::uint8_t>(std::clamp(colour[c] * light, 0.0, 255.0));
  }
  return result;
}

/// The brightness of a surface with that normal, as the viewer sees it: from the upper left.
double light_on(const Eigen::Vector3d& normal) {
  static const Eigen::Vector3d light = Eigen::Vector3d(-0.4, -0.6, 0.7).normalized();
  const Eigen::Vector3d seen = normal[2] < 0 ? Eigen::Vector3d(-normal) : normal;
  return 0.45 + 0.55 * std::max(seen.dot(light), 0.0);
}

void Canvas::draw_triangle(const Eigen::Matrix3d& at, const Eigen::Vector3d& normal) {
  const auto colour = shaded(kSurface, light_on(normal));
  const Eigen::Vector3<std::int8_t> facing =
      (127 * normal).array().round().matrix().cast<std::int8_t>();
  const Eigen::Matrix2d sides = (at.rightCols<2>().colwise() - at.col(0)).topRows<2>();
  const double area = sides(0, 0) * sides(1, 1) - sides(0, 1) * sides(1, 0);
  if (area == 0) return;
  const auto planar = at.topRows<2>();
  visit(planar.rowwise().minCoeff(), planar.rowwise().maxCoeff(),
        [&](double x, double y, std::size_t pixel) {
          const double dx = x - at(0, 0);
          const double dy = y - at(1, 0);
          const double second = (dx * sides(1, 1) - dy * sides(0, 1)) / area;
          const double third = (dy * sides(0, 0) - dx * sides(1, 0)) / area;
          if (second < 0 || third < 0 || second + third > 1) return;
          const double z =
              at(2, 0) + second * (at(2, 1) - at(2, 0)) + third * (at(2, 2) - at(2, 0));
          const auto near = static_cast<float>(z);
          if (near <= near_[pixel]) return;
          near_[pixel] = near;
          facing_[pixel] = facing;
          colours_[pixel] = colour;
        });
}

void Canvas::draw_disk(const Eigen::Vector3d& at, const Eigen::Vector3d& normal, double radius) {
  if (!(std::abs(normal[2]) >= kFlattest) || !at.allFinite()) return;
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(radius);
  const auto colour = shaded(kInk, 0.4 + 0.6 * light_on(normal));
  visit(at.head<2>() - reach, at.head<2>() + reach, [&](double x, double y, std::size_t pixel) {
    const double dx = x - at[0];
    const double dy = y - at[1];
    const double dz = -(normal[0] * dx + normal[1] * dy) / normal[2];
    if (dx * dx + dy * dy + dz * dz > radius * radius) return;
    const bool bends = facing_[pixel].cast<double>().dot(normal) >= 127 * kBends;
    const double before = bends ? radius : kRounding;
    if (at[2] + dz + before < near_[pixel] || !std::isfinite(near_[pixel])) return;
    colours_[pixel] = colour;
  });
}

ColourImage Canvas::picture() const {
  ColourImage image{width_ / kFine, height_ / kFine, {}};
  const auto wide = static_cast<std::size_t>(width_);
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row) {
    for (std::size_t column = 0; column < static_cast<std::size_t>(image.width); ++column) {
      for (std::size_t c = 0; c < 3; ++c) {
        unsigned sum = 0;
        for (std::size_t k = 0; k < std::size_t{kFine} * kFine; ++k) {
          sum += colours_[(kFine * row + k / kFine) * wide + kFine * column + k % kFine][c];
        }
        image.rgb.push_back(static_cast<std::uint8_t>((sum + kFine) / (kFine * kFine)));
      }
    }
  }
  return image;
}

bool is_size(double value) { return value >= 0 && std::isfinite(value); }

void require_drawable(const SurfaceSamples& samples) {
  const std::ptrdiff_t sites = samples.sites.cols();
  if (sites == 0 || samples.normals.cols() != sites || std::ssize(samples.radii) != sites) {
    throw InvalidInput(concat("samples: there are ", sites, " sites, ", samples.normals.cols(),
                              " normals and ", samples.radii.size(),
                              " radii; needs one for each, and one site"));
  }
  if (samples.sites.rows() != 3 || samples.normals.rows() != 3) {
    throw InvalidInput(concat("samples: sites have ", samples.sites.rows(), " rows and normals ",
                              samples.normals.rows(), "; both need 3"));
  }
  if (!samples.sites.eigen().allFinite() || !samples.normals.eigen().allFinite()) {
    throw InvalidInput("samples: sites and normals must be finite");
  }
  const auto wrong = std::find_if_not(samples.radii.begin(), samples.radii.end(), is_size);
  if (wrong != samples.radii.end()) {
    throw InvalidInput(concat("samples: radius ", wrong - samples.radii.begin(), " is ", *wrong,
                              "; must be finite and not negative"));
  }
  if (!is_size(samples.area)) {
    throw InvalidInput(
        concat("samples: area is ", samples.area, "; must be finite and not negative"));
  }
}

}  // namespace

ColourImage preview(const TriangleMesh& mesh, const SurfaceSamples& samples, int size, int up) {
  mesh.validate();
  if (size < 16 || size > 4096) {
    throw InvalidInput(concat("size: is ", size, "; must be from 16 to 4096"));
  }
  if (up < 0 || up > 2) throw InvalidInput(concat("up: is ", up, "; must be from 0 to 2"));
  require_drawable(samples);
  const std::ptrdiff_t sites = samples.sites.cols();
  const Triangles triangles(mesh);
  const View view(triangles, size, up);
  Canvas canvas(view.width, view.height);
  for (std::size_t t = 0; t < triangles.count(); ++t) {
    const auto triangle = static_cast<Index>(t);
    if (!triangles.has_area(triangle)) continue;
    const Eigen::Matrix3d corners = triangles.corners(triangle);
    Eigen::Matrix3d at;
    for (Eigen::Index i = 0; i < 3; ++i) at.col(i) = view.place(corners.col(i));
    const Eigen::Vector3d normal = view.direction(area_vector(corners).normalized());
    canvas.draw_triangle(at, normal);
  }
  const double spacing = view.scale() * std::sqrt(samples.area / static_cast<double>(sites));
  for (std::ptrdiff_t s = 0; s < sites; ++s) {
    // The spacing where the sample is; radii are those of disks.
    const double own = view.scale() * samples.radii[static_cast<std::size_t>(s)] * 1.77;
    const double radius = std::max(kDot * std::min(own, spacing), kFine * kLeastDot);
    canvas.draw_disk(view.place(samples.sites.col(s) - triangles.middle()),
                     view.direction(samples.normals.col(s).normalized()), radius);
  }
  return canvas.picture();
}

}  // namespace ccvt
