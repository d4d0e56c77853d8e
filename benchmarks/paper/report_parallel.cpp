// The chapter on threads.

#include "paper/experiments.h"
#include "paper/report_parts.h"

namespace ccvt::bench {
namespace {

std::string case_name(const Json& run) {
  return std::to_string(run.at("dimension").get<int>()) + "D " +
         size_name(run.at("sites").get<Index>(), run.at("points_per_site").get<Index>()) + ", " +
         run.at("name").get<std::string>();
}

double median_of(const Json& run, const char* name) {
  return run.at(name).at("median").get<double>();
}

/// Seconds of each phase, on one thread and on two, and what is serial of them.
std::string phases_of(const Json& run) {
  std::vector<std::vector<std::string>> rows = {{"phase", "one thread, s", "serial, s", "tasks",
                                                 "two threads, s", "in tasks on 16, s",
                                                 "on 64, s"}};
  for (const auto& [name, phase] : run.at("phases").items()) {
    rows.push_back({name, seconds_text(phase.at("seconds").get<double>()),
                    seconds_text(phase.at("serial").get<double>()),
                    std::to_string(phase.at("tasks").get<std::int64_t>()),
                    seconds_text(run.at("phases_on_two").at(name).at("seconds").get<double>()),
                    seconds_text(phase.at("on_16").get<double>()),
                    seconds_text(phase.at("on_64").get<double>())});
  }
  return case_name(run) +
         ", phase by phase, each with its own medians; what is in tasks is without the ends of "
         "loops:\n\n" +
         markdown_table(rows);
}

}  // namespace

std::string report_parallel(const Json& record, const std::filesystem::path&) {
  std::string text =
      "## Threads\n\n" + quick_note(record) +
      "Seconds are medians of whole runs. Ceiling: the speed-up of two runs of one thread, side\n"
      "by side over one after the other, which is what the machine gives just then. Share: the\n"
      "speed-up of two threads, of the ceiling. Predicted: the speed-up with so many workers,\n"
      "when the tasks of one-thread runs, each with its median time, are scheduled on them,\n"
      "serial parts stay as they are, and the end of each loop costs what it does on two\n"
      "threads, times log2 of the workers: where loops are short, more workers only wait\n"
      "longer. Predicted / measured: for two threads.\n\n";
  std::vector<std::vector<std::string>> rows = {{"problem", "one thread, s", "two, s", "speed-up",
                                                 "ceiling", "share", "predicted / measured"}};
  for (const int workers : {4, 8, 16, 32, 64}) {
    rows.front().push_back("predicted on " + std::to_string(workers));
  }
  for (const Json& run : record.at("runs")) {
    const double one = median_of(run, "one");
    const double two = median_of(run, "two");
    rows.push_back({case_name(run), seconds_text(one), seconds_text(two), figure(one / two),
                    figure(run.at("ceiling").get<double>()),
                    figure(run.at("share").get<double>())});
    if (!run.contains("predicted")) {  // timed as a whole
      rows.back().resize(rows.front().size());
      continue;
    }
    rows.back().push_back(figure(run.at("predicted_over_measured").get<double>()));
    for (const char* workers : {"4", "8", "16", "32", "64"}) {
      rows.back().push_back(figure(run.at("predicted").at(workers).get<double>()));
    }
  }
  text += markdown_table(rows);
  for (const Json& run : record.at("runs")) {
    if (run.contains("phases")) text += phases_of(run);
  }
  return text;
}

}  // namespace ccvt::bench
