#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "descent/lbfgs.h"
#include "parallel/arena.h"

namespace ccvt {

/// Where codewords go between two exact assignments. To the centroids of their cells is a step of
/// steepest descent [Du, Faber, Gunzburger 1999], and creeps where many vectors make the energy
/// smooth; there quasi-Newton steps go on from what the last ones changed [Liu et al. 2009].
///
/// What has to fall is the energy of the cells at their own centroids: sizes do not change, so that
/// it falls as sum of size * |centroid|^2 rises, of whatever origin.
class CodewordSteps {
 public:
  /// `sites`: of the first assignment. `capacities`: of each, or about, more than 0. `smooth`:
  /// whether to go farther than to the centroids.
  CodewordSteps(const std::vector<double>& sites, std::size_t dimension,
                std::span<const Index> capacities, bool smooth, const Arena& arena);

  /// For which the next assignment is to be made.
  [[nodiscard]] const std::vector<double>& sites() const { return sites_; }
  /// Whether these are the centroids of the cells that were kept last.
  [[nodiscard]] bool at_centroids() const { return at_centroids_; }
  /// How much more these cells cost at the sites than at their centroids.
  [[nodiscard]] double excess() const;
  /// Whether the sites may go beyond centroids, so that advance() needs sizes.
  [[nodiscard]] bool smooth() const { return smooth_; }

  /// Moves the sites on, which are where the cells with these centroids, of so many points each,
  /// were assigned. False where the energy has not fallen, by a step beyond centroids: then the
  /// centroids are made those of the cells before, which are the ones to keep, and the sites are
  /// there. `rests`: the next step is to the centroids.
  bool advance(std::vector<double>& centroids, std::vector<Index> sizes, bool rests);

 private:
  using Vector = std::vector<double>;
  /// Of cells, those that were kept last, and the sites for which they were assigned.
  struct Kept {
    Vector centroids;
    std::vector<Index> sizes;
    double spread = 0;
    Vector sites;
    Vector gradient;  ///< halved, in the inner product of `directions_`
  };
  [[nodiscard]] double spread(const Vector& centroids, const std::vector<Index>& sizes) const;
  bool take_back(Vector& centroids);
  void step_beyond();

  std::size_t dimension_;
  Vector capacities_;
  Lbfgs directions_;
  Vector origin_;  ///< of spreads: the mean of the sites
  Vector sites_;
  bool at_centroids_ = true;
  bool smooth_;
  int failures_ = 0;   ///< steps that were taken back
  int successes_ = 0;  ///< in a row
  Kept kept_;          ///< nothing at first, and no sites after a step was taken back
};

}  // namespace ccvt
