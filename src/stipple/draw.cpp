#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "ccvt/stipple.h"
#include "io/formats.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "number_text.h"

namespace ccvt {

namespace {

constexpr double kLeastDrawnRadius = 3;
constexpr double kMostAutomaticPixels = 1 << 25;
constexpr double kMostPixels = 1 << 28;

double scale_for(double radius, int width, int height) {
  const double area = 1.0 * width * height;
  const double wanted = std::max(1.0, kLeastDrawnRadius / radius);
  return std::min(wanted,
                  std::max(1.0, std::floor(std::sqrt(kMostAutomaticPixels / area) * 64) / 64));
}

/// A side of a drawing, which has a whole number of pixels.
struct Side {
  double length;

  /// Whole pixels in front of a place on it.
  [[nodiscard]] int pixels_to(double place) const {
    return static_cast<int>(std::clamp(place, 0.0, length));
  }
  [[nodiscard]] int pixels() const { return pixels_to(length); }
};

template <class Scalar>
void require_drawable(const Stippling<Scalar>& stippling) {
  if (stippling.width < 1 || stippling.height < 1) {
    throw InvalidInput("stippling: is " + std::to_string(stippling.width) + " x " +
                       std::to_string(stippling.height) + " pixels; needs at least one");
  }
  const double radius = stippling.dot_radius;
  if (!(radius >= 0 && std::isfinite(radius))) {
    throw InvalidInput("stippling: dot_radius is " + concat(radius) +
                       ": it must be finite and not negative");
  }
  const auto dots = stippling.dots.eigen();
  if (dots.cols() > 0 && dots.rows() != 2) {
    throw InvalidInput("stippling: dots have " + std::to_string(dots.rows()) +
                       " coordinates: they must have 2");
  }
  for (Eigen::Index dot = 0; dot < dots.cols(); ++dot) {
    if (dots.col(dot).allFinite()) continue;
    throw InvalidInput("stippling: dot " + std::to_string(dot) + " is not finite");
  }
}

}  // namespace

template <class Scalar>
void write_svg(const std::filesystem::path& path, const Stippling<Scalar>& stippling) {
  if (io::extension_of(path) != ".svg") {
    throw InvalidInput(path.string() + ": unknown extension " + io::quoted(io::extension_of(path)) +
                       "; drawings go into .svg");
  }
  require_drawable(stippling);
  // A hundredth of a radius is below what any device shows.
  const double radius = stippling.dot_radius;
  const double wanted = radius > 0 ? 2 - std::floor(std::log10(radius)) : 3;
  int decimals = 0;
  while (decimals < std::min(wanted, 9.0)) ++decimals;
  const std::string width = std::to_string(stippling.width);
  const std::string height = std::to_string(stippling.height);
  std::string r;
  r += decimal_text(radius, decimals + 1);
  io::OutputFile file(path);
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
      width + "\" height=\"" + height + "\" viewBox=\"0 0 " + width + " " + height +
      "\">\n<rect width=\"" + width + "\" height=\"" + height +
      "\" fill=\"#fff\"/>\n<g fill=\"#000\">\n";
  for (Eigen::Index dot = 0; dot < stippling.dots.cols(); ++dot) {
    text += "<circle cx=\"";
    text += decimal_text(stippling.dots(0, dot), decimals);
    text += "\" cy=\"";
    text += decimal_text(stippling.dots(1, dot), decimals);
    text += "\" r=\"" + r + "\"/>\n";
    if (text.size() > (1U << 16)) {
      file.write(text);
      text.clear();
    }
  }
  file.write(text + "</g>\n</svg>\n");
  file.commit();
}

template <class Scalar>
Image render(const Stippling<Scalar>& stippling, double scale) {
  require_drawable(stippling);
  if (scale == 0) scale = scale_for(stippling.dot_radius, stippling.width, stippling.height);
  const Side width{std::ceil(stippling.width * scale)};
  const Side height{std::ceil(stippling.height * scale)};
  if (!(scale > 0 && width.length * height.length <= kMostPixels)) {
    throw InvalidInput("scale: is " + text(scale) +
                       "; must be positive, or 0 for the usual, and make at most 268435456 pixels");
  }
  Image image{width.pixels(), height.pixels(), {}};
  image.values.assign(static_cast<std::size_t>(width.length * height.length), 1.0F);
  // A pixel at distance d from the centre is covered by clamp(r - d + 1/2). The area under that
  // ramp is pi (r^2 + 1/12) from r = 1/2 on: drawn with r^2 - 1/12, a dot keeps its amount of ink.
  // Smaller ones are as wide as that of r = 1/2, so that none falls between the pixels, but paler.
  constexpr double kLargest = 1e150;  // its square is finite
  const double given = std::min(stippling.dot_radius * scale, kLargest);
  const double square = std::max(given * given, 1.0 / 3);
  const double radius = std::sqrt(square - 1.0 / 12);
  const double strength = given * given / square;
  for (Eigen::Index dot = 0; dot < stippling.dots.cols(); ++dot) {
    const double x = stippling.dots(0, dot) * scale;
    const double y = stippling.dots(1, dot) * scale;
    const double reach = radius + 1;
    const int last_row = height.pixels_to(y + reach);
    const int last_column = width.pixels_to(x + reach);
    for (int row = height.pixels_to(y - reach); row < last_row; ++row) {
      float* const values = image.values.data() + std::ptrdiff_t{row} * image.width;
      for (int column = width.pixels_to(x - reach); column < last_column; ++column) {
        const double distance = std::hypot(column + 0.5 - x, row + 0.5 - y);
        const double covered = strength * std::clamp(radius - distance + 0.5, 0.0, 1.0);
        values[column] *= static_cast<float>(1 - covered);
      }
    }
  }
  return image;
}

template CCVT_EXPORT void write_svg<float>(const std::filesystem::path&, const Stippling<float>&);
template CCVT_EXPORT void write_svg<double>(const std::filesystem::path&, const Stippling<double>&);
template CCVT_EXPORT Image render<float>(const Stippling<float>&, double);
template CCVT_EXPORT Image render<double>(const Stippling<double>&, double);

}  // namespace ccvt
