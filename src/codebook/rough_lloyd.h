#pragma once

#include <optional>
#include <vector>

#include "ccvt/types.h"
#include "exact/cell_bounds.h"
#include "exact/pricing.h"
#include "geometry/metric.h"
#include "parallel/arena.h"

namespace ccvt {

/// Sites, the owners of some points, and what these cost.
struct Seeds {
  std::vector<double> sites;
  std::vector<Index> owners;
  double energy = 0;
};

/// Lloyd iterations, to a rough end.
class RoughLloyd {
 public:
  /// When an iteration gains less than this share, that is the end.
  static constexpr double kRough = 1e-3;

  /// `metric`, the points and the arena must outlive the object.
  RoughLloyd(const Metric& metric, PointsView<float> points, Index sites, const Arena& arena);

  /// Owners need not be the nearest sites. Calls may go on from what others led to, or elsewhere.
  void relax(Seeds& seeds);

 private:
  Prices price(Seeds& seeds);

  const Metric& metric_;
  PointsView<float> points_;
  const Arena& arena_;
  std::vector<double> weights_;
  Pricer<float> pricer_;
  std::optional<CellBounds> kept_;
  std::vector<double> priced_;  ///< the positions that bounds are for
};

}  // namespace ccvt
