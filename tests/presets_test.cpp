#include "ccvt/presets.h"

#include <doctest/doctest.h>

#include <set>
#include <string>

#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/oracle.h"

using namespace ccvt::test;

namespace {

/// How many fields say something else: what the description of a preset may name.
int differing_fields(const ccvt::Options& a, const ccvt::Options& b) {
  return int{a.threads != b.threads} + int{a.initialization != b.initialization} +
         int{a.multilevel != b.multilevel} + int{a.swap != b.swap} +
         int{a.point_pruning != b.point_pruning} +
         int{a.median_cut_pruning != b.median_cut_pruning} + int{a.pairs != b.pairs} +
         int{a.cached_passes != b.cached_passes} + int{a.tile_sites != b.tile_sites} +
         int{a.descent_points != b.descent_points} + int{a.until != b.until};
}

}  // namespace

TEST_SUITE_BEGIN("presets");

TEST_CASE("names are found, and others are refused with all that there are") {
  std::set<std::string> names;
  for (const auto presets : {ccvt::paper_presets(), ccvt::ablation_presets()}) {
    for (const ccvt::Preset& preset : presets) {
      CHECK(names.insert(preset.name).second);
      CHECK(&ccvt::find_preset(preset.name) == &preset);
      CHECK_FALSE(preset.description.empty());
      CHECK_NOTHROW(preset.options.validate());
    }
  }
  CHECK_THROWS_WITH_AS(ccvt::find_preset("fast"), doctest::Contains("fast-ccvt"),
                       ccvt::InvalidInput);
}

TEST_CASE("each row of the table adds one idea to the one before") {
  const auto step = [](const char* before, const char* after) {
    return differing_fields(ccvt::find_preset(before).options, ccvt::find_preset(after).options);
  };
  CHECK(step("balzer2009", "balzer2009-pruned") == 2);  // bounding circle and coherent start
  CHECK(step("balzer2009", "uncached") == 1);
  CHECK(step("section4", "uncached") == 1);
  CHECK(step("uncached", "pruned") == 2);
  CHECK(step("pruned", "median-cut") == 1);
  CHECK(step("median-cut", "point-distance") == 1);
  CHECK(step("point-distance", "multilevel") == 1);
  CHECK(step("multilevel", "parallel") == 1);
  CHECK(step("parallel", "fast-ccvt") == 1);
  CHECK(differing_fields(ccvt::find_preset("fast-ccvt").options, ccvt::Options::fast_ccvt()) == 0);
}

TEST_CASE("each row of the ablation is one idea away from the default") {
  ccvt::Options reference;
  reference.threads = 1;
  for (const ccvt::Preset& preset : ccvt::ablation_presets()) {
    CAPTURE(preset.name);
    CHECK(differing_fields(preset.options, reference) == (preset.name == "default" ? 0 : 1));
  }
}

TEST_CASE("every preset ends stable") {
  const ccvt::Box box = uneven_box(2);
  const auto points = make_points<float>(Layout::random, box, 90 * 16);
  ccvt::Problem<float> problem(points, 90);
  problem.set_domain(ccvt::Domain::periodic(box));
  for (const auto presets : {ccvt::paper_presets(), ccvt::ablation_presets()}) {
    for (const ccvt::Preset& preset : presets) {
      CAPTURE(preset.name);
      const auto result = ccvt::tessellate(problem, preset.options);
      CHECK(result.summary.termination == ccvt::Termination::stable);
      CHECK(faults(problem, result) == "");
    }
  }
}

// 1024 sites x 256, white noise, torus: the 2009 program itself ends at .1712.
TEST_CASE("the 2009 method ends as low as the original program") {
  const auto points =
      ccvt::sample_uniform<float, 2>(ccvt::Box::unit(2), 1024 * 256, 1, ccvt::Distribution::white);
  ccvt::Problem<float> problem(points, 1024);
  problem.set_domain(ccvt::Domain::periodic(ccvt::Box::unit(2)));
  ccvt::Options options = ccvt::find_preset("balzer2009-pruned").options;
  options.seed = 1;
  const auto summary = ccvt::tessellate(problem, options).summary;
  CHECK(summary.termination == ccvt::Termination::stable);
  CHECK(summary.normalized_energy == doctest::Approx(0.1712).epsilon(0.01));
}

TEST_SUITE_END();
