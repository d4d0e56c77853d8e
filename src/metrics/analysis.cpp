#include <limits>

#include "ccvt/metrics.h"
#include "metrics/sets.h"

namespace ccvt {

namespace {

Analysis analyze_in(const Arena& arena, std::span<const PointSet> sets,
                    const SpectrumOptions& options) {
  Analysis result;
  result.spectrum = power_spectrum(sets, options, arena);
  result.dimension = result.spectrum.dimension;
  result.points = result.spectrum.points;
  result.sets = result.spectrum.sets;
  result.pairs = pair_correlation(sets, arena);
  const double share = 1.0 / result.sets;
  for (const PointSet& set : sets) {
    const auto distances = nearest_distances(set, arena);
    result.distances.smallest += share * distances.smallest;
    result.distances.mean += share * distances.mean;
    if (result.dimension == 2) {
      const auto order = bond_order(set, arena);
      result.order.psi6_local += share * order.psi6_local;
      result.order.psi6_global += share * order.psi6_global;
      result.order.six_sided += share * order.six_sided;
    }
    result.star_discrepancy += share * star_discrepancy(set, arena);
    const auto integration = integration_variance(set, options.seed, arena);
    result.integration.gaussian += share * integration.gaussian;
    result.integration.disk += share * integration.disk;
    result.integration.step += share * integration.step;
  }
  if (result.dimension != 2) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    result.order = {none, none, none};
  }
  return result;
}

}  // namespace

Analysis analyze(std::span<const PointSet> sets, const SpectrumOptions& options) {
  check_options(options);
  Stop stop(options.cancelled);
  try {
    return analyze_in(Arena(options.threads, &stop), sets, options);
  } catch (const Stopped&) {
    throw Cancelled();
  }
}

}  // namespace ccvt
