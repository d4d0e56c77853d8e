#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "numbers.h"

namespace ccvt {

/// Keeps chosen points as dense as the cloud is, wherever repulsion would drive them: homes hold
/// equally many points each, so of any few homes as many points are chosen, but for a tolerance.
///
/// Of 8, 16, 32, … homes with consecutive numbers, a block, as many points may be chosen as there
/// are homes, more or fewer by the tolerance: one at least, and so many times the standard
/// deviation of the homes that random points of even density make there, sqrt(k / points a home).
/// Within chance the choice may be more even than the points are; where the density changes within
/// a block by more than chance, it is held more tightly. When each home has one chosen point at
/// first, all blocks stay within their tolerance for good.
class Quotas {
 public:
  /// `reach`: of each home, as Homes has it. Homes with numbers near each other should be so in
  /// space, each 2^k of them from a multiple of 2^k on.
  Quotas(std::span<const double> reach, double points_each);

  /// Whether a chosen point may leave one home for another. O(log n).
  [[nodiscard]] bool allow(SiteNumber from, SiteNumber to) const;
  void enter(SiteNumber home) { add(home, 1); }
  void leave(SiteNumber home) { add(home, -1); }

  /// By how many more than the tolerance the choices in any block miss its homes; 0: all are
  /// within. O(n).
  [[nodiscard]] std::int64_t worst_excess() const;

 private:
  struct Block {
    std::int64_t surplus;  ///< chosen points less homes
    std::int64_t tolerance;
  };
  /// All blocks of one size.
  struct Level {
    std::size_t homes;
    std::vector<Block> blocks;
  };
  void add(SiteNumber home, int chosen);

  std::vector<Level> levels_;  ///< the smallest blocks first
};

}  // namespace ccvt
