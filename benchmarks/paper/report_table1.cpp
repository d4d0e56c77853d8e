#include <algorithm>
#include <cmath>
#include <set>

#include "paper/report_parts.h"
#include "support/plot.h"

namespace ccvt::bench {
namespace {

std::vector<std::string> distinct(const Json& runs, const char* key) {
  std::vector<std::string> values;
  for (const Json& run : runs) {
    const auto value = run[key].get<std::string>();
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  return values;
}

const Json* cell_of(const Json& runs, const std::string& row, const std::string& column) {
  for (const Json& run : runs) {
    if (run.at("row") == row && run.at("column") == column) return &run;
  }
  return nullptr;
}

/// The median seconds; NaN where the row was only estimated.
double seconds_of(const Json* cell) {
  if (cell == nullptr || !cell->contains("result")) return NAN;
  return (*cell).at("result").at("seconds").at("median").get<double>();
}

double energy_of(const Json* cell) {
  return (*cell).at("result").at("normalized_energy").at("median").get<double>();
}

std::string cell_text(const Json* cell) {
  if (cell == nullptr) return "";
  if (cell->contains("result")) return seconds_text(seconds_of(cell));
  const Json& estimate = (*cell).at("estimate");
  if (estimate.contains("seconds")) {
    return "N/A, about " + figure(estimate.at("seconds").get<double>(), 2);
  }
  return "N/A, above " + figure(estimate.at("seconds_at_least").get<double>(), 2);
}

/// Seconds of all rows on all sizes, with the paper's beside.
std::string overview(const Json& runs, bool paper_rows) {
  const auto columns = distinct(runs, "column");
  std::vector<std::vector<std::string>> rows(1, {"method", "preset"});
  for (const std::string& column : columns) {
    rows[0].push_back(column);
    if (paper_rows) rows[0].push_back("paper");
  }
  for (const std::string& name : distinct(runs, "row")) {
    const Json* first = nullptr;
    for (const std::string& column : columns) {
      if (first == nullptr) first = cell_of(runs, name, column);
    }
    if ((*first).at("paper_row").get<bool>() != paper_rows) continue;
    rows.push_back({(*first).at("description").get<std::string>(), "`" + name + "`"});
    for (const std::string& column : columns) {
      const Json* const cell = cell_of(runs, name, column);
      rows.back().push_back(cell_text(cell));
      if (!paper_rows) continue;
      rows.back().push_back(cell != nullptr && cell->contains("paper_seconds")
                                ? figure((*cell).at("paper_seconds").get<double>(), 4)
                                : "");
    }
  }
  return markdown_table(rows);
}

/// The default beside the method of 2009, for which the faster of our preset and the program that
/// it stands for counts: a preset that is slower than the program would flatter us.
std::string beside_2009(const Json& runs) {
  std::vector<std::vector<std::string>> rows = {{"size", "preset, s", "the program, FLANN passes",
                                                 "in this run's, s", "the faster, s", "default, s",
                                                 "times faster"}};
  for (const std::string& column : distinct(runs, "column")) {
    const Json* const cell = cell_of(runs, "balzer2009-pruned", column);
    const double own = seconds_of(cell_of(runs, "default", column));
    if (cell == nullptr || !cell->contains("program_passes") || !std::isfinite(own)) continue;
    const double preset = seconds_of(cell);
    const double passes = cell->at("program_passes").get<double>();
    const double program = passes * cell->at("flann_seconds").at("median").get<double>();
    const double faster = preset < program ? preset : program;
    rows.push_back({column, cell_text(cell), figure(passes), seconds_text(program),
                    seconds_text(faster), seconds_text(own), figure(faster / own)});
  }
  if (rows.size() == 1) return "";
  return "### Beside the program of 2009\n\n" + markdown_table(rows) +
         "The program was timed on another machine, in passes of FLANN's nearest-site query over "
         "the same points there; here these count as long as FLANN took in this run.\n\n";
}

/// All that was measured on one size.
std::string details(const Json& runs, const std::string& column) {
  std::vector<std::vector<std::string>> rows = {
      {"preset", "seconds", "spread", "of FLANN pass", "iterations", "pairs examined", "swaps",
       "normalized energy", "peak memory, MB", "capacities", "ended"}};
  for (const std::string& name : distinct(runs, "row")) {
    const Json* const cell = cell_of(runs, name, column);
    if (cell == nullptr || !cell->contains("result")) continue;
    const Json& r = (*cell).at("result");
    const Json& seconds = r.at("seconds");
    rows.push_back({"`" + name + "`", seconds_text(seconds.at("median").get<double>()),
                    seconds_text(seconds.at("least").get<double>()) + " .. " +
                        seconds_text(seconds.at("most").get<double>()),
                    figure(r.at("flann_ratio").at("median").get<double>()),
                    std::to_string(r.at("iterations").get<int>()),
                    std::to_string(r.at("pairs").get<std::int64_t>()),
                    std::to_string(r.at("swaps").get<std::int64_t>()),
                    figure(r.at("normalized_energy").at("median").get<double>(), 4),
                    figure(r.at("peak_memory_bytes").at("median").get<double>() / (1 << 20)),
                    r.at("capacities_exact").get<bool>()
                        ? "exact"
                        : "error " + figure(r.at("capacity_error").get<double>(), 2),
                    r.at("termination").get<std::string>()});
  }
  return "### " + column + "\n\n" + markdown_table(rows);
}

/// What each row gains on the row that it adds an idea to, here and in the paper.
std::string steps(const Json& runs) {
  struct Step {
    const char* idea;
    const char* before;
    const char* after;
  };
  constexpr Step kSteps[] = {
      {"bounding circle + coherent init, 2009", "balzer2009", "balzer2009-pruned"},
      {"median swap, all pairs", "balzer2009", "uncached"},
      {"pair cache, all pairs", "uncached", "section4"},
      {"bounding circle + coherent init", "uncached", "pruned"},
      {"median cut pruning", "pruned", "median-cut"},
      {"point distance pruning", "median-cut", "point-distance"},
      {"multi-level", "point-distance", "multilevel"},
      {"threads without the cache", "multilevel", "parallel"},
      {"pair cache, with threads", "parallel", "fast-ccvt"},
      {"all of ours on all of the paper's, one thread", "multilevel", "default"},
      {"threads, default", "default", "default-parallel"},
  };
  const auto columns = distinct(runs, "column");
  std::vector<std::vector<std::string>> rows(1, {"idea", "from", "to"});
  for (const std::string& column : columns) {
    rows[0].push_back(column);
    rows[0].emplace_back("paper");
  }
  for (const Step& step : kSteps) {
    rows.push_back(
        {step.idea, std::string("`") + step.before + "`", std::string("`") + step.after + "`"});
    for (const std::string& column : columns) {
      const Json* const before = cell_of(runs, step.before, column);
      const Json* const after = cell_of(runs, step.after, column);
      rows.back().push_back(figure(seconds_of(before) / seconds_of(after)));
      const bool in_paper = before != nullptr && after != nullptr &&
                            before->contains("paper_seconds") && after->contains("paper_seconds");
      rows.back().push_back(in_paper ? figure((*before).at("paper_seconds").get<double>() /
                                              (*after).at("paper_seconds").get<double>())
                                     : "");
    }
  }
  return "### What each idea is worth\n\n" + markdown_table(rows) +
         "How many times faster the row with the idea is than the row without; below 1, "
         "slower.\n\n";
}

/// What must hold, told from the figures.
std::string verdicts(const Json& runs) {
  std::string text = "### Checks\n\n";
  for (const std::string& column : distinct(runs, "column")) {
    std::string fastest;
    double least = INFINITY;
    double lowest[2] = {INFINITY, INFINITY};
    double highest[2] = {0, 0};
    bool stable = true;
    bool exact = true;
    int missing = 0;
    for (const std::string& name : distinct(runs, "row")) {
      const Json* const cell = cell_of(runs, name, column);
      if (cell == nullptr) continue;
      if (!cell->contains("result")) {
        ++missing;
        continue;
      }
      const Json& result = (*cell).at("result");
      stable = stable && result.at("termination") == "stable";
      if (name == "lloyd") continue;
      exact = exact && result.at("capacities_exact").get<bool>();
      // Levels change where a run ends, so rows with and without are apart.
      static const std::set<std::string> levelled = {"multilevel", "parallel", "fast-ccvt"};
      const bool flat =
          (*cell).at("paper_row").get<bool>() ? levelled.count(name) == 0 : name == "one-level";
      lowest[flat ? 1 : 0] = std::min(lowest[flat ? 1 : 0], energy_of(cell));
      highest[flat ? 1 : 0] = std::max(highest[flat ? 1 : 0], energy_of(cell));
      if (result.at("threads") == 1 && seconds_of(cell) < least) {
        least = seconds_of(cell);
        fastest = name;
      }
    }
    text += "- " + column + ": " + (stable ? "every row that ran ended stable" : "NOT all stable") +
            ", capacities " + (exact ? "exact" : "NOT exact") + ", " + std::to_string(missing) +
            " rows N/A. Energies differ by " + figure(100 * (highest[0] / lowest[0] - 1), 2) +
            " % among rows with levels, " + figure(100 * (highest[1] / lowest[1] - 1), 2) +
            " % among those without. Fastest on one thread: `" + fastest + "`.\n";
  }
  return text + "\n";
}

std::string plot_of(const Json& runs, const std::filesystem::path& directory) {
  Plot plot;
  plot.title = "Seconds to the end, each method on each size";
  std::vector<std::vector<double>> seconds;
  const auto names = distinct(runs, "row");
  for (const std::string& column : distinct(runs, "column")) {
    Series& series = plot.series.emplace_back(Series{column, {}, {}});
    for (std::size_t k = 0; k < names.size(); ++k) {
      const Json* const cell = cell_of(runs, names[k], column);
      const double value = seconds_of(cell);
      if (!std::isfinite(value)) continue;
      series.x.push_back(value);
      series.y.push_back(static_cast<double>(k));
    }
    seconds.push_back(series.x);
  }
  for (const std::string& name : names) plot.names.push_back(name);
  plot.x = axis_for("seconds", seconds, true);
  plot.y = {"", -0.6, static_cast<double>(names.size()) - 0.4, false};
  const auto lines = static_cast<double>(names.size() + plot.series.size());
  return picture(directory, "table1", draw(plot, 760, 90 + 22 * lines), plot.title);
}

}  // namespace

std::string report_table1(const Json& record, const std::filesystem::path& directory) {
  const Json& runs = record.at("runs");
  std::string text = "## Table 1\n\n" + quick_note(record);
  text +=
      "Seconds, medians; 2D torus, white noise, float, the same points and sites for all rows of a "
      "column, rows in turn. One thread but for `parallel`, `fast-ccvt` and `default-parallel`. "
      "\"paper\": Table 1's own seconds, of a quad-core Core i7 920 of 2010. N/A: rows that would "
      "take longer than the budget of " +
      figure(record.at("scale").at("budget_seconds").get<double>(), 3) +
      " s, with an estimate: \"about\": seconds a pair, times the pairs of a pass, times the "
      "passes "
      "that a sixteenth of the sites needs; \"above\": what it takes on a smaller size, in "
      "proportion "
      "to the points, or the budget itself. `--long` runs them.\n\n";
  text += overview(runs, true);
  text += beside_2009(runs);
  text += "The default, and the default with one idea taken away or added:\n\n";
  text += overview(runs, false);
  text += plot_of(runs, directory) + steps(runs) + verdicts(runs);
  for (const std::string& column : distinct(runs, "column")) text += details(runs, column);
  return text;
}

}  // namespace ccvt::bench
