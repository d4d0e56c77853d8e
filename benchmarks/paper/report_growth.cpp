// The chapter on many points a site.

#include <algorithm>
#include <cmath>
#include <map>

#include "cli/chart.h"
#include "paper/experiments.h"
#include "paper/report_parts.h"
#include "support/plot.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kWidth = 520;  ///< of a plot
constexpr double kHeight = 340;

using Runs = std::vector<const Json*>;

Runs runs_of(const Json& record, const std::string& table) {
  Runs runs;
  for (const Json& run : record.at("runs")) {
    if (run.at("table") == table) runs.push_back(&run);
  }
  return runs;
}

double median_of(const Json& run, const char* name) {
  return run.contains(name) ? run.at(name).at("median").get<double>() : NAN;
}

double points_per_site(const Json& run) { return run.at("points_per_site").get<double>(); }

std::string size_of(const Json& run) {
  return size_name(run.at("sites").get<Index>(), run.at("points_per_site").get<Index>());
}

/// "3D box", "2D box, capacities 29 to 227285".
std::string problem_of(const Json& run) {
  auto name = run.at("problem").get<std::string>();
  if (!run.contains("capacities")) return name;
  return name + ", capacities " + std::to_string(run.at("capacities").at(0).get<Index>()) + " to " +
         std::to_string(run.at("capacities").at(1).get<Index>());
}

/// Seconds, microseconds a point, iterations, energy, and times the reference, which has none.
void add_figures(const Json& run, std::vector<std::string>& row) {
  const double seconds = median_of(run, "seconds");
  const double points = run.at("sites").get<double>() * points_per_site(run);
  row.insert(
      row.end(),
      {seconds_text(seconds), figure(1e6 * seconds / points),
       std::to_string(run.at("iterations").get<int>()),
       figure(run.at("normalized_energy").get<double>(), 4),
       run.at("reference").get<bool>() ? "reference" : figure(median_of(run, "times_reference"))});
}

/// "at most 1.5 references: reached".
std::string wanted_of(const Json& run) {
  if (!run.contains("wanted")) return "";
  const auto name = run.at("wanted").at("figure").get<std::string>();
  const double most = run.at("wanted").at("most").get<double>();
  const char* const unit = name == "seconds"           ? " s"
                           : name == "times_reference" ? " times the reference"
                                                       : " times a FLANN pass";
  return "at most " + figure(most, 2) + unit +
         (median_of(run, name.c_str()) <= most ? ": reached" : ": not reached");
}

std::string box_table(const Runs& runs) {
  std::vector<std::vector<std::string>> rows = {
      {"points", "sites x points a site", "seconds", "us a point", "iterations",
       "normalized energy", "times the reference", "times a FLANN pass", "wanted"}};
  for (const Json* run : runs) {
    const Index points = run->at("sites").get<Index>() * run->at("points_per_site").get<Index>();
    rows.push_back({std::to_string(points), size_of(*run)});
    add_figures(*run, rows.back());
    const double flann = median_of(*run, "times_flann");
    rows.back().push_back(std::isfinite(flann) ? figure(flann) : "");
    rows.back().push_back(wanted_of(*run));
  }
  return "White noise in the unit square, one thread, until stable. Rows of as many points ran in\n"
         "turn on the same points, after a reference of 256 points a site. A FLANN pass: the\n"
         "nearest site of every point, found once.\n\n" +
         markdown_table(rows);
}

struct Curve {
  std::vector<double> x;
  std::vector<double> y;
};

/// Seconds against the points a site, for each number of sites that has two or more of them.
std::map<Index, Curve> curves_of(const Runs& runs) {
  std::map<Index, Curve> curves;
  for (const Json* run : runs) {
    if (points_per_site(*run) < 1024) continue;
    Curve& curve = curves[run->at("sites").get<Index>()];
    curve.x.push_back(points_per_site(*run));
    curve.y.push_back(median_of(*run, "seconds"));
  }
  std::erase_if(curves, [](const auto& curve) { return curve.second.x.size() < 2; });
  return curves;
}

double steepest(const Curve& curve) {
  double most = -INFINITY;
  for (std::size_t k = 1; k < curve.x.size(); ++k) {
    most = std::max(most,
                    std::log(curve.y[k] / curve.y[k - 1]) / std::log(curve.x[k] / curve.x[k - 1]));
  }
  return most;
}

std::string exponents(const Runs& runs, const fs::path& directory) {
  const auto curves = curves_of(runs);
  if (curves.empty()) return "";
  std::vector<std::vector<std::string>> rows = {
      {"sites", "points a site", "exponent", "largest between neighbours"}};
  Plot plot;
  plot.title = "Seconds until stable";
  std::vector<std::vector<double>> all_x;
  std::vector<std::vector<double>> all_y;
  for (const auto& [sites, curve] : curves) {
    rows.push_back({std::to_string(sites),
                    figure(curve.x.front(), 1) + " to " + figure(curve.x.back(), 1),
                    figure(growth_exponent(curve.x, curve.y)), figure(steepest(curve))});
    plot.series.push_back({std::to_string(sites) + " sites", curve.x, curve.y});
    all_x.push_back(curve.x);
    all_y.push_back(curve.y);
  }
  plot.x = axis_for("points a site", all_x, true);
  plot.y = axis_for("seconds", all_y, true);
  return "Seconds grow as a power of the points a site, from 1024 of them on. Its exponent\n"
         "is that of the best fit; the largest one is between a row and the next, of four times "
         "as\n"
         "many points. 1: as much work for every point.\n\n" +
         markdown_table(rows) +
         picture(directory, "growth", draw(plot, kWidth, kHeight), "Seconds against points a site");
}

std::string others_table(const Runs& runs) {
  std::vector<std::vector<std::string>> rows = {{"problem", "sites x points a site", "threads",
                                                 "until", "seconds", "us a point", "iterations",
                                                 "normalized energy", "times the reference"}};
  for (const Json* run : runs) {
    rows.push_back({problem_of(*run), size_of(*run), std::to_string(run->at("threads").get<int>()),
                    run->at("until").get<std::string>()});
    add_figures(*run, rows.back());
  }
  return "Other problems, each after a reference of the same kind with as many points, 256 a "
         "site.\n"
         "Unequal capacities fall geometrically from the largest until they reach the smallest,\n"
         "which the other sites have. Stippling, of a picture of rings, counts whole: with the\n"
         "points drawn and the radius of the dots.\n\n" +
         markdown_table(rows);
}

std::string threads_table(const Runs& runs) {
  std::vector<std::vector<std::string>> rows = {
      {"sites x points a site", "threads", "seconds", "speed-up"}};
  for (const Json* run : runs) {
    const double seconds = median_of(*run, "seconds");
    rows.push_back({size_of(*run), std::to_string(run->at("threads").get<int>()),
                    seconds_text(seconds), figure(1 / median_of(*run, "times_reference"))});
    const double beside = median_of(*run, "beside");
    if (std::isnan(beside)) continue;
    rows.push_back(
        {size_of(*run), "1, two runs at once", seconds_text(beside), figure(2 * seconds / beside)});
  }
  return "The most points a site, with one thread and two in turn; and two unrelated runs of one\n"
         "thread at the same time, which is what this machine has for two threads.\n\n" +
         markdown_table(rows);
}

/// Without capacities, or of the exact method of codebooks.
std::string iterations_table(const std::string& words, const Runs& runs) {
  std::vector<std::vector<std::string>> rows = {{"problem", "sites x points a site", "seconds",
                                                 "iterations", "ns a point and iteration",
                                                 "normalized energy"}};
  for (const Json* run : runs) {
    const double seconds = median_of(*run, "seconds");
    const double points = run->at("sites").get<double>() * points_per_site(*run);
    const int iterations = run->at("iterations").get<int>();
    rows.push_back({problem_of(*run), size_of(*run), seconds_text(seconds),
                    std::to_string(iterations), figure(1e9 * seconds / points / iterations),
                    figure(run->at("normalized_energy").get<double>(), 4)});
  }
  return words + "\n\n" + markdown_table(rows);
}

/// From one whole number to another, of values of any sign.
Axis whole_axis(const std::string& label, const std::vector<std::vector<double>>& values) {
  double least = INFINITY;
  double most = -INFINITY;
  for (const auto& list : values) {
    for (const double v : list) {
      least = std::min(least, v);
      most = std::max(most, v);
    }
  }
  return {label, std::floor(least), std::floor(most) + 1, false};
}

/// One figure, or its logarithm, against the points a site, a line for each end.
std::string order_plot(const Runs& runs, const char* key, const std::string& label,
                       bool logarithm) {
  Plot plot;
  plot.title = label;
  std::vector<std::vector<double>> all_x;
  std::vector<std::vector<double>> all_y;
  for (const char* until : {"stable", "blue_noise"}) {
    Series series{until, {}, {}};
    for (const Json* run : runs) {
      if (run->at("until") != until) continue;
      series.x.push_back(points_per_site(*run));
      const auto value = run->at(key).get<double>();
      series.y.push_back(logarithm ? std::log10(value) : value);
    }
    all_x.push_back(series.x);
    all_y.push_back(series.y);
    plot.series.push_back(std::move(series));
  }
  plot.x = axis_for("points a site", all_x, true);
  plot.y = logarithm ? whole_axis(label, all_y) : axis_for(label, all_y, false);
  return draw(plot, kWidth, kHeight);
}

/// Four plots in two rows, as one <svg> element.
std::string order_picture(const Runs& runs) {
  const std::string plots[] = {
      order_plot(runs, "peak", "highest power of a ring", false),
      order_plot(runs, "psi6", "local psi6", false),
      order_plot(runs, "smallest_distance", "smallest distance / hexagonal", false),
      order_plot(runs, "low_frequency_power", "log10 of low-frequency power", true)};
  const std::string width = figure(2 * kWidth);
  const std::string height = figure(2 * kHeight);
  std::string svg = "<svg class=\"ccvt\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
                    width + " " + height + "\" width=\"" + width + "\" height=\"" + height +
                    "\" role=\"img\"><title>Order against points a site</title>\n";
  for (int k = 0; k < 4; ++k) {
    const double left = k % 2 == 0 ? 0 : kWidth;
    const double top = k < 2 ? 0 : kHeight;
    svg += "<g transform=\"translate(" + figure(left) + " " + figure(top) + ")\">\n" + plots[k] +
           "</g>\n";
  }
  return svg + "</svg>\n";
}

std::string order(const Json& record, const Runs& runs, const fs::path& directory) {
  std::vector<std::vector<std::string>> rows = {
      {"points a site", "until", "seconds", "normalized energy", "spectral peak", "local psi6",
       "smallest distance", "mean distance", "mean power below .25 sqrt(n)"}};
  for (const Json* run : runs) {
    rows.push_back({figure(points_per_site(*run), 1), run->at("until").get<std::string>(),
                    seconds_text(median_of(*run, "seconds")),
                    figure(median_of(*run, "normalized_energy"), 5),
                    figure(run->at("peak").get<double>()), figure(run->at("psi6").get<double>()),
                    figure(run->at("smallest_distance").get<double>()),
                    figure(run->at("mean_distance").get<double>()),
                    figure(run->at("low_frequency_power").get<double>(), 2)});
  }
  const Json& parameters = record.at("parameters").at("order");
  return "### Order against points a site\n\n" + std::to_string(parameters.at("sites").get<int>()) +
         " sites of white noise on the torus, one thread, sets of points: " +
         std::to_string(parameters.at("sets").get<int>()) +
         ". Until\nstable, sites become a lattice with faults the more points they have; until\n"
         "blue_noise, they are to stay irregular. Below 512 points a site the two\n"
         "are the same. Distances are shares of the hexagonal lattice's; rings of width .125\n"
         "sqrt(n).\n\n" +
         markdown_table(rows) +
         picture(directory, "growth_order", order_picture(runs), "Order against points a site");
}

}  // namespace

std::string report_growth(const Json& record, const fs::path& directory) {
  std::string text = "## Many points a site\n\n" + quick_note(record);
  text +=
      "Seconds and ratios are medians; iterations and energies are of the run whose time is the\n"
      "median, but those of the last table are medians, too.\n\n";
  if (const Runs runs = runs_of(record, "box"); !runs.empty()) {
    text += box_table(runs) + exponents(runs, directory);
  }
  if (const Runs runs = runs_of(record, "others"); !runs.empty()) text += others_table(runs);
  if (const Runs runs = runs_of(record, "threads"); !runs.empty()) text += threads_table(runs);
  if (const Runs runs = runs_of(record, "lloyd"); !runs.empty()) {
    text += iterations_table(
        "Lloyd relaxation, which keeps no capacities, with one thread until stable. With more\n"
        "points a site fewer of them are near a border, and only these are looked at.",
        runs);
  }
  if (const Runs runs = runs_of(record, "codebook"); !runs.empty()) {
    text += iterations_table(
        "Codebooks of equal cells by exact assignments, one thread, default effort, until stable:\n"
        "iterations are those on samples and on all points.",
        runs);
  }
  if (const Runs runs = runs_of(record, "order"); !runs.empty()) {
    text += order(record, runs, directory);
  }
  return text;
}

}  // namespace ccvt::bench
