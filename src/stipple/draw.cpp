#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

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

/// Draws dots on a picture. What is black stays black, and spans of pixels that are known to be are
/// passed over: large dots cover each other.
class Pen {
 public:
  /// `radius`: at which half of a pixel is covered; `strength`: of the ink, up to 1.
  Pen(Image& image, double radius, double strength)
      : image_(image),
        radius_(radius),
        strength_(strength),
        spans_((image.width + kSpan - 1) / kSpan),
        light_(static_cast<std::size_t>(image.height), spans_),
        black_(light_.size() * static_cast<std::size_t>(spans_), 0) {}

  void draw(double x, double y) {
    const Side width{static_cast<double>(image_.width)};
    const Side height{static_cast<double>(image_.height)};
    const double reach = radius_ + 1;
    const double wide = reach * (1 + 1e-12);  // nothing is covered beyond, as distances are rounded
    const int first_column = width.pixels_to(x - reach);
    const int last_column = width.pixels_to(x + reach);
    const int last_row = height.pixels_to(y + reach);
    for (int row = height.pixels_to(y - reach); row < last_row; ++row) {
      if (light_[static_cast<std::size_t>(row)] == 0) continue;
      const double up = row + 0.5 - y;
      const double half = std::sqrt(std::max(wide * wide - up * up, 0.0)) + 1;
      const int last = std::min(last_column, width.pixels_to(x + half));
      for (int begin = std::max(first_column, width.pixels_to(x - half)); begin < last;) {
        const int span = begin / kSpan;
        const int end = std::min(last, (span + 1) * kSpan);
        draw_span(row, span, begin, end, x, up);
        begin = end;
      }
    }
  }

 private:
  static constexpr int kSpan = 64;

  void draw_span(int row, int span, int begin, int end, double x, double up) {
    auto& black = black_[static_cast<std::size_t>(row) * static_cast<std::size_t>(spans_) +
                         static_cast<std::size_t>(span)];
    if (black != 0) return;
    float* const values = image_.values.data() + std::ptrdiff_t{row} * image_.width;
    bool any_light = false;
    for (int column = begin; column < end; ++column) {
      if (values[column] == 0) continue;
      const double distance = std::hypot(column + 0.5 - x, up);
      const double covered = strength_ * std::clamp(radius_ - distance + 0.5, 0.0, 1.0);
      values[column] *= static_cast<float>(1 - covered);
      any_light = any_light || values[column] != 0;
    }
    const int pixels = std::min(kSpan, image_.width - span * kSpan);
    if (any_light || end - begin < pixels) return;
    black = 1;
    --light_[static_cast<std::size_t>(row)];
  }

  Image& image_;
  double radius_;
  double strength_;
  int spans_;                        ///< in a row
  std::vector<int> light_;           ///< of each row, how many spans are not known to be black
  std::vector<std::uint8_t> black_;  ///< of each span of each row
};

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
  Pen pen(image, radius, given * given / square);
  for (Eigen::Index dot = 0; dot < stippling.dots.cols(); ++dot) {
    pen.draw(stippling.dots(0, dot) * scale, stippling.dots(1, dot) * scale);
  }
  return image;
}

template CCVT_EXPORT void write_svg<float>(const std::filesystem::path&, const Stippling<float>&);
template CCVT_EXPORT void write_svg<double>(const std::filesystem::path&, const Stippling<double>&);
template CCVT_EXPORT Image render<float>(const Stippling<float>&, double);
template CCVT_EXPORT Image render<double>(const Stippling<double>&, double);

}  // namespace ccvt
