// The chapter on inverted lists.

#include <algorithm>
#include <cmath>
#include <utility>

#include "paper/experiments.h"
#include "paper/report_parts.h"
#include "support/plot.h"

namespace ccvt::bench {
namespace {

namespace fs = std::filesystem;

/// A codebook, and how queries order its lists.
struct Search {
  std::string name;
  const Json* probes;
};

std::vector<Search> searches_of(const Json& record) {
  std::vector<Search> searches;
  for (const Json& run : record.at("runs")) {
    const auto name = run.at("codebook").get<std::string>();
    const bool both = run.contains("by_weight");
    searches.push_back({both ? name + ", by distance" : name, &run.at("by_distance")});
    if (both) searches.push_back({name + ", by weight", &run.at("by_weight")});
  }
  return searches;
}

std::vector<double> values_of(const Json& probes, const char* key) {
  std::vector<double> values;
  for (const Json& probe : probes) values.push_back(probe.at(key).get<double>());
  return values;
}

/// How many vectors are scanned where a share of `recall` is found: between two measurements as
/// straight lines have it.
double scanned_at(const Json& probes, double recall, const char* key) {
  const std::vector<double> found = values_of(probes, "recall_10");
  const std::vector<double> scanned = values_of(probes, key);
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k] < recall) continue;
    if (k == 0) return scanned[0];
    const double share = (recall - found[k - 1]) / (found[k] - found[k - 1]);
    return scanned[k - 1] + share * (scanned[k] - scanned[k - 1]);
  }
  return scanned.back();
}

std::string codebooks_table(const Json& record) {
  std::vector<std::vector<std::string>> rows = {
      {"codebook", "training, s", "distortion", "shortest list", "longest list", "imbalance"}};
  for (const Json& run : record.at("runs")) {
    rows.push_back({run.at("codebook").get<std::string>(),
                    seconds_text(run.at("seconds").get<double>()),
                    figure(run.at("distortion").get<double>(), 5),
                    std::to_string(run.at("shortest").get<Index>()),
                    std::to_string(run.at("longest").get<Index>()),
                    figure(run.at("imbalance").get<double>(), 4)});
  }
  return markdown_table(rows);
}

std::string costs_table(const std::vector<Search>& searches) {
  std::vector<std::vector<std::string>> rows = {
      {"to find of the 10 nearest", "codebook", "vectors scanned, mean", "of 99 % at most"}};
  for (const double recall : {0.8, 0.9, 0.95, 0.99}) {
    for (const Search& search : searches) {
      rows.push_back({figure(100 * recall, 2) + " %", search.name,
                      figure(scanned_at(*search.probes, recall, "scanned_mean"), 4),
                      figure(scanned_at(*search.probes, recall, "scanned_99"), 4)});
    }
  }
  return markdown_table(rows);
}

std::string probes_table(const std::vector<Search>& searches) {
  std::vector<std::vector<std::string>> rows = {{"codebook", "lists", "recall of 1", "recall of 10",
                                                 "vectors scanned, mean", "of 99 % at most"}};
  for (const Search& search : searches) {
    for (const Json& probe : *search.probes) {
      rows.push_back({search.name, std::to_string(probe.at("lists").get<Index>()),
                      figure(probe.at("recall_1").get<double>(), 4),
                      figure(probe.at("recall_10").get<double>(), 4),
                      figure(probe.at("scanned_mean").get<double>(), 4),
                      figure(probe.at("scanned_99").get<double>(), 4)});
    }
  }
  return markdown_table(rows);
}

std::string plot_of(const std::vector<Search>& searches, const char* key,
                    const std::string& label) {
  Plot plot;
  plot.title = "Recall of the 10 nearest";
  std::vector<std::vector<double>> all_x;
  for (const Search& search : searches) {
    const std::vector<double> x = values_of(*search.probes, key);
    plot.series.push_back({search.name, x, values_of(*search.probes, "recall_10")});
    all_x.push_back(x);
  }
  plot.x = axis_for(label, all_x, true);
  plot.y = {"recall", 0, 1, false};
  return draw(plot, 520, 380);
}

}  // namespace

std::string report_search(const Json& record, const fs::path& directory) {
  const Json& parameters = record.at("parameters");
  const std::vector<Search> searches = searches_of(record);
  return "## Inverted lists\n\n" + quick_note(record) + parameters.at("data").get<std::string>() +
         ", " + std::to_string(parameters.at("codewords").get<Index>()) + " lists, " +
         std::to_string(parameters.at("queries").get<Index>()) +
         " queries that are not among the vectors. A query looks at\n"
         "the lists whose codewords are nearest to it; balanced ones also by what a vector costs\n"
         "there, the squared distance less the codeword's weight. Recall is the share of the\n"
         "nearest vectors, found by looking at all, that are in the lists looked at. Imbalance is\n"
         "what looking at one list costs on average, relative to equal lists, where queries are\n"
         "like the vectors.\n\n" +
         codebooks_table(record) +
         "What it takes to find a share, between the numbers of lists measured as straight lines "
         "have it:\n\n" +
         costs_table(searches) +
         picture(directory, "search_mean",
                 plot_of(searches, "scanned_mean", "vectors scanned, mean"),
                 "Recall against vectors scanned, on average") +
         picture(directory, "search_99",
                 plot_of(searches, "scanned_99", "vectors scanned by 99 % of queries at most"),
                 "Recall against vectors scanned, by 99 % of queries at most") +
         probes_table(searches);
}

}  // namespace ccvt::bench
