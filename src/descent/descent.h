#pragma once

#include <vector>

#include "descent/borders.h"
#include "descent/lbfgs.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "parallel/bytes.h"
#include "relax/level_state.h"
#include "relax/meeting_pairs.h"
#include "relax/relaxer.h"

namespace ccvt {

/// How far a level is lowered.
enum class Depth {
  even,   ///< its cells become full, for the sites where they are, and these move once
  brief,  ///< a step more
  full,   ///< until steps gain next to nothing
};

/// Lowers the energy of a level whose sites own many points. An exchange of points between two
/// cells [Program 3] turns the border between them at once, but shifts it slowly, and the more so
/// the finer the points are; and a site that moves to its centroid takes a step of steepest
/// descent. Here all sites take steps of a quasi-Newton method [Liu et al. 2009], and for each the
/// weights are found with which the cells of the power diagram are full [Aurenhammer, Hoffmann,
/// Aronov 1998; de Goes et al. 2012]: the tessellation of least energy for these sites.
///
/// Only points near borders are looked at. When the sites have moved as far as these allow, points
/// change to their new owners, and those that are single points too many flow to neighbours, as at
/// the start.
template <class Scalar>
class Descent {
 public:
  /// `least_gain`: it ends when steps lower the energy by less than this share of it. `weights`: as
  /// the descent before left them, of a level with fewer points or of this one, or zeros; those of
  /// the last step that was kept, when it ends.
  Descent(const Metric& metric, const Arena& arena, Stop& stop, const OwnPoints<Scalar>& points,
          const LevelState<Scalar>& state, Depth depth, double least_gain,
          std::vector<double>& weights);

  /// Descends for as long as the points near borders allow, and updates cells and sites; the energy
  /// does not rise. When the run is cancelled meanwhile, nothing has changed. What counts as
  /// exchanged are the points that changed owners.
  PassCount step(LevelState<Scalar>& state);
  /// Between two steps: what the next one goes on from, but for the weights. `added`:
  /// added_pairs() of all ranks.
  void save(ByteWriter& out, std::span<const Pair> added) const;
  void load(ByteReader& in, const Tiling& tiling);
  /// That the list of neighbours was extended by, in order: see MeetingPairs.
  [[nodiscard]] std::span<const Pair> added_pairs() const { return meeting_.added(); }

  /// Whether little is left to be gained.
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] Depth depth() const { return depth_; }
  /// Whether nothing was done, because cells have too many neighbours for it, are too large for
  /// their torus, or do not become full.
  [[nodiscard]] bool unsuited() const { return unsuited_; }
  /// An estimate in [0, 1] of how far it has come.
  [[nodiscard]] double progress() const;

 private:
  bool find_neighbours(const LevelState<Scalar>& state);
  bool start(const LevelState<Scalar>& state);
  void look();
  [[nodiscard]] std::vector<double> gradient_here() const;
  bool fill(PowerDiagram& diagram, double fullness);
  bool descend();
  [[nodiscard]] double farthest_centroid() const;
  void commit(LevelState<Scalar>& state, PassCount& result);

  const Metric& metric_;
  const Arena& arena_;
  Stop& stop_;
  const OwnPoints<Scalar> points_;
  std::vector<double>& weights_;
  Depth depth_;
  double least_gain_;  ///< of a step; a share of the energy
  bool ended_ = false;
  bool unsuited_ = false;
  double first_gain_ = 0;  ///< of the first step, and of the last; shares of the energy
  double last_gain_ = 0;
  double share_;         ///< of the radius squared: how near to a border points are looked at
  int small_gains_ = 0;  ///< steps one after the other

  MeetingPairs meeting_;
  Buffer<Pair> near_;
  Borders<Scalar> borders_;
  std::vector<double> capacity_;
  std::vector<double> radius_;
  std::vector<double> position_;     ///< of the sites, where the borders were found
  std::vector<std::uint8_t> fixed_;  ///< of each site: whether it stays there; or empty
  Lbfgs directions_;
  PowerDiagram at_;               ///< what has been descended to
  std::vector<double> gradient_;  ///< there, in the inner product of `directions_`, halved
  double energy_ = 0;
};

extern template class Descent<float>;
extern template class Descent<double>;

}  // namespace ccvt
