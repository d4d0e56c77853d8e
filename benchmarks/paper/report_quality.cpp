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

/// The spectrum, kTile wide: grey P / (1 + P), so that white noise is mid-grey.
void draw_spectrum(const Json& run, Image& image, int left, int top) {
  const auto power = run["spectrum"].get<std::vector<float>>();
  const int width = 2 * run["half"][0].get<int>() + 1;
  const int height = 2 * run["half"][1].get<int>() + 1;
  for (int y = 0; y < kTile; ++y) {
    for (int x = 0; x < kTile; ++x) {
      const int fx = x * width / kTile;
      const int fy = height - 1 - y * height / kTile;
      const float p = power.at(static_cast<std::size_t>(fy) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(fx));
      image.values[static_cast<std::size_t>(top + y) * static_cast<std::size_t>(image.width) +
                   static_cast<std::size_t>(left + x)] = p / (1 + p);
    }
  }
}

/// Black dots on white, a fifth of the mean spacing in radius, antialiased.
void draw_points(const Json& run, Image& image, int left, int top) {
  const double scale = 2.0 * kTile;  // a quarter of the unit square is shown
  const double radius = 0.2 / std::sqrt(run["sites"].get<double>()) * scale;
  for (const Json& point : run["first_set"]) {
    const double cx = point[0].get<double>() * scale;
    const double cy = kTile - point[1].get<double>() * scale;
    const auto reach = static_cast<int>(radius) + 2;
    for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y) {
      for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x) {
        if (x < 0 || y < 0 || x >= kTile || y >= kTile) continue;
        const double distance = std::hypot(x + 0.5 - cx, y + 0.5 - cy);
        const double ink = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
        float& value =
            image.values[static_cast<std::size_t>(top + y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(left + x)];
        value = std::min(value, static_cast<float>(1 - ink));
      }
    }
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
    plot.series.push_back({(*run)["points"].get<std::string>(),
                           (*run)["frequency"].get<std::vector<double>>(),
                           (*run)[key].get<std::vector<double>>()});
  }
  return draw(plot, 520, 340);
}

}  // namespace

std::string report_quality(const Json& record, const fs::path& directory) {
  const Json& runs = record["runs"];
  std::vector<std::string> kinds;
  std::vector<int> densities;
  for (const Json& run : runs) {
    const auto kind = run["points"].get<std::string>();
    const int density = run["points_per_site"].get<int>();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
    if (std::find(densities.begin(), densities.end(), density) == densities.end()) {
      densities.push_back(density);
    }
  }
  std::vector<std::vector<std::string>> rows = {
      {"points a site", "points", "low-frequency power", "worst anisotropy beyond .875 sqrt(n), dB",
       "normalized energy", "smallest distance / hexagonal", "seconds"}};
  const int columns = static_cast<int>(densities.size());
  Image grid = blank(columns * (kTile + kGap) - kGap,
                     static_cast<int>(kinds.size()) * 2 * (kTile + kGap) - kGap);
  for (const Json& run : runs) {
    const auto kind = run["points"].get<std::string>();
    const int density = run["points_per_site"].get<int>();
    rows.push_back({std::to_string(density), kind,
                    figure(run["low_frequency_power"].get<double>(), 2),
                    figure(run["worst_anisotropy_db"].get<double>()),
                    figure(run["normalized_energy"]["median"].get<double>(), 4),
                    figure(run["smallest_distance"]["median"].get<double>()),
                    seconds_text(run["seconds"]["median"].get<double>())});
    const auto column = static_cast<int>(
        std::find(densities.begin(), densities.end(), density) - densities.begin());
    const auto row =
        static_cast<int>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin());
    draw_points(run, grid, column * (kTile + kGap), 2 * row * (kTile + kGap));
    draw_spectrum(run, grid, column * (kTile + kGap), (2 * row + 1) * (kTile + kGap));
  }
  write_png(directory / "quality.png", grid);

  const int sets = record["parameters"]["sets"].get<int>();
  std::string text = "## Quality (Figure 4)\n\n";
  if (record["scale"]["quick"].get<bool>()) {
    text += "**A quick run: small problems, once each. Not figures to quote.**\n\n";
  }
  text += std::to_string(record["parameters"]["sites"].get<int>()) +
          " sites on the torus, default options, " + std::to_string(sets) +
          " sets each. Unstructured noise has an anisotropy of " +
          figure(-10 * std::log10(sets), 3) + " dB at that many.\n\n" + markdown_table(rows);
  std::string across;
  for (const int density : densities) {
    across += (across.empty() ? "" : ", ") + std::to_string(density);
  }
  std::string down;
  for (const std::string& kind : kinds) down += (down.empty() ? "" : ", ") + kind;
  text += "![Sites and spectra by points a site and kind of points](quality.png)\n\n";
  text += "Left to right: " + across + " points a site. Top to bottom: " + down +
          "; of each a quarter of the first set, and the mean spectrum up to 2 sqrt(n), frequency 0 "
          "in the middle, black no power, mid-grey white noise.\n\n";
  for (const int density : densities) {
    std::vector<const Json*> some;
    for (const Json& run : runs) {
      if (run["points_per_site"] == density) some.push_back(&run);
    }
    const std::string suffix = std::to_string(density);
    const std::string where = ", " + suffix + " points a site";
    text += picture(directory, "quality_power_" + suffix,
                    curve_plot(some, "power", "mean power", 0, 2.5, "Radial mean of the power" + where),
                    "Radial mean of the power" + where);
    text += picture(directory, "quality_anisotropy_" + suffix,
                    curve_plot(some, "anisotropy_db", "dB", -15, 15, "Anisotropy" + where),
                    "Anisotropy" + where);
  }
  return text;
}

}  // namespace ccvt::bench
