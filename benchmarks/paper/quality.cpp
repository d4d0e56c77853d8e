// Figure 4: what the kind and the number of points do to the sites.

#include <algorithm>
#include <cmath>
#include <string>

#include "ccvt/metrics.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "paper/experiments.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

struct Kind {
  const char* name;
  Distribution distribution;
};

Json analyzed(const Kind& kind, Index sites, Index points_per_site, int runs, int threads) {
  const Domain torus = Domain::periodic(Box::unit(2));
  std::vector<PointSet> sets;
  std::vector<double> energies;
  std::vector<double> smallest;
  std::vector<double> seconds;
  for (int r = 0; r < runs; ++r) {
    const auto seed = static_cast<std::uint64_t>(r + 1);
    const Points<float> points =
        sample_uniform<float>(Box::unit(2), sites * points_per_site, seed, kind.distribution);
    Problem<float> problem(points, sites);
    problem.set_domain(torus);
    const auto result = tessellate(problem, {.threads = threads, .seed = seed});
    sets.emplace_back(result.sites, torus);
    energies.push_back(result.summary.normalized_energy);
    seconds.push_back(result.summary.seconds_total);
    smallest.push_back(nearest_distances(sets.back(), threads).smallest);
  }
  SpectrumOptions options;
  options.threads = threads;
  const Spectrum spectrum = power_spectrum(sets, options);
  Json json;
  json["points"] = kind.name;
  json["sites"] = sites;
  json["points_per_site"] = points_per_site;
  json["sets"] = runs;
  json["seconds"] = repeated(seconds);
  json["normalized_energy"] = repeated(energies);
  json["smallest_distance"] = repeated(smallest);
  json["low_frequency_power"] = spectrum.low_frequency_power;
  double worst = -1000;
  for (const SpectrumRing& ring : spectrum.rings) {
    json["frequency"].push_back(ring.middle());
    json["power"].push_back(ring.power);
    json["anisotropy_db"].push_back(ring.anisotropy_db);
    if (ring.lower >= 0.875) worst = std::max(worst, ring.anisotropy_db);
  }
  json["worst_anisotropy_db"] = worst;
  json["half"] = spectrum.half;
  // Grey P / (1 + P), two hexadecimal digits a frequency: a picture needs no more.
  std::string grey;
  for (const double power : spectrum.power) {
    const auto level = static_cast<unsigned>(std::lround(255 * power / (1 + power)));
    grey += "0123456789abcdef"[level / 16];
    grey += "0123456789abcdef"[level % 16];
  }
  json["spectrum_grey"] = grey;
  // The first set: the lower left quarter is enough to see.
  json["first_set"] = Json::array();
  for (Index s = 0; s < sites; ++s) {
    const auto site = sets.front().points().col(s);
    if (site.maxCoeff() < 0.5) {
      json["first_set"].push_back({static_cast<float>(site[0]), static_cast<float>(site[1])});
    }
  }
  return json;
}

}  // namespace

void quality(const Scale& scale, const std::filesystem::path& directory) {
  constexpr Kind kinds[] = {{"white noise", Distribution::white},
                            {"square grid", Distribution::square},
                            {"hexagonal grid", Distribution::hexagonal}};
  const Index sites = scale.quick ? 256 : 4096;
  const int runs = scale.quick ? 2 : 10;
  Record record("quality", scale, directory);
  record.json["parameters"] = {{"sites", sites},         {"sets", runs},
                               {"domain", "unit torus"}, {"options", "default"},
                               {"max_frequency", 2},     {"seeds", "1 .. sets"}};
  for (const Index points_per_site : {16, 64, 256, 1024}) {
    if (scale.quick && points_per_site > 64) continue;
    for (const Kind& kind : kinds) {
      Json run =
          run_in_child([&] { return analyzed(kind, sites, points_per_site, runs, scale.threads); });
      say("quality " + std::to_string(points_per_site) + " " + kind.name);
      record.json["runs"].push_back(std::move(run));
      record.save();
    }
  }
}

}  // namespace ccvt::bench
