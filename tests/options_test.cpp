// Every way through the method ends at a tessellation that is as stable, and about as good.
#include "ccvt/options.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Initialization;
using ccvt::Options;
using ccvt::PairSelection;
using ccvt::PointPruning;
using ccvt::Problem;
using ccvt::SwapMethod;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

constexpr SwapMethod swap_methods[] = {SwapMethod::median, SwapMethod::heap, SwapMethod::sort};
constexpr PointPruning prunings[] = {PointPruning::none, PointPruning::distance,
                                     PointPruning::extremes};
constexpr Initialization starts[] = {Initialization::balanced, Initialization::coherent,
                                     Initialization::random};

std::vector<Options> variants() {
  std::vector<Options> all;
  Options o;
  o.max_iterations = 5000;
  o.level_points = 2;
  o.level_factor = 2;
  for (const Initialization start : starts) {
    for (const SwapMethod swap : swap_methods) {
      for (const PointPruning pruning : prunings) {
        for (const bool median_cut : {false, true}) {
          for (const PairSelection pairs : {PairSelection::all, PairSelection::meeting}) {
            for (const int cached : {0, 5}) {
              for (const int tile : {1, 64}) {
                for (const bool multilevel : {false, true}) {
                  o.initialization = start;
                  o.swap = swap;
                  o.point_pruning = pruning;
                  o.median_cut_pruning = median_cut;
                  o.pairs = pairs;
                  o.cached_passes = cached;
                  o.tile_sites = tile;
                  o.multilevel = multilevel;
                  all.push_back(o);
                }
              }
            }
          }
        }
      }
    }
  }
  return all;
}

std::string text(const Options& o) {
  return "initialization " + std::to_string(static_cast<int>(o.initialization)) + " swap " +
         std::to_string(static_cast<int>(o.swap)) + " pruning " +
         std::to_string(static_cast<int>(o.point_pruning)) + " median cut " +
         std::to_string(o.median_cut_pruning) + " pairs " +
         std::to_string(static_cast<int>(o.pairs)) + " cached " + std::to_string(o.cached_passes) +
         " tile " + std::to_string(o.tile_sites) + " multilevel " + std::to_string(o.multilevel);
}

template <class Scalar>
double check_variant(const Problem<Scalar>& problem, const Options& options) {
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(faults(problem, result) == "");
  return result.summary.energy;
}

}  // namespace

TEST_SUITE_BEGIN("options");

TEST_CASE_TEMPLATE("every combination is stable and within a few percent", Scalar, float, double) {
  const Box box = uneven_box(2);
  // More than one tile, and at least two levels.
  const auto points = make_points<Scalar>(Layout::random, box, 72 * 6);
  Problem<Scalar> problem(points, 72);
  if (sizeof(Scalar) == sizeof(double)) problem.set_domain(Domain::periodic(box));
  double lowest = std::numeric_limits<double>::infinity();
  double highest = 0;
  // All of them in one domain, and a fifth, which has every pair of values in it, in the other.
  const auto all = variants();
  for (std::size_t k = 0; k < all.size(); k += sizeof(Scalar) == sizeof(float) ? 1 : 5) {
    CAPTURE(text(all[k]));
    const double energy = check_variant(problem, all[k]);
    lowest = std::min(lowest, energy);
    highest = std::max(highest, energy);
  }
  CHECK(highest < 1.25 * lowest);
}

TEST_CASE("every combination copes with ties, unequal capacities and higher dimensions") {
  const auto capacities = unequal_capacities(12);
  for (const int dimension : {1, 3, 8}) {
    const Box box = uneven_box(dimension);
    for (const Layout layout : {Layout::grid, Layout::duplicates}) {
      const auto points = make_points<float>(layout, box, sum_of(capacities));
      Problem<float> problem(points, 12);
      problem.set_capacities(capacities);
      // One in seven of them, another seventh each time: all together they see every value.
      const auto all = variants();
      const auto first = static_cast<std::size_t>(dimension + (layout == Layout::grid ? 0 : 3));
      for (std::size_t k = first % 7; k < all.size(); k += 7) {
        CAPTURE(dimension);
        CAPTURE(name_of(layout));
        CAPTURE(text(all[k]));
        check_variant(problem, all[k]);
      }
    }
  }
}

TEST_CASE_TEMPLATE("the presets are stable and agree on the energy", Scalar, float, double) {
  for (const int dimension : {2, 3, 9}) {
    CAPTURE(dimension);
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 100 * 16);
    const Problem<Scalar> problem(points, 100);
    const double reference = check_variant(problem, Options{});
    for (const auto& preset : {Options::balzer2009(), Options::section4(), Options::fast_ccvt()}) {
      CHECK(check_variant(problem, preset) == doctest::Approx(reference).epsilon(0.1));
    }
  }
}

// The method of selection and what is left out of it must not change which exchange is made,
// where no two keys are equal.
TEST_CASE_TEMPLATE("swap methods and prunings take the same steps", Scalar, float, double) {
  for (const bool periodic : {false, true}) {
    for (const int dimension : {2, 3}) {
      const Box box = uneven_box(dimension);
      const auto points = make_points<Scalar>(Layout::random, box, 60 * 20);
      Problem<Scalar> problem(points, 60);
      if (periodic) problem.set_domain(Domain::periodic(box));
      const auto reference = ccvt::tessellate(problem, {.swap = SwapMethod::sort,
                                                        .point_pruning = PointPruning::none,
                                                        .median_cut_pruning = false});
      for (const SwapMethod swap : swap_methods) {
        for (const PointPruning pruning : prunings) {
          for (const bool median_cut : {false, true}) {
            const auto result = ccvt::tessellate(
                problem,
                {.swap = swap, .point_pruning = pruning, .median_cut_pruning = median_cut});
            CHECK(result.owners == reference.owners);
            CHECK(result.summary.energy ==
                  doctest::Approx(reference.summary.energy).epsilon(1e-12));
            CHECK(result.summary.iterations == reference.summary.iterations);
          }
        }
      }
    }
  }
}

TEST_CASE("the start is chosen by the dimension, or as asked") {
  const auto start = [](int dimension, const Options& options) {
    const auto points = make_points<float>(Layout::random, Box::unit(dimension), 100);
    return ccvt::tessellate(points, 10, options).summary.initialization_used;
  };
  CHECK(start(8, {}) == "balanced");
  CHECK(start(9, {}) == "coherent");
  CHECK(start(9, {.initialization = Initialization::balanced}) == "balanced");
  CHECK(start(2, {.initialization = Initialization::coherent}) == "coherent");
  CHECK(start(2, {.initialization = Initialization::random}) == "random");
}

TEST_CASE("cached passes are passes over the pairs that swapped, and no more than allowed") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 4000);
  const Problem<float> problem(points, 80);
  for (const int allowed : {0, 1, 5}) {
    const auto result = ccvt::tessellate(
        problem,
        {.initialization = Initialization::random, .multilevel = false, .cached_passes = allowed});
    const auto& log = result.summary.iterations_log;
    REQUIRE(log.size() > 3);
    CHECK(log.front().full);
    CHECK(log.back().full);
    int run = 0;
    int longest = 0;
    for (std::size_t k = 1; k < log.size(); ++k) {
      run = log[k].full ? 0 : run + 1;
      longest = std::max(longest, run);
      if (!log[k].full) CHECK(log[k].pairs <= log[k - 1].swaps);
    }
    CHECK(longest == allowed);
  }
}

TEST_SUITE_END();
