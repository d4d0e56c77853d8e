#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/arena.h"
#include "random.h"

namespace ccvt {

/// Nested random subsets of places 0..m-1, each place as likely as any. They need no memory: the
/// first places in the order of their keys, which are all different.
class NestedSubsets {
 public:
  enum class Order : std::uint8_t {
    /// Each subset of a given size is as likely as any: keys are SplitMix64's numbers [Steele, Lea,
    /// Flood 2014].
    random,
    /// Spread evenly: of each aligned run of 2^k places, a subset of one in 2^k has one [after Owen
    /// 1995]. So points that are numbered along a curve have their density in subsets, too, with
    /// far less noise than if they were drawn one by one.
    even
  };

  /// `sizes` ascend, from 1 to m. O(m) for random ones, O(log m) for even ones.
  NestedSubsets(Order order, Random random, std::size_t places, std::span<const std::size_t> sizes,
                const Arena& arena);

  /// The smallest subset that a place is in; their number where it is in none.
  [[nodiscard]] std::size_t smallest_with(std::size_t place) const {
    const std::uint64_t key = key_of(place);
    std::size_t without = 0;  // counted, as there is nothing to predict
    for (const std::uint64_t last : last_) without += key > last ? 1 : 0;
    return without;
  }

 private:
  [[nodiscard]] std::size_t even_keys_to(std::uint64_t key, std::size_t places) const;
  [[nodiscard]] std::uint64_t even_key_of_rank(std::size_t size, std::size_t places) const;
  struct Window;
  bool search(std::size_t places, std::span<const std::size_t> sizes,
              const std::vector<Window>& windows, const Arena& arena);
  [[nodiscard]] std::uint64_t key_of(std::size_t place) const {
    return even_ ? even_key(place) : mix_bits(start_ + place * 0x9e3779b97f4a7c15ULL);
  }
  /// The bits of the place from the lowest to the highest, which makes a run that is halved k times
  /// be told apart by the k highest of the key; each changed by what the bits below, the runs that
  /// it is in, are [Laine, Karras 2011, with a multiplier of 64 bits].
  [[nodiscard]] std::uint64_t even_key(std::size_t place) const {
    std::uint64_t x = reversed_bits(place) + start_;
    x *= 0x9e3779b97f4a7c15ULL;
    x ^= x << 23U;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x << 31U;
    return x * 0x94d049bb133111ebULL;
  }

  static constexpr std::uint64_t reversed_bits(std::uint64_t x) {
    x = (x >> 1U & 0x5555555555555555ULL) | (x & 0x5555555555555555ULL) << 1U;
    x = (x >> 2U & 0x3333333333333333ULL) | (x & 0x3333333333333333ULL) << 2U;
    x = (x >> 4U & 0x0f0f0f0f0f0f0f0fULL) | (x & 0x0f0f0f0f0f0f0f0fULL) << 4U;
    return __builtin_bswap64(x);
  }

  bool even_;
  std::uint64_t start_;
  std::vector<std::uint64_t> last_;  ///< the greatest key in each subset
};

}  // namespace ccvt
