#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace ccvt {

/// One step of SplitMix64's output function [Steele, Lea, Flood 2014]: a bijection that scrambles.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// The library's random generator: xoshiro256++ [Blackman, Vigna 2021]. It and everything drawn
/// from it here is the same, bit for bit, on every machine; std::uniform_*_distribution and
/// std::shuffle are not, so they are not used anywhere.
///
/// Streams are independent and cost eight multiplications to start: give each task, or each chunk
/// of points, its own, and results do not depend on the number of threads. Streams of one seed
/// never start in the same state.
class Random {
 public:
  explicit constexpr Random(std::uint64_t seed, std::uint64_t stream = 0) {
    constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ULL;
    std::uint64_t key = mix_bits(seed + golden);
    const std::uint64_t offset = mix_bits(stream ^ 0xd1b54a32d192ed03ULL);
    for (std::uint64_t& word : state_) {
      key += golden;
      word = mix_bits(mix_bits(key) + offset);
    }
    // The all-zero state is the only one without a successor.
    if ((state_[0] | state_[1] | state_[2] | state_[3]) == 0) state_[0] = golden;
  }

  /// 64 random bits.
  constexpr std::uint64_t next() {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }

  /// In [0, 1): a multiple of 2^-53, each equally likely.
  constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

  /// In 0..n-1, each equally likely, for n >= 1 [Lemire 2019].
  constexpr std::uint64_t below(std::uint64_t n) {
    for (;;) {
      Wide product = next();
      product *= n;
      const auto low = static_cast<std::uint64_t>(product);
      const bool rejected = low < n && low < (0 - n) % n;
      if (!rejected) return static_cast<std::uint64_t>(product >> 64);
    }
  }

  /// The same numbers, for n <= 2^31 - 1.
  constexpr std::int32_t index_below(std::int32_t n) {
    return static_cast<std::int32_t>(below(static_cast<std::uint64_t>(n)));
  }

  /// Calls visit(i) for `count` of 0..total-1, ascending, each set of so many equally likely
  /// [selection sampling: Knuth, TAOCP 2, 3.4.2, algorithm S].
  template <class Visit>
  constexpr void choose(std::int32_t count, std::int32_t total, const Visit& visit) {
    for (std::int32_t i = 0; count > 0; ++i) {
      if (index_below(total - i) >= count) continue;
      visit(i);
      --count;
    }
  }

  /// A random permutation of the values, each equally likely [Fisher, Yates; Durstenfeld 1964].
  template <class T, std::size_t Extent>
  constexpr void shuffle(std::span<T, Extent> values) {
    shuffle(values, [](std::size_t) {});
  }
  /// The same, and calls each(i) before each swap.
  template <class T, std::size_t Extent, class Each>
  constexpr void shuffle(std::span<T, Extent> values, const Each& each) {
    for (std::size_t i = values.size(); i > 1; --i) {
      each(i);
      using std::swap;
      swap(values[i - 1], values[below(i)]);
    }
  }

 private:
  __extension__ typedef unsigned __int128 Wide;  // NOLINT(modernize-use-using)

  std::array<std::uint64_t, 4> state_{};
};

}  // namespace ccvt
