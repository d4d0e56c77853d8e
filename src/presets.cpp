#include "ccvt/presets.h"

#include <functional>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {
namespace {

std::vector<Preset> make_paper_presets() {
  std::vector<Preset> presets;
  const auto add = [&](const char* name, const char* description, Options options) {
    presets.push_back({name, description, std::move(options)});
  };
  Options original = Options::balzer2009();
  original.threads = 1;
  add("balzer2009", "original CCVT", original);
  original.initialization = Initialization::coherent;
  original.pairs = PairSelection::meeting;
  add("balzer2009-pruned", "original CCVT + bounding circle + coherent init", original);

  Options ours = Options::section4();
  ours.threads = 1;
  add("section4", "our method (in Section 4)", ours);
  ours.cached_passes = 0;
  add("uncached", "Section 4 without the pair cache", ours);
  ours.initialization = Initialization::coherent;
  ours.pairs = PairSelection::meeting;
  add("pruned", "+ bounding circle + coherent init", ours);
  ours.median_cut_pruning = true;
  add("median-cut", "+ median cut pruning", ours);
  ours.point_pruning = PointPruning::distance;
  add("point-distance", "+ point dist prune", ours);
  ours.multilevel = true;
  add("multilevel", "+ multi-level", ours);
  ours.threads = 0;
  add("parallel", "+ all threads", ours);
  add("fast-ccvt", "+ 2-stage pair caching", Options::fast_ccvt());
  return presets;
}

std::vector<Preset> make_ablation_presets() {
  std::vector<Preset> presets;
  const auto add = [&](const char* name, const char* description,
                       const std::function<void(Options&)>& change) {
    Options options;
    options.threads = 1;
    change(options);
    presets.push_back({name, description, options});
  };
  add("default", "default", [](Options&) {});
  add("default-parallel", "default, all threads", [](Options& o) { o.threads = 0; });
  add("one-level", "one level instead of many", [](Options& o) { o.multilevel = false; });
  add("pairs-only", "exchanges of pairs alone, however many points a site",
      [](Options& o) { o.descent_points = 0; });
  add("coherent", "coherent instead of balanced start",
      [](Options& o) { o.initialization = Initialization::coherent; });
  add("random", "random instead of balanced start",
      [](Options& o) { o.initialization = Initialization::random; });
  add("single-sites", "single sites instead of tiles", [](Options& o) { o.tile_sites = 1; });
  add("distance-pruning", "point distance pruning instead of extremes",
      [](Options& o) { o.point_pruning = PointPruning::distance; });
  add("all-points", "median cut pruning alone instead of extremes",
      [](Options& o) { o.point_pruning = PointPruning::none; });
  add("heap", "heap instead of median swap", [](Options& o) { o.swap = SwapMethod::heap; });
  add("pair-cache", "with the two-stage pair cache", [](Options& o) { o.cached_passes = 5; });
  add("all-pairs", "all pairs instead of those that meet",
      [](Options& o) { o.pairs = PairSelection::all; });
  return presets;
}

}  // namespace

std::span<const Preset> paper_presets() {
  static const std::vector<Preset> presets = make_paper_presets();
  return presets;
}

std::span<const Preset> ablation_presets() {
  static const std::vector<Preset> presets = make_ablation_presets();
  return presets;
}

const Preset& find_preset(std::string_view name) {
  std::string names;
  for (const auto presets : {paper_presets(), ablation_presets()}) {
    for (const Preset& preset : presets) {
      if (preset.name == name) return preset;
      names += (names.empty() ? "" : ", ") + preset.name;
    }
  }
  throw InvalidInput("preset: '" + std::string(name) + "' is not one of " + names);
}

}  // namespace ccvt
