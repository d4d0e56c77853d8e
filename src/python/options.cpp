#include "options.h"

#include <pybind11/stl.h>

#include <array>
#include <string>

#include "arrays.h"
#include "ccvt/presets.h"
#include "listener.h"

namespace ccvt::python {

namespace {

template <class Value>
struct Word {
  const char* word;
  Value value;
};

constexpr std::array kUntil = {Word<Until>{"stable", Until::stable},
                               Word<Until>{"blue_noise", Until::blue_noise}};
constexpr std::array kMethod = {Word<CodebookMethod>{"exact", CodebookMethod::exact},
                                Word<CodebookMethod>{"pairwise", CodebookMethod::pairwise},
                                Word<CodebookMethod>{"lloyd", CodebookMethod::lloyd}};
constexpr std::array kSeeding = {Word<Seeding>{"k-means++", Seeding::kmeans_plus_plus},
                                 Word<Seeding>{"random", Seeding::random}};

template <class Value>
void take(const py::dict& given, const char* key, Value& value) {
  if (given.contains(key)) value = given[key].cast<Value>();
}

/// A word of a table; throws InvalidInput, with all words, for any other.
template <class Value, std::size_t Count>
void take(const py::dict& given, const char* key, const std::array<Word<Value>, Count>& table,
          Value& value) {
  if (!given.contains(key)) return;
  const auto word = given[key].cast<std::string>();
  std::string all;
  for (const auto& entry : table) {
    if (word == entry.word) {
      value = entry.value;
      return;
    }
    all += std::string(all.empty() ? "" : ", ") + entry.word;
  }
  throw InvalidInput(std::string(key) + ": is '" + word + "', but must be one of " + all);
}

}  // namespace

Options options_from(const py::dict& given, Options defaults) {
  Options options = std::move(defaults);
  if (given.contains("preset")) options = find_preset(given["preset"].cast<std::string>()).options;
  take(given, "threads", options.threads);
  take(given, "seed", options.seed);
  take(given, "max_iterations", options.max_iterations);
  take(given, "energy_tolerance", options.energy_tolerance);
  take(given, "time_limit", options.time_limit);
  take(given, "until", kUntil, options.until);
  options.validate();
  return options;
}

CodebookOptions codebook_options_from(const py::dict& given) {
  CodebookOptions options;
  take(given, "method", kMethod, options.method);
  take(given, "init", kSeeding, options.seeding);
  take(given, "n_init", options.restarts);
  if (given.contains("effort")) options.effort = given["effort"].cast<int>();
  take(given, "max_iter", options.max_iterations);
  take(given, "tol", options.tolerance);
  take(given, "time_limit", options.time_limit);
  take(given, "threads", options.threads);
  take(given, "seed", options.seed);
  take(given, "gap", options.gap);
  take(given, "train_sample", options.train_sample);
  if (given.contains("capacities")) {
    options.capacities = vector_of(given["capacities"].cast<py::array_t<Index>>());
  }
  options.validate();
  return options;
}

py::dict dict_of(const Summary& summary) {
  py::list log;
  for (const IterationRecord& record : summary.iterations_log) log.append(tuple_of(record));
  py::list phases;
  for (const PhaseRecord& phase : summary.phases) {
    phases.append(
        py::make_tuple(phase.name, phase.seconds, phase.work_seconds, phase.loops, phase.tasks));
  }
  py::dict result;
  result["termination"] = to_string(summary.termination);
  result["dimension"] = summary.dimension;
  result["points"] = summary.points;
  result["sites"] = summary.sites;
  result["threads_used"] = summary.threads_used;
  result["seed"] = summary.seed;
  result["initialization_used"] = summary.initialization_used;
  result["levels"] = summary.levels;
  result["iterations"] = summary.iterations;
  result["pairs"] = summary.pairs;
  result["swaps"] = summary.swaps;
  result["exchanged"] = summary.exchanged;
  result["initial_energy"] = summary.initial_energy;
  result["energy"] = summary.energy;
  result["normalized_energy"] = summary.has_normalized_energy()
                                    ? py::object(py::float_(summary.normalized_energy))
                                    : py::object(py::none());
  result["capacity_error"] = summary.capacity_error;
  result["seconds_total"] = summary.seconds_total;
  result["seconds_initialization"] = summary.seconds_initialization;
  result["seconds_relaxation"] = summary.seconds_relaxation;
  result["phases"] = phases;
  result["log"] = log;
  result["warnings"] = summary.warnings;
  result["brief"] = summary.brief();
  result["full"] = summary.full();
  return result;
}

py::dict dict_of(const CodebookSummary& summary) {
  py::dict result;
  result["method"] = to_string(summary.method);
  result["termination"] = to_string(summary.termination);
  result["iterations"] = summary.iterations;
  result["energy"] = summary.energy;
  result["distortion"] = summary.distortion;
  result["gap"] = summary.gap;
  result["smallest"] = summary.usage.smallest;
  result["largest"] = summary.usage.largest;
  result["imbalance"] = summary.usage.imbalance;
  result["entropy_bits"] = summary.usage.entropy;
  result["threads_used"] = summary.threads_used;
  result["seconds_seeding"] = summary.seconds_seeding;
  result["seconds_total"] = summary.seconds_total;
  result["warnings"] = summary.warnings;
  result["brief"] = summary.brief();
  return result;
}

}  // namespace ccvt::python
