#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"
#include "random.h"

namespace ccvt {

/// Nested random subsets of points 0..m-1 that need no memory: the first points of a random order.
/// Points are ordered by their keys, SplitMix64's numbers [Steele, Lea, Flood 2014], which are all
/// different; so each subset of a given size is as likely as any.
class NestedSubsets {
 public:
  /// Points whose members of the subsets are counted together.
  static constexpr std::size_t kBlock = 1 << 16;

  /// `sizes` ascend, from 1 to m. O(m).
  NestedSubsets(std::uint64_t seed, std::uint64_t stream, std::size_t points,
                std::span<const std::size_t> sizes, const Arena& arena);

  /// The points that are in a subset and in no smaller one: see Members::contains().
  class Members {
   public:
    [[nodiscard]] bool contains(std::size_t point) const {
      const std::uint64_t key = all_.key_of(point);
      return key <= last_ && (smallest_ || key > before_);
    }

   private:
    friend NestedSubsets;
    Members(const NestedSubsets& all, std::size_t subset)
        : all_(all),
          smallest_(subset == 0),
          before_(smallest_ ? 0 : all.last_[subset - 1]),
          last_(subset < all.last_.size() ? all.last_[subset] : UINT64_MAX) {}
    const NestedSubsets& all_;
    bool smallest_;
    std::uint64_t before_;
    std::uint64_t last_;
  };
  /// `subset`: their number is that of the points in none.
  [[nodiscard]] Members members(std::size_t subset) const { return {*this, subset}; }
  /// How many points of a block are in a subset.
  [[nodiscard]] std::size_t count(std::size_t block, std::size_t subset) const {
    return count_[block * last_.size() + subset];
  }

 private:
  struct Window;
  bool search(std::size_t points, std::span<const std::size_t> sizes,
              const std::vector<Window>& windows, const Arena& arena);
  [[nodiscard]] std::uint64_t key_of(std::size_t point) const {
    return mix_bits(start_ + point * 0x9e3779b97f4a7c15ULL);
  }

  std::uint64_t start_;
  std::vector<std::uint64_t> last_;  ///< the greatest key in each subset
  std::vector<std::size_t> count_;
};

}  // namespace ccvt
