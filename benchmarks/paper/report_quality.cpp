// The grid of pictures of Figure 4.

#include <algorithm>
#include <cmath>

#include "ccvt/io.h"
#include "paper/report_parts.h"
#include "support/plot.h"

namespace ccvt::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kTile = 256;  ///< pixels of a picture
constexpr int kGap = 8;
constexpr int kGroup = 2 * kTile + kGap + 24;  ///< of four pictures, and the space to the next

float& pixel(Image& image, int x, int y) {
  return image.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                      static_cast<std::size_t>(x)];
}

/// The spectrum, kTile wide: grey P / (1 + P), so that white noise is mid-grey.
void draw_spectrum(const Json& run, Image& image, int left, int top) {
  const auto grey = run.at("spectrum_grey").get<std::string>();
  const int width = 2 * run.at("half")[0].get<int>() + 1;
  const int height = 2 * run.at("half")[1].get<int>() + 1;
  for (int y = 0; y < kTile; ++y) {
    for (int x = 0; x < kTile; ++x) {
      const int fx = x * width / kTile;
      const int fy = height - 1 - y * height / kTile;
      const auto at = 2 * (static_cast<std::size_t>(fy) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(fx));
      pixel(image, left + x, top + y) =
          static_cast<float>(std::stoi(grey.substr(at, 2), nullptr, 16)) / 255;
    }
  }
}

/// Black dots on white, a fifth of the mean spacing in radius, antialiased.
void draw_points(const Json& run, Image& image, int left, int top) {
  const double scale = 2.0 * kTile;  // a quarter of the unit square is shown
  const double radius = 0.2 / std::sqrt(run.at("sites").get<double>()) * scale;
  for (const Json& point : run.at("first_set")) {
    const double cx = point[0].get<double>() * scale;
    const double cy = kTile - point[1].get<double>() * scale;
    const auto reach = static_cast<int>(radius) + 2;
    for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y) {
      for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x) {
        if (x < 0 || y < 0 || x >= kTile || y >= kTile) continue;
        const double distance = std::hypot(x + 0.5 - cx, y + 0.5 - cy);
        const double ink = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
        float& value = pixel(image, left + x, top + y);
        value = std::min(value, static_cast<float>(1 - ink));
      }
    }
  }
}

/// A radial curve in a frame, over frequencies 0 to 2, with a grey line at `guide`.
void draw_curve(const Json& run, const char* key, double least, double most, double guide,
                Image& image, int left, int top) {
  const auto frequency = run.at("frequency").get<std::vector<double>>();
  const auto value = run[key].get<std::vector<double>>();
  const auto row_of = [&](double v) {
    const double share = std::clamp((v - least) / (most - least), 0.0, 1.0);
    return static_cast<int>(std::lround((kTile - 1) * (1 - share)));
  };
  for (int k = 0; k < kTile; ++k) {
    pixel(image, left + k, top + row_of(guide)) = 0.7F;
    for (const int edge : {0, kTile - 1}) {
      pixel(image, left + k, top + edge) = 0.5F;
      pixel(image, left + edge, top + k) = 0.5F;
    }
  }
  int before = -1;
  std::size_t ring = 0;
  for (int x = 0; x < kTile; ++x) {
    const double f = 2.0 * (x + 0.5) / kTile;
    while (ring + 1 < frequency.size() && frequency[ring + 1] <= f) ++ring;
    if (f < frequency.front() || ring + 1 == frequency.size()) continue;
    const double share = (f - frequency[ring]) / (frequency[ring + 1] - frequency[ring]);
    const int y = row_of(value[ring] + share * (value[ring + 1] - value[ring]));
    // Up or down from where the curve was, two pixels wide.
    const int from = before < 0 ? y : before;
    for (int v = std::min(y, from); v <= std::min(std::max(y, from) + 1, kTile - 1); ++v) {
      pixel(image, left + x, top + v) = 0;
    }
    before = y;
  }
}

Image blank(int width, int height) {
  Image image{width, height, {}};
  image.values.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 1.0F);
  return image;
}

std::string curve_plot(const std::vector<const Json*>& runs, const char* key, const char* label,
                       double least, double most, const std::string& title) {
  Plot plot;
  plot.title = title;
  plot.x = {"frequency / \xE2\x88\x9An", 0, 2, false};
  plot.y = {label, least, most, false};
  plot.marks = false;
  for (const Json* run : runs) {
    plot.series.push_back({(*run).at("points").get<std::string>(),
                           (*run).at("frequency").get<std::vector<double>>(),
                           (*run)[key].get<std::vector<double>>()});
  }
  return draw(plot, 520, 340);
}

}  // namespace

std::string report_quality(const Json& record, const fs::path& directory) {
  const Json& runs = record.at("runs");
  std::vector<std::string> kinds;
  std::vector<int> densities;
  for (const Json& run : runs) {
    const auto kind = run.at("points").get<std::string>();
    const int density = run.at("points_per_site").get<int>();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
    if (std::find(densities.begin(), densities.end(), density) == densities.end()) {
      densities.push_back(density);
    }
  }
  std::vector<std::vector<std::string>> rows = {
      {"points a site", "points", "low-frequency power", "worst anisotropy beyond .875 sqrt(n), dB",
       "normalized energy", "smallest distance / hexagonal", "seconds"}};
  const int columns = static_cast<int>(densities.size());
  constexpr int kMargin = kGroup - 2 * kTile - kGap;
  Image grid = blank(columns * kGroup - kMargin, static_cast<int>(kinds.size()) * kGroup - kMargin);
  const int sets = record.at("parameters").at("sets").get<int>();
  const double noise = -10 * std::log10(sets);
  for (const Json& run : runs) {
    const auto kind = run.at("points").get<std::string>();
    const int density = run.at("points_per_site").get<int>();
    rows.push_back({std::to_string(density), kind,
                    figure(run.at("low_frequency_power").get<double>(), 2),
                    figure(run.at("worst_anisotropy_db").get<double>()),
                    figure(run.at("normalized_energy").at("median").get<double>(), 4),
                    figure(run.at("smallest_distance").at("median").get<double>()),
                    seconds_text(run.at("seconds").at("median").get<double>())});
    const auto column = static_cast<int>(std::find(densities.begin(), densities.end(), density) -
                                         densities.begin());
    const auto row = static_cast<int>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
    const int left = column * kGroup;
    const int top = row * kGroup;
    draw_points(run, grid, left, top);
    draw_spectrum(run, grid, left + kTile + kGap, top);
    draw_curve(run, "power", 0, 3, 1, grid, left, top + kTile + kGap);
    draw_curve(run, "anisotropy_db", -15, 15, noise, grid, left + kTile + kGap, top + kTile + kGap);
  }
  write_png(directory / "quality.png", grid);

  std::string text = "## Quality (Figure 4)\n\n" + quick_note(record);
  text += std::to_string(record.at("parameters").at("sites").get<int>()) +
          " sites on the torus, default options, " + std::to_string(sets) +
          " sets each. Unstructured noise has an anisotropy of " + figure(noise) +
          " dB at that many.\n\n" + markdown_table(rows);
  std::string across;
  for (const int density : densities) {
    across += (across.empty() ? "" : ", ") + std::to_string(density);
  }
  std::string down;
  for (const std::string& kind : kinds) down += (down.empty() ? "" : ", ") + kind;
  text += "![Sites and spectra by points a site and kind of points](quality.png)\n\n";
  text +=
      "Left to right: " + across + " points a site. Top to bottom: " + down +
      ". Of each, a quarter of the first set; the mean spectrum up to 2 sqrt(n), frequency 0 in "
      "the "
      "middle, black no power, mid-grey white noise; the radial mean of the power over the same "
      "frequencies, 0 to 3, with a line at 1; and the anisotropy, -15 to 15 dB, with a line "
      "where "
      "unstructured noise is.\n\n";
  for (const int density : densities) {
    std::vector<const Json*> some;
    for (const Json& run : runs) {
      if (run.at("points_per_site") == density) some.push_back(&run);
    }
    const std::string suffix = std::to_string(density);
    const std::string where = ", " + suffix + " points a site";
    text +=
        picture(directory, "quality_power_" + suffix,
                curve_plot(some, "power", "mean power", 0, 3, "Radial mean of the power" + where),
                "Radial mean of the power" + where);
    text += picture(directory, "quality_anisotropy_" + suffix,
                    curve_plot(some, "anisotropy_db", "dB", -15, 15, "Anisotropy" + where),
                    "Anisotropy" + where);
  }
  return text;
}

}  // namespace ccvt::bench
