#pragma once

#include <vector>

#include "descent/borders.h"
#include "descent/lbfgs.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/level_state.h"
#include "relax/meeting_pairs.h"
#include "relax/relaxer.h"

namespace ccvt {

/// Lowers the energy of a level whose sites own many points. The exchange of points between two
/// cells [Program 3] turns the border between them quickly, but shifts it slowly, the more so the
/// finer the points; and a site that moves to its centroid takes the step of steepest descent. Here
/// sites take steps of a quasi-Newton method [Liu et al. 2009], and for each the weights are found
/// for which the cells of the power diagram are full [Aurenhammer, Hoffmann, Aronov 1998; de Goes
/// et al. 2012]: that is the tessellation of least energy for these sites.
///
/// Only points near borders are looked at. When the sites have moved as far as that allows, points
/// change to their new owners, and the few that single points make too many or too few flow to
/// neighbours, as at the start.
template <class Scalar>
class Descent {
 public:
  Descent(const Metric& metric, const Arena& arena, const PointsView<Scalar>& points,
          std::vector<double>& weights, const LevelState<Scalar>& state, bool finest);

  /// Descends for as long as the points near borders allow, and updates cells and sites. What is
  /// counted as exchanged are points that changed owners.
  PassCount step(LevelState<Scalar>& state);
  /// Whether nothing more is to be gained.
  [[nodiscard]] bool ended() const { return ended_; }

 private:
  enum class Move { made, beyond, failed };
  bool find_borders(const LevelState<Scalar>& state);
  bool fill(PowerDiagram& diagram);
  Move descend();
  Index commit(LevelState<Scalar>& state);

  const Metric& metric_;
  const Arena& arena_;
  const PointsView<Scalar>& points_;
  std::vector<double>& weights_;
  bool finest_;
  bool ended_ = false;
  double share_;
  double fullness_ = 1e-3; int counts_ = 0; double before_ = 0; int small_ = 0;

  MeetingPairs meeting_;
  Buffer<Pair> all_pairs_;
  std::span<const Pair> near_;
  Borders<Scalar> borders_;
  std::vector<double> capacity_;
  std::vector<double> radius_;
  std::vector<double> position_;  ///< of sites, where borders were found
  Lbfgs directions_;
  PowerDiagram at_;  ///< the diagram descended to, full but for single points
  std::vector<double> gradient_;
  double energy_ = 0;
};

extern template class Descent<float>;
extern template class Descent<double>;

}  // namespace ccvt
