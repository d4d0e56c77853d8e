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
  /// `capacities`: of each site, or about, more than 0. `smooth`: whether to go farther than to the
  /// centroids.
  CodewordSteps(const std::vector<double>& sites, std::size_t dimension,
                std::span<const Index> capacities, bool smooth, const Arena& arena);

  /// Of the cells that were kept last; to be brought up to date before advance().
  [[nodiscard]] std::vector<double>& centroids() { return centroids_; }
  /// Whether the sites are the centroids of these cells.
  [[nodiscard]] bool at_centroids() const { return at_centroids_; }
  /// How much more these cells cost at the sites than at their centroids.
  [[nodiscard]] double excess(const std::vector<double>& sites) const;

  /// Moves the sites on from where these cells, of so many points each, were assigned. False where
  /// the energy has not fallen, by a step beyond the centroids: then the sites are at the centroids
  /// of the cells before, which are the ones to keep. `rests`: the next step is to the centroids.
  bool advance(std::vector<double>& sites, std::vector<Index> sizes, bool rests);

 private:
  using Vector = std::vector<double>;
  [[nodiscard]] double spread() const;
  void step_beyond(Vector& sites);
  bool take_back(Vector& sites);

  std::size_t dimension_;
  Vector capacities_;
  Lbfgs directions_;
  Vector origin_;  ///< of spreads: the mean of the sites
  Vector centroids_;
  std::vector<Index> sizes_;
  bool at_centroids_ = true;
  bool smooth_;
  int failures_ = 0;   ///< steps that were taken back
  int successes_ = 0;  ///< in a row
  // Of the cells that were kept last, and the sites for which they were assigned.
  double spread_ = 0;
  Vector kept_centroids_;
  std::vector<Index> kept_sizes_;
  Vector sites_;
  Vector gradient_;  ///< halved, in the inner product of `directions_`
};

}  // namespace ccvt
