// The pictures of one set: its spectrum and its points.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cli/analysis_files.h"
#include "cli/chart.h"
#include "median.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

constexpr Index kMostDots = 20000;         ///< with more a window is drawn
constexpr std::size_t kMostDrawn = 40000;  ///< in that
constexpr int kPanelPixels = 400;          ///< a panel of fewer frequencies gets larger ones

/// Shown on each side of 0: a thin box has millions along it.
constexpr int kMostFrequencies = 4096;

/// Power over a plane of frequencies, the first axis fastest.
struct Panel {
  int width = 0;
  int height = 0;
  std::vector<double> power;
};

/// The central plane of axes a and b of a grid.
Panel plane_of(const Spectrum& spectrum, std::size_t a, std::size_t b) {
  std::vector<std::ptrdiff_t> stride(spectrum.half.size() + 1, 1);
  const double* centre = spectrum.power.data();
  for (std::size_t d = 0; d < spectrum.half.size(); ++d) {
    centre += spectrum.half[d] * stride[d];
    stride[d + 1] = stride[d] * (2 * spectrum.half[d] + 1);
  }
  const int half_a = std::min(spectrum.half[a], kMostFrequencies);
  const int half_b = std::min(spectrum.half[b], kMostFrequencies);
  Panel panel{2 * half_a + 1, 2 * half_b + 1, {}};
  for (int y = -half_b; y <= half_b; ++y) {
    for (int x = -half_a; x <= half_a; ++x) {
      panel.power.push_back(centre[x * stride[a] + y * stride[b]]);
    }
  }
  return panel;
}

/// The spectrum on the plane of the first two axes is that of the points' first two coordinates.
Panel projected_plane(const AnalyzedSet& set, int threads) {
  const PointSet& first = set.runs.front();
  const Box& box = first.domain().box();
  const Box face{box.lower.eigen().head(2), box.upper.eigen().head(2)};
  std::vector<PointSet> runs;
  for (const PointSet& run : set.runs) {
    const Points<double> points = run.points().topRows(2);
    // All on one place: the same power everywhere, nothing to see.
    if ((points.colwise() - points.col(0)).isZero(0)) continue;
    runs.emplace_back(
        points, first.domain().is_periodic() ? Domain::periodic(face) : Domain::euclidean(face));
  }
  if (runs.empty()) return {1, 1, {1.0 * first.count()}};
  SpectrumOptions options;
  options.threads = threads;
  // As many frequencies as an image shows and as are visited in seconds.
  const double spacing = runs.front().mean_spacing();
  const double half = std::min(256.0, std::sqrt(0x1p35 / first.count()) / 2);
  options.max_frequency =
      std::min(set.analysis.spectrum.max_frequency * spacing / first.mean_spacing(),
               std::max(1.0, half) * spacing / face.extent().maxCoeff());
  return plane_of(power_spectrum(runs, options), 0, 1);
}

std::vector<Panel> panels_of(const AnalyzedSet& set, int threads) {
  const Spectrum& spectrum = set.analysis.spectrum;
  if (spectrum.dimension == 1 && !spectrum.power.empty()) {
    const int half = std::min(spectrum.half[0], kMostFrequencies);
    const int width = 2 * half + 1;
    Panel strip{width, std::max(1, width / 8), {}};
    const auto begin = spectrum.power.begin() + (spectrum.half[0] - half);
    for (int y = 0; y < strip.height; ++y) {
      strip.power.insert(strip.power.end(), begin, begin + width);
    }
    return {strip};
  }
  if (spectrum.dimension == 1) return {{1, 1, {1.0}}};
  if (spectrum.dimension == 2 && !spectrum.power.empty()) return {plane_of(spectrum, 0, 1)};
  if (spectrum.dimension == 3 && !spectrum.power.empty()) {
    return {plane_of(spectrum, 0, 1), plane_of(spectrum, 0, 2), plane_of(spectrum, 1, 2)};
  }
  return {projected_plane(set, threads)};
}

}  // namespace

Image spectrum_image(const AnalyzedSet& set, int threads) {
  const std::vector<Panel> panels = panels_of(set, threads);
  int height = 0;
  for (const Panel& panel : panels) height = std::max(height, panel.height);
  const int scale = std::max(1, kPanelPixels / std::max(panels.front().width, height));
  constexpr int gap = 8;
  Image image;
  image.height = height * scale;
  for (const Panel& panel : panels) image.width += panel.width * scale + gap;
  image.width -= gap;
  const std::ptrdiff_t width = image.width;
  image.values.assign(static_cast<std::size_t>(width * image.height), 1.0F);
  int left = 0;
  for (const Panel& panel : panels) {
    for (int y = 0; y < panel.height * scale; ++y) {
      // Rows of an image go down, frequencies up.
      const std::ptrdiff_t row = panel.height - 1 - y / scale;
      const double* const powers = panel.power.data() + row * panel.width;
      float* const values = image.values.data() + y * width + left;
      for (int x = 0; x < panel.width * scale; ++x) {
        const double p = powers[x / scale];
        values[x] = static_cast<float>(p / (1 + p));
      }
    }
    left += panel.width * scale + gap;
  }
  return image;
}

std::string spectrum_caption(const AnalyzedSet& set) {
  const std::string grey = "black is no power, mid-grey is white noise";
  const Spectrum& spectrum = set.analysis.spectrum;
  if (spectrum.dimension == 1) return "Power spectrum: " + grey;
  if (spectrum.dimension == 2) return "Power spectrum, frequency 0 in the middle: " + grey;
  if (spectrum.dimension == 3 && !spectrum.power.empty()) {
    return "Power spectrum, central planes xy, xz, yz: " + grey;
  }
  return "Power spectrum, central plane of the first two axes: " + grey;
}

namespace {

/// What of the points is drawn: of their first two coordinates, from the lower corner of the box
/// on; of one coordinate half of a tenth of its extent is the other.
struct Drawn {
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d lower = {0, 0};  ///< of the window
  Eigen::Vector2d extent;          ///< of the box
  double share = 1;                ///< that the window has of it, along each side

  [[nodiscard]] bool shows(const Eigen::Vector2d& point) const {
    const Eigen::Array2d at = (point - lower).array();
    return (at >= 0).all() && (at <= share * extent.array()).all();
  }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(std::count_if(points.begin(), points.end(),
                                                  [&](const auto& point) { return shows(point); }));
  }
  /// A window of that share around a point.
  void narrow(double to, const Eigen::Vector2d& around) {
    share = to;
    lower = (around - share / 2 * extent).cwiseMax(0).cwiseMin((1 - share) * extent);
  }
  /// The point nearest to the middle of all.
  [[nodiscard]] Eigen::Vector2d middle() const {
    Eigen::Vector2d medians;
    std::vector<double> values(points.size());
    for (Eigen::Index d = 0; d < 2; ++d) {
      std::transform(points.begin(), points.end(), values.begin(),
                     [d](const Eigen::Vector2d& point) { return point[d]; });
      medians[d] = median(values);
    }
    const auto squared = [&](const Eigen::Vector2d& at) {
      return (at - medians).cwiseQuotient(extent).squaredNorm();
    };
    return *std::min_element(points.begin(), points.end(),
                             [&](const auto& a, const auto& b) { return squared(a) < squared(b); });
  }
};

/// Of three coordinates those in a slab half way up; a window where there are too many.
Drawn drawn(const PointSet& run) {
  const Box& box = run.domain().box();
  const Eigen::VectorXd sides = box.extent();
  const int dimension = run.dimension();
  Drawn result;
  result.extent = {sides[0], dimension > 1 ? sides[1] : sides[0] / 10};
  for (Eigen::Index p = 0; p < run.points().cols(); ++p) {
    const auto point = run.points().col(p);
    if (dimension == 3) {
      const double middle = (box.lower[2] + box.upper[2]) / 2;
      if (std::abs(point[2] - middle) > run.mean_spacing() / 2) continue;
    }
    result.points.emplace_back(point[0] - box.lower[0],
                               dimension > 1 ? point[1] - box.lower[1] : result.extent[1] / 2);
  }
  if (result.points.size() <= kMostDots) return result;
  // Where clouds are dense, or most points lie in one place, it is to be small.
  constexpr double kNarrower = 0.7;
  constexpr double kNarrowest = 1e-6;
  const Eigen::Vector2d middle = result.middle();
  double share = std::sqrt(kMostDots / static_cast<double>(result.points.size()));
  do {
    result.narrow(share, middle);
    share *= kNarrower;
  } while (result.count() > kMostDrawn && share > kNarrowest);
  std::erase_if(result.points, [&](const auto& point) { return !result.shows(point); });
  result.points.resize(std::min(result.points.size(), kMostDrawn));
  return result;
}

/// `share`: see Drawn.
std::string caption_of(const AnalyzedSet& set, double share) {
  std::string caption = set.runs.size() > 1 ? "Points of the first run" : std::string("The points");
  const int dimension = set.analysis.dimension;
  if (dimension == 3) caption += ": a slab one mean spacing thick, half way up";
  if (dimension > 3) caption += ": the first two of " + std::to_string(dimension) + " coordinates";
  if (share < 1) {
    caption += "; a window " + text(100 * share, 2) + " % as wide as the box, in their middle";
  }
  return caption;
}

}  // namespace

PointsPicture points_picture(const AnalyzedSet& set) {
  const PointSet& run = set.runs.front();
  const Drawn window = drawn(run);
  std::string caption = caption_of(set, window.share);
  const Eigen::Vector2d side = window.share * window.extent;
  const double scale = 460 / side.maxCoeff();
  const double radius = std::clamp(0.2 * run.mean_spacing() * scale, 0.6, 4.0);
  const auto number = [](double value) { return decimal_text(value, 2); };
  std::string svg = R"(<svg class="ccvt" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 )" +
                    number(side[0] * scale + 20) + " " + number(side[1] * scale + 20) +
                    R"(" role="img"><title>)" + escaped(set.name + ": " + caption) + "</title>\n" +
                    R"(<rect class="box" x="10" y="10" width=")" + number(side[0] * scale) +
                    R"(" height=")" + number(side[1] * scale) + "\"/>\n<g class=\"dots\">\n";
  for (const Eigen::Vector2d& point : window.points) {
    const Eigen::Vector2d at = (point - window.lower) * scale;
    svg += R"(<circle cx=")" + number(10 + at[0]) + R"(" cy=")" +
           number(10 + side[1] * scale - at[1]) + R"(" r=")" + number(radius) + "\"/>\n";
  }
  return {svg + "</g>\n</svg>\n", std::move(caption)};
}

}  // namespace ccvt::cli
