#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>

#include "ccvt/io.h"
#include "cli/chart.h"
#include "paper/experiments.h"
#include "paper/report_parts.h"
#include "support/machine.h"
#include "support/plot.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

namespace fs = std::filesystem;

Json read_record(const fs::path& file) {
  std::ifstream stream(file);
  Json json = Json::parse(stream, nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("runs")) {
    throw InvalidInput(file.string() + ": is not what ccvt-bench writes");
  }
  return json;
}

struct Sweep {
  std::vector<double> x;
  std::vector<double> seconds;
};

}  // namespace

std::string quick_note(const Json& record) {
  return record.at("scale").value("quick", false)
             ? "**A quick run: small problems, once each. Not figures to quote.**\n\n"
             : "";
}

std::string markdown_table(const std::vector<std::vector<std::string>>& rows) {
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    text += "|";
    for (const std::string& cell : rows[r]) text += " " + cell + " |";
    text += "\n";
    if (r > 0) continue;
    text += "|";
    for (std::size_t c = 0; c < rows[r].size(); ++c) text += "---|";
    text += "\n";
  }
  return text + "\n";
}

std::string figure(double value, int digits) {
  if (!std::isfinite(value)) return "\xE2\x80\x93";  // an en dash
  const double magnitude = value == 0 ? 0 : std::floor(std::log10(std::abs(value)));
  const int decimals = std::clamp(digits - 1 - static_cast<int>(magnitude), 0, 9);
  char buffer[352];
  const auto [end, error] =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  return {buffer, end};
}

std::string seconds_text(double seconds) { return figure(seconds, 3); }

std::string picture(const fs::path& directory, const std::string& name, const std::string& svg,
                    const std::string& caption) {
  write_text(directory / (name + ".svg"), cli::svg_file(svg));
  return "![" + caption + "](" + name + ".svg)\n\n";
}

std::string report_clusters(const Json& record, const fs::path& directory) {
  const Json& runs = record.at("runs");
  const Json& parameters = record.at("parameters");
  std::string text = "## Batches of pairs (Figure 2)\n\n" + quick_note(record);
  std::vector<std::vector<std::string>> rows = {
      {"", "pairs", "batches", "lower bound", "mean", "min", "max", "deviation"},
      {"the paper", "", "", "", "600.96", "274", "668", "38.32"}};
  for (const Json& run : runs) {
    rows.push_back(
        {"pass " + std::to_string(run.at("pass").get<int>()),
         std::to_string(run.at("pairs").get<int>()), std::to_string(run.at("batches").get<int>()),
         std::to_string(run.at("lower_bound").get<int>()), figure(run.at("mean").get<double>(), 5),
         figure(run.at("least").get<double>()), figure(run.at("most").get<double>()),
         figure(run.at("deviation").get<double>())});
  }
  text += markdown_table(rows);
  text += "The pairs that swapped in a full pass from a coherent start, " +
          std::to_string(parameters.at("sites").get<int>()) + " sites x " +
          std::to_string(parameters.at("points_per_site").get<int>()) +
          ", as the cached stage batches them. No schedule has fewer batches than the lower bound, "
          "the highest number of pairs of one site.\n\n";
  const auto sizes = runs.at(0).at("sizes").get<std::vector<double>>();
  const Spread spread = spread_of(sizes);
  const double width = std::max(1.0, std::ceil((spread.most - spread.least + 1) / 24));
  Series bars{"batches of pass 1", {}, {}};
  for (double low = std::floor(spread.least / width) * width; low <= spread.most; low += width) {
    bars.x.push_back(low + width / 2);
    bars.y.push_back(static_cast<double>(std::count_if(
        sizes.begin(), sizes.end(), [&](double s) { return s >= low && s < low + width; })));
  }
  Plot plot;
  plot.title = "Sizes of the batches of one pass";
  plot.x = {"pairs in a batch", bars.x.front() - width, bars.x.back() + width, false};
  plot.y = axis_for("batches", {bars.y}, false);
  plot.series = {bars};
  plot.bars = true;
  plot.legend = false;
  return text + picture(directory, "clusters", draw(plot), "Sizes of the batches of one pass");
}

std::string report_scaling(const Json& record, const fs::path& directory) {
  std::string text = "## Scaling\n\n" + quick_note(record);
  std::map<std::string, Sweep> sweeps;
  std::vector<std::vector<std::string>> rows = {{"sweep", "D", "sites x points a site", "threads",
                                                 "seconds", "spread", "us a point", "iterations",
                                                 "normalized energy", "peak memory, MB"}};
  for (const Json& run : record.at("runs")) {
    const auto name = run.at("sweep").get<std::string>();
    const double sites = run.at("sites").get<double>();
    const double points = sites * run.at("points_per_site").get<double>();
    const Json& seconds = run.at("seconds");
    const double median_seconds = seconds.at("median").get<double>();
    rows.push_back({name, std::to_string(run.at("dimension").get<int>()),
                    size_name(run.at("sites").get<Index>(), run.at("points_per_site").get<Index>()),
                    std::to_string(run.at("threads").get<int>()), seconds_text(median_seconds),
                    seconds_text(seconds.at("least").get<double>()) + " .. " +
                        seconds_text(seconds.at("most").get<double>()),
                    figure(1e6 * median_seconds / points),
                    std::to_string(run.at("iterations").get<int>()),
                    figure(run.at("normalized_energy").get<double>(), 4),
                    figure(run.at("peak_memory_bytes").get<double>() / (1 << 20))});
    Sweep& sweep = sweeps[name];
    sweep.x.push_back(name == "threads"      ? run.at("threads").get<double>()
                      : name == "dimensions" ? run.at("dimension").get<double>()
                                             : points);
    sweep.seconds.push_back(median_seconds);
  }
  text += markdown_table(rows);
  Plot growth;
  growth.title = "Seconds to a stable tessellation";
  std::vector<std::vector<double>> all_x;
  std::vector<std::vector<double>> all_y;
  for (const auto& [name, sweep] : sweeps) {
    if (name == "threads" || name == "dimensions" || sweep.x.size() < 2) continue;
    const double exponent = growth_exponent(sweep.x, sweep.seconds);
    text += "Growth with the points m, sweep of " + name + ": seconds ~ m^" + figure(exponent) +
            ".\n\n";
    growth.series.push_back({name + ": m^" + figure(exponent), sweep.x, sweep.seconds});
    all_x.push_back(sweep.x);
    all_y.push_back(sweep.seconds);
  }
  if (!growth.series.empty()) {
    growth.x = axis_for("points m", all_x, true);
    growth.y = axis_for("seconds", all_y, true);
    text += picture(directory, "scaling", draw(growth, 520, 400), "Seconds against points");
  }
  for (const char* name : {"threads", "dimensions"}) {
    const Sweep& sweep = sweeps[name];
    if (sweep.x.empty()) continue;
    Plot plot;
    plot.title = std::string("Seconds against ") + name;
    plot.x = axis_for(name, {sweep.x}, true);
    plot.y = axis_for("seconds", {sweep.seconds}, std::string(name) == "dimensions");
    plot.series = {{"default", sweep.x, sweep.seconds}};
    plot.legend = false;
    text += picture(directory, std::string("scaling_") + name, draw(plot, 520, 320), plot.title);
  }
  return text;
}

std::string report(const fs::path& directory) {
  using Part = std::string (*)(const Json&, const fs::path&);
  const std::pair<const char*, Part> parts[] = {
      {"table1", report_table1},   {"clusters", report_clusters}, {"quality", report_quality},
      {"scaling", report_scaling}, {"growth", report_growth},     {"parallel", report_parallel},
      {"search", report_search}};
  std::string text;
  std::string last_machine;
  for (const auto& [name, part] : parts) {
    const fs::path file = directory / (std::string(name) + ".json");
    if (!fs::exists(file)) continue;
    const Json record = read_record(file);
    try {
      const std::string where = machine_line(record.at("machine"));
      if (where != last_machine) text += "Measured on: " + where + ".\n\n";
      last_machine = where;
      if (!record.at("runs").empty()) text += part(record, directory);
    } catch (const Json::exception& error) {
      throw InvalidInput(file.string() + ": is not what ccvt-bench writes: " + error.what());
    }
  }
  if (text.empty()) throw IoError(directory.string() + ": holds no measurements of ccvt-bench");
  write_text(directory / "report.md", text);
  return text;
}

}  // namespace ccvt::bench
