#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/reaches.h"
#include "relax/site_state.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Whether Screen is worth its cost in this domain.
bool screening_pays(const Metric& metric);

/// Finds the pairs that may gain by an exchange, by blocked products of points with sites: the pair
/// (i, j) can gain only if the reaches of cell i for site j and of cell j for site i sum to more
/// than 0. Rounding is allowed for, so that none is missed.
template <class Scalar>
class Screen {
 public:
  /// Reaches are kept of so many pairs of sites at most.
  explicit Screen(const Metric& metric, std::size_t most_kept = Reaches<Scalar>::kMostPairs)
      : metric_(metric), most_kept_(most_kept) {}

  /// Sorted. Pairs with neither site `touched` are left out: none of their cells has changed and
  /// none of their sites moved since the last call, but for the first. O(m n D), divided among the
  /// ranks that have the tiles; where Reaches are kept, later calls multiply only what may gain by
  /// what the calls before have found, and find the same.
  Buffer<Pair> gaining(const Cells<Scalar>& cells, const SiteState& sites,
                       const std::vector<std::uint8_t>& touched, const Tiling& tiling,
                       const Arena& arena);
  /// Anything may have happened since.
  void forget() {
    if (reaches_) reaches_->forget();
  }

 private:
  Reaches<Scalar>* start_keeping(const Cells<Scalar>& cells, const Tiling& tiling);

  const Metric& metric_;
  std::size_t most_kept_;
  std::optional<Reaches<Scalar>> reaches_;
};

extern template class Screen<float>;
extern template class Screen<double>;

}  // namespace ccvt
