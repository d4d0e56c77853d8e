#include <limits>

#include "ccvt/metrics.h"
#include "metrics/sets.h"

namespace ccvt {

Analysis analyze(std::span<const PointSet> sets, const SpectrumOptions& options) {
  const auto stop_if_cancelled = [&] {
    if (options.cancelled && options.cancelled()) throw Cancelled();
  };
  Analysis result;
  result.spectrum = power_spectrum(sets, options);
  result.dimension = result.spectrum.dimension;
  result.points = result.spectrum.points;
  result.sets = result.spectrum.sets;
  stop_if_cancelled();
  result.pairs = pair_correlation(sets, options.threads);
  const double share = 1.0 / result.sets;
  for (const PointSet& set : sets) {
    stop_if_cancelled();
    const auto distances = nearest_distances(set, options.threads);
    result.distances.smallest += share * distances.smallest;
    result.distances.mean += share * distances.mean;
    if (result.dimension == 2) {
      const auto order = bond_order(set, options.threads);
      result.order.psi6_local += share * order.psi6_local;
      result.order.psi6_global += share * order.psi6_global;
      result.order.six_sided += share * order.six_sided;
    }
    stop_if_cancelled();
    result.star_discrepancy += share * star_discrepancy(set, options.threads);
    const auto integration = integration_variance(set, options.seed, options.threads);
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

}  // namespace ccvt
