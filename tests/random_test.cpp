#include "random.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <vector>

using ccvt::Random;

namespace {

// Pearson's statistic of counts against equal expectations.
double chi_square(const std::vector<int>& counts) {
  const double total = std::accumulate(counts.begin(), counts.end(), 0.0);
  const double expected = total / static_cast<double>(counts.size());
  double sum = 0;
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

// How far a chi-square statistic lies from its mean, in standard deviations.
double deviations(double statistic, std::size_t bins) {
  const auto freedom = static_cast<double>(bins - 1);
  return (statistic - freedom) / std::sqrt(2 * freedom);
}

}  // namespace

TEST_SUITE_BEGIN("random");

TEST_CASE("splitmix64 gives the published sequence for seed 1234567") {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ULL;
  const std::array<std::uint64_t, 3> expected{6457827717110365317ULL, 3203168211198807973ULL,
                                              9817491932198370423ULL};
  std::uint64_t state = 1234567;
  for (const std::uint64_t value : expected) CHECK(ccvt::mix_bits(state += golden) == value);
}

TEST_CASE("the stream is fixed for all time and at compile time") {
  constexpr std::uint64_t first = [] {
    Random random(1, 2);
    return random.next();
  }();
  Random random(1, 2);
  CHECK(random.next() == first);
  CHECK(first == 10225709209286371490ULL);
}

TEST_CASE("seeds and streams give different numbers") {
  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    for (std::uint64_t stream = 0; stream < 100; ++stream) {
      firsts.insert(Random(seed, stream).next());
    }
  }
  CHECK(firsts.size() == 10000);
}

TEST_CASE("adjacent streams are uncorrelated from the first number on") {
  // Bits of the first numbers of adjacent streams, and of adjacent seeds, differ as coins fall.
  constexpr int pairs = 20000;
  std::int64_t by_stream = 0;
  std::int64_t by_seed = 0;
  for (std::uint64_t i = 0; i < pairs; ++i) {
    by_stream += std::popcount(Random(5, i).next() ^ Random(5, i + 1).next());
    by_seed += std::popcount(Random(i, 5).next() ^ Random(i + 1, 5).next());
  }
  const double sigma = std::sqrt(pairs * 64.0) / 2;
  CHECK(std::abs(static_cast<double>(by_stream) - pairs * 32.0) < 5 * sigma);
  CHECK(std::abs(static_cast<double>(by_seed) - pairs * 32.0) < 5 * sigma);
}

TEST_CASE("uniform is in [0, 1) and even, in each number and in successive pairs") {
  Random random(7);
  std::vector<int> singles(1000);
  std::vector<int> pairs(1024);
  for (int i = 0; i < 200000; ++i) {
    const double u = random.uniform();
    const double v = random.uniform();
    REQUIRE((u >= 0 && u < 1 && v >= 0 && v < 1));
    ++singles[static_cast<std::size_t>(u * 1000)];
    ++pairs[static_cast<std::size_t>(u * 32) * 32 + static_cast<std::size_t>(v * 32)];
  }
  CHECK(std::abs(deviations(chi_square(singles), singles.size())) < 4);
  CHECK(std::abs(deviations(chi_square(pairs), pairs.size())) < 4);
}

TEST_CASE("below stays below and is even") {
  for (const std::uint64_t n : {1ULL, 2ULL, 3ULL, 6ULL, 7ULL, 1000ULL}) {
    Random random(11, n);
    std::vector<int> counts(n);
    for (int i = 0; i < 100000; ++i) {
      const std::uint64_t k = random.below(n);
      REQUIRE(k < n);
      ++counts[k];
    }
    if (n > 1) CHECK(std::abs(deviations(chi_square(counts), n)) < 5);
  }
  // With a bound of 3/4 of 2^64 a plain modulo would put 2/3 of the draws in the lower half.
  constexpr std::uint64_t large = 3ULL << 62;
  Random random(13);
  int lower = 0;
  for (int i = 0; i < 100000; ++i) lower += random.below(large) < large / 2 ? 1 : 0;
  CHECK(std::abs(lower - 50000) < 5 * 159);
}

TEST_CASE("shuffle permutes, and every permutation is equally likely") {
  Random random(17);
  std::vector<int> many(1000);
  std::iota(many.begin(), many.end(), 0);
  random.shuffle(std::span(many));
  CHECK_FALSE(std::is_sorted(many.begin(), many.end()));
  std::sort(many.begin(), many.end());
  for (int i = 0; i < 1000; ++i) CHECK(many[static_cast<std::size_t>(i)] == i);

  std::vector<int> counts(24);
  for (int i = 0; i < 48000; ++i) {
    std::array<int, 4> values{0, 1, 2, 3};
    random.shuffle(std::span(values));
    int rank = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      int smaller = 0;
      for (std::size_t b = a + 1; b < 4; ++b) smaller += values[b] < values[a] ? 1 : 0;
      rank = rank * static_cast<int>(4 - a) + smaller;
    }
    ++counts[static_cast<std::size_t>(rank)];
  }
  CHECK(*std::min_element(counts.begin(), counts.end()) > 0);
  CHECK(std::abs(deviations(chi_square(counts), counts.size())) < 4);
}

TEST_CASE("shuffle of nothing and of one does nothing") {
  Random random(1);
  std::vector<int> none;
  random.shuffle(std::span(none));
  std::vector<int> one{5};
  random.shuffle(std::span(one));
  CHECK(one[0] == 5);
}

TEST_SUITE_END();
