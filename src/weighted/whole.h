#pragma once

#include <cstdint>
#include <vector>

#include "parallel/loops.h"
#include "schedule/schedule.h"
#include "weighted/mass_pair.h"
#include "weighted/near_pairs.h"

namespace ccvt {

/// Moves whole points between cells: first until no error reaches the bound, then to lower the
/// energy.
///
/// Termination. Sites stay where they are during a sweep, so each exchange lowers the sum of mass
/// times squared distance to them by what it gains. That is more than the margins of the two cells,
/// which bound what the sites, as rounded, are worse than the exact centres of mass. So with every
/// sweep that changes a cell the energy around the exact centres falls, and no owners return.
template <class Scalar>
class WholePoints {
 public:
  /// Keeps references. `stop`: the arena's.
  WholePoints(MassCells<Scalar>& cells, const Arena& arena, Stop& stop);

  /// Brings every error below MassCells::error_bound(), and mostly far below; where
  /// the run is to stop, no farther than that. Is not stopped.
  void balance();

  /// What happened in a sweep.
  struct Sweep {
    std::int64_t pairs = 0;
    std::int64_t swaps = 0;
    std::int64_t exchanged = 0;
    Index changed = 0;     ///< cells
    double energy = 0;     ///< afterwards
    bool stopped = false;  ///< between two pairs
  };
  /// One pass over the pairs of which a cell has changed since the last one; sites then move to the
  /// centres of mass. Without changes there is nothing left to do.
  Sweep sweep();

  /// Also of a run that is to stop.
  [[nodiscard]] double energy() const;

 private:
  template <class Visit>
  void for_pairs(const std::vector<Pair>& pairs, const Visit& visit);
  bool even_out(const std::vector<Pair>& pairs);
  [[nodiscard]] bool settled() const;
  [[nodiscard]] bool meet(const Pair& pair) const;
  Index update();

  MassCells<Scalar>& cells_;
  const Arena& arena_;
  Stop& stop_;
  NearPairs near_;
  PerWorker<MassPair<Scalar>> scratch_;
  std::vector<std::uint8_t> changed_;  ///< of each cell: since the last sweep, or in this one
};

extern template class WholePoints<float>;
extern template class WholePoints<double>;

}  // namespace ccvt
