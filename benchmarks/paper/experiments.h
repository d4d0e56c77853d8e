#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/options.h"
#include "ccvt/types.h"
#include "support/child.h"

/// The experiments. Each writes one file, NAME.json, into a directory: the machine, the parameters,
/// and the runs; report() makes tables and plots of these.
namespace ccvt::bench {

/// Vectors of one's own for the experiment on search; none: generated ones.
struct SearchFiles {
  std::filesystem::path vectors;
  std::filesystem::path queries;
  Index codewords = 256;
};

struct Scale {
  bool quick = false;    ///< small problems, one repetition: to see that all of it works
  bool is_long = false;  ///< no run is too long
  int repetitions = 3;
  int threads = 0;     ///< most threads to use; 0: one per processor
  double budget = 30;  ///< seconds; rows of Table 1 that would take longer are estimated
  std::string only;    ///< of table1, growth, parallel: one size, such as "1024x256"; empty: all
  SearchFiles search;
};

/// Table 1: every row on the same points, on the torus, white noise.
void table1(const Scale& scale, const std::filesystem::path& directory);
/// Figure 2: how many pairs there are in each batch.
void clusters(const Scale& scale, const std::filesystem::path& directory);
/// Figure 4: spectra by points per site and kind of points.
void quality(const Scale& scale, const std::filesystem::path& directory);
/// Time against sites, points per site, threads and dimensions.
void scaling(const Scale& scale, const std::filesystem::path& directory);
/// Time and order against the points a site, many of them.
void growth(const Scale& scale, const std::filesystem::path& directory);
/// Two threads over one, beside the machine's ceiling, and what more workers would give.
void parallel(const Scale& scale, const std::filesystem::path& directory);

/// Recall of inverted lists against vectors scanned, by codebook.
void search(const Scale& scale, const std::filesystem::path& directory);

/// Turns the files that there are in `directory` into report.md, *.svg and *.png beside them, and
/// returns the tables. Throws IoError when there are none, InvalidInput for broken ones.
std::string report(const std::filesystem::path& directory);

/// What the experiments share.

/// An experiment's file, which save() writes anew after every run: what an interrupted experiment
/// leaves can be reported.
struct Record {
  Record(std::string experiment, const Scale& scale, std::filesystem::path directory);
  void save() const;

  std::string name;
  std::filesystem::path file;
  Json json;
};

struct Case {
  int dimension = 2;
  Index sites = 0;
  Index points_per_site = 0;
};

/// White noise in the unit box, float: the points of a case, the same for all that run on it.
Points<float> white_points(const Case& which, std::uint64_t seed);

/// tessellate(), or lloyd() when `use_lloyd`, of `points` on the torus, in a process of its own:
/// seconds, iterations, pairs, swaps, energies, how it ended, peak memory. After `limit` seconds
/// it is cancelled; 0: never.
Json timed_run(const Points<float>& points, Index sites, const Options& options, bool use_lloyd,
               double limit);

/// {"median", "least", "most", "all"}.
Json repeated(const std::vector<double>& values);

/// One line on stderr: what is being done.
void say(const std::string& text);

std::string size_name(Index sites, Index points_per_site);

}  // namespace ccvt::bench
