#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/io.h"
#include "ccvt/options.h"
#include "ccvt/publication.h"
#include "ccvt/region.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"
#include "cli/arguments.h"
#include "cli/progress.h"

namespace ccvt::cli {

/// Options for a tessellation of `sites` sites that draws on `progress`, which must outlive them,
/// and ends when the user interrupts it. `defaults`: what holds where the user says nothing.
Options make_options(const CommonArguments& common, const Options& defaults, Index sites,
                     Progress& progress);

/// The box that --box gives: all lower bounds, then all upper bounds. Throws InvalidInput unless it
/// has `dimension` dimensions, those of the points in `file`, of positive extent.
Box make_box(const std::vector<double>& numbers, int dimension, const std::string& file);
/// The box that a file of particles names.
Box box_of(const PointsHeader& particles);

/// Says on standard error, unless `quiet`, which columns are coordinates where others are left out,
/// they are reordered, or their names do not tell. `advice`: what may be done, without which
/// nothing is said of names that do not tell.
void tell_columns(const std::filesystem::path& path, const PointsHeader& header, bool quiet,
                  const std::string& advice = "; --columns says otherwise");

/// Points of `dimension` dimensions: fixed or initial sites, called `what` in messages, of which
/// tell_columns() tells unless `quiet`. Throws InvalidInput where the file's have another number.
template <class Scalar>
Points<Scalar> read_sites(const std::filesystem::path& path, const std::string& what, int dimension,
                          bool quiet) {
  tell_columns(path, inspect_points(path), quiet, "");
  Points<Scalar> sites = read_points<Scalar>(path);
  if (sites.rows() != dimension) {
    throw InvalidInput(path.string() + ": " + what + " have " + std::to_string(sites.rows()) +
                       " coordinates, points have " + std::to_string(dimension) +
                       ": the two must be equal");
  }
  return sites;
}

/// inspect_points(), and tells which columns are coordinates.
PointsHeader inspect_and_tell(const std::filesystem::path& path, const ReadOptions& options,
                              bool quiet);

/// `message` with streams for the files that stand in for them, what is no letter replaced, and a
/// line end: one line, whatever names it holds.
std::string one_line(std::string message);
/// Prints such a line on standard error, behind the program's name.
void tell(const std::string& message);

/// How far the masses of cells are from their capacities.
struct MassFigures {
  std::string method;
  double total = 0;
  double largest_error = 0;   ///< of a cell, in the units of the masses
  Index worst_site = 0;       ///< whose that is
  double error_bound = 0;     ///< infinite: there is none
  double relative_error = 0;  ///< the root mean square, relative to capacities
  Index shared_points = 0;
};

/// What processes that work together have sent each other, and the most memory that one has held.
struct RankFigures {
  int ranks = 1;
  std::int64_t messages = 0;
  std::int64_t sent_bytes = 0;
  std::int64_t gathered_bytes = 0;
  double seconds = 0;  ///< that messages took, with waiting for others: the mean
  std::uint64_t largest_peak_bytes = 0;
};

/// Writes the summary file, if there is to be one.
void write_summary(const CommonArguments& common, const Summary& summary,
                   const std::optional<PutBack>& put_back = {},
                   const std::optional<MassFigures>& masses = {},
                   const std::optional<RankFigures>& ranks = {});

/// Prints warnings on the standard error output, a line each, unless `quiet`.
void warn(bool quiet, const std::vector<std::string>& warnings);

/// Publishes the outputs, prints warnings and the closing line and gives the exit status.
int finish(const CommonArguments& common, Publication& outputs, const Summary& summary,
           const std::optional<PutBack>& put_back = {});

/// Calls `work`; an InvalidInput that it throws gets the name of the file that is to blame.
template <class Work>
decltype(auto) blame(const std::filesystem::path& path, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const InvalidInput& error) {
    throw InvalidInput(path.string() + ": " + error.what());
  }
}

}  // namespace ccvt::cli
