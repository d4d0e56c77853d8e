#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "kernels/bounds.h"
#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// The steps of sites that moved, and by how much less it may cost points to move there.
///
/// With d = j' - j and c any place, |p - j'|^2 - |p - j|^2 = d . (j + j' - 2c) - 2 (i - c) . d
/// - 2 (p - i) . d, of which the last is at most twice the farthest point's distance times |d|. The
/// products of all sites with all steps are taken in float, whose rounding is bounded.
class SiteSteps {
 public:
  /// From the positions before to these, one after the other.
  SiteSteps(std::span<const double> from, std::span<const double> to, std::size_t dimension,
            const Arena& arena = Arena(1));

  [[nodiscard]] bool none() const { return moved_.empty(); }
  /// Whether bounds of all sites are changed, by growth too: else only those of sites that moved.
  [[nodiscard]] bool all() const { return all_; }
  [[nodiscard]] bool moved(SiteNumber site) const { return moves_[site] != 0; }

  /// A cell: where its site is, how far the farthest point is from there at most, by how much what
  /// points cost there has grown at most, and its bounds for each site.
  struct Cell {
    const double* site;
    double radius;
    double growth;
    double* bound;
  };
  struct Scratch {
    std::vector<float> site;
    std::vector<float> dot;
    std::vector<float> lowest;
    std::vector<double> reach;
    std::vector<double> bound;
  };
  /// Bounds for the positions before become bounds for these. O(cells n D).
  void follow(std::span<const Cell> cells, Scratch& scratch) const;

 private:
  void change_some(const float* dot, std::size_t first, std::size_t count,
                   const kernels::BoundChange& change, double* bound) const;

  std::size_t dimension_;
  std::size_t steps_;  ///< multiplied at a time
  std::vector<std::uint8_t> moves_;
  std::vector<SiteNumber> moved_;  ///< all where most have moved
  bool all_ = false;
  std::vector<double> length_;  ///< of each step, at most
  std::vector<double> shift_;   ///< d . (j + j' - 2c), at least
  std::vector<double> centre_;
  double scale_ = 1;          ///< brings sites into the range of float
  double unscale_ = 1;        ///< takes products back
  std::vector<float> block_;  ///< steps, scaled, some at a time as streams
};

}  // namespace ccvt
