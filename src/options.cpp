#include "ccvt/options.h"

#include <string>

#include "ccvt/types.h"
#include "checks.h"
#include "number_text.h"

namespace ccvt {
namespace {

void require(bool valid, const char* field, const std::string& value, const char* rule) {
  if (!valid) throw InvalidInput("Options::" + std::string(field) + " is " + value + ": " + rule);
}

}  // namespace

void Options::validate() const {
  const auto at_least = [](const char* field, int value, int least, const char* rule) {
    require(value >= least, field, std::to_string(value), rule);
  };
  at_least("threads", threads, 0, "it must be 0 (one per processor) or more");
  require(threads <= 4096, "threads", std::to_string(threads), "it must be at most 4096");
  at_least("max_iterations", max_iterations, 0, "it must be 0 or more");
  require(energy_tolerance >= 0 && energy_tolerance < 1, "energy_tolerance", text(energy_tolerance),
          "it must be in [0, 1)");
  require(time_limit >= 0, "time_limit", text(time_limit), "it must be 0 (none) or more seconds");
  require(checkpoint_seconds >= 0, "checkpoint_seconds", text(checkpoint_seconds),
          "it must be 0 (after each iteration) or more seconds");
  const auto one_of = [](const char* field, auto value, auto last) {
    require_enumerator("Options::" + std::string(field), value, last);
  };
  one_of("initialization", initialization, Initialization::random);
  one_of("swap", swap, SwapMethod::sort);
  one_of("point_pruning", point_pruning, PointPruning::extremes);
  one_of("pairs", pairs, PairSelection::meeting);
  one_of("until", until, Until::blue_noise);
  at_least("level_points", level_points, 1, "it must be 1 or more");
  at_least("level_factor", level_factor, 2, "it must be 2 or more");
  at_least("descent_points", descent_points, 0, "it must be 0 (never) or more");
  at_least("cached_passes", cached_passes, 0, "it must be 0 or more");
  at_least("tile_sites", tile_sites, 1, "it must be 1 or more");
}

Options Options::samples() {
  Options options;
  options.until = Until::blue_noise;
  return options;
}

Options Options::balzer2009() {
  Options options;
  options.initialization = Initialization::random;
  options.multilevel = false;
  options.descent_points = 0;
  options.swap = SwapMethod::heap;
  options.point_pruning = PointPruning::none;
  options.median_cut_pruning = false;
  options.pairs = PairSelection::all;
  options.tile_sites = 1;
  return options;
}

Options Options::section4() {
  Options options = balzer2009();
  options.swap = SwapMethod::median;
  options.cached_passes = 5;
  return options;
}

Options Options::fast_ccvt() {
  Options options = section4();
  options.initialization = Initialization::coherent;
  options.pairs = PairSelection::meeting;
  options.point_pruning = PointPruning::distance;
  options.median_cut_pruning = true;
  options.multilevel = true;
  return options;
}

}  // namespace ccvt
