// What phases do in parallel: all of it against plain loops, for several numbers of threads.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <iterator>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "parallel/loops.h"
#include "random.h"

using ccvt::Arena;
using ccvt::Buffer;
using ccvt::Phase;
using ccvt::Random;
using ccvt::Recorder;

namespace {

constexpr int thread_counts[] = {1, 2, 3, 8};

std::vector<std::uint64_t> numbers(std::size_t count, std::uint64_t below) {
  Random random(count, below);
  std::vector<std::uint64_t> values(count);
  for (auto& value : values) value = random.below(below);
  return values;
}

}  // namespace

TEST_SUITE_BEGIN("parallel");

TEST_CASE("ranges cover every item once, each no longer than the grain") {
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 7, 1000}) {
      for (const std::size_t grain : std::initializer_list<std::size_t>{1, 3, 1000, 5000}) {
        std::vector<std::atomic<int>> times(count);
        std::atomic<bool> fits{true};
        arena.for_ranges(count, grain, [&](std::size_t begin, std::size_t end, int worker) {
          if (begin % grain != 0 || end != std::min(begin + grain, count)) fits = false;
          if (worker < 0 || worker >= arena.threads()) fits = false;
          for (std::size_t k = begin; k < end; ++k) ++times[k];
        });
        CHECK(fits);
        CHECK(std::all_of(times.begin(), times.end(), [](const auto& t) { return t == 1; }));
      }
    }
  }
}

TEST_CASE("no two ranges share a worker, nor do loops inside them") {
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    std::vector<std::atomic<int>> busy(static_cast<std::size_t>(arena.threads()));
    std::atomic<bool> shared{false};
    std::atomic<int> inner{0};
    arena.for_ranges(200, 1, [&](std::size_t, std::size_t, int worker) {
      auto& own = busy[static_cast<std::size_t>(worker)];
      if (own++ != 0) shared = true;
      arena.for_ranges(50, 7, [&](std::size_t begin, std::size_t end, int same) {
        if (same != worker) shared = true;
        inner += static_cast<int>(end - begin);
      });
      --own;
    });
    CHECK_FALSE(shared);
    CHECK(inner == 200 * 50);
  }
}

TEST_CASE("another arena's loop inside a loop is its own") {
  const Arena outer(2);
  std::atomic<int> count{0};
  outer.for_each(8, 1, [&](std::size_t) {
    const Arena arena(2);
    arena.for_each(100, 3, [&](std::size_t) { ++count; });
  });
  CHECK(count == 800);
}

TEST_CASE("an exception ends the loop, and is passed on; the arena goes on working") {
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    const auto fail_at = [&](std::size_t where) {
      arena.for_each(100, 3, [&](std::size_t k) {
        if (k == where) throw std::runtime_error("here");
      });
    };
    CHECK_THROWS_WITH_AS(fail_at(50), "here", std::runtime_error);
    std::atomic<int> count{0};
    arena.for_each(100, 3, [&](std::size_t) { ++count; });
    CHECK(count == 100);
  }
}

TEST_CASE("reduce combines blocks in an order that threads do not change") {
  for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 5, 64, 1000, 4097}) {
    const auto values = numbers(count, 1000);
    double expected = 0;
    for (const int threads : thread_counts) {
      const Arena arena(threads);
      const double sum = ccvt::sum_of(arena, count, 64, [&](std::size_t k) {
        return 1 / (1 + static_cast<double>(values[k]));
      });
      if (threads == 1) expected = sum;
      CHECK(sum == expected);
      double plain = 0;
      for (const auto value : values) plain += 1 / (1 + static_cast<double>(value));
      CHECK(sum == doctest::Approx(plain).epsilon(1e-13));
      const auto largest = ccvt::reduce(
          arena, count, 10, std::uint64_t{0},
          [&](std::size_t begin, std::size_t end) {
            return *std::max_element(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                     values.begin() + static_cast<std::ptrdiff_t>(end));
          },
          [](std::uint64_t a, std::uint64_t b) { return std::max(a, b); });
      CHECK(largest == (count > 0 ? *std::max_element(values.begin(), values.end()) : 0));
    }
  }
}

TEST_CASE("an exclusive scan sums what comes before") {
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 100, 200000}) {
      auto values = numbers(count, 50);
      std::vector<std::uint64_t> expected(count);
      std::exclusive_scan(values.begin(), values.end(), expected.begin(), std::uint64_t{0});
      const std::uint64_t all = std::accumulate(values.begin(), values.end(), std::uint64_t{0});
      CHECK(ccvt::exclusive_scan(arena, std::span(values)) == all);
      CHECK(values == expected);
    }
  }
}

TEST_CASE("collect keeps the order of the items") {
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 100, 30000}) {
      const auto values = numbers(count, 4);
      std::vector<std::size_t> expected;
      for (std::size_t k = 0; k < count; ++k) {
        for (std::uint64_t v = 0; v < values[k]; ++v) expected.push_back(k);
      }
      const Buffer<std::size_t> found = ccvt::collect<std::size_t>(
          arena, count, 64,
          [&](std::size_t begin, std::size_t end, std::vector<std::size_t>& out, int) {
            for (std::size_t k = begin; k < end; ++k) {
              for (std::uint64_t v = 0; v < values[k]; ++v) out.push_back(k);
            }
          });
      CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    }
  }
}

TEST_CASE("collect keeps what blocks of any length append, beyond the pieces that it is kept in") {
  // 2 MB a piece: four blocks fill one nearly, and the fifth is longer than any.
  constexpr std::size_t kLengths[] = {0, 100000, 3, 120000, 700000, 5, 262144, 1};
  constexpr std::size_t kBlocks = std::size(kLengths);
  std::vector<std::uint64_t> expected;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    for (std::size_t k = 0; k < kLengths[b]; ++k) expected.push_back(b << 32U | k);
  }
  for (const int threads : thread_counts) {
    const Buffer<std::uint64_t> found = ccvt::collect<std::uint64_t>(
        Arena(threads), kBlocks, 1,
        [&](std::size_t b, std::size_t, std::vector<std::uint64_t>& out, int) {
          for (std::size_t k = 0; k < kLengths[b]; ++k) out.push_back(b << 32U | k);
        });
    CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
  }
}

TEST_CASE("grouping by key is a stable sort") {
  struct Item {
    std::uint64_t key;
    std::size_t place;
  };
  for (const int threads : thread_counts) {
    const Arena arena(threads);
    for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 500, 100000}) {
      for (const std::size_t keys :
           std::initializer_list<std::size_t>{1, 2, 1000, 1024, 1025, 70000}) {
        CAPTURE(count);
        CAPTURE(keys);
        const auto values = numbers(count, keys);
        const auto groups = ccvt::group_by_key<Item>(
            arena, count, keys,
            [&](std::size_t k) {
              return Item{values[k], k};
            },
            [](const Item& item) { return static_cast<std::size_t>(item.key); });
        REQUIRE(groups.count() == keys);
        std::vector<std::size_t> expected(count);
        std::iota(expected.begin(), expected.end(), std::size_t{0});
        std::stable_sort(expected.begin(), expected.end(),
                         [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
        std::vector<std::size_t> places;
        bool in_its_group = true;
        for (std::size_t g = 0; g < keys; ++g) {
          for (const Item& item : groups[g]) {
            in_its_group = in_its_group && item.key == g;
            places.push_back(item.place);
          }
        }
        CHECK(in_its_group);
        CHECK(places == expected);
      }
    }
  }
}

TEST_CASE("buffers are copied, moved and made smaller without loss of memory") {
  Buffer<int> a(1000);
  std::iota(a.begin(), a.end(), 0);
  Buffer<int> b = a;
  CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
  b[0] = 7;
  CHECK(a[0] == 0);
  const int* const memory = b.data();
  Buffer<int> c = std::move(b);
  CHECK(c.data() == memory);
  c.reset(10);
  c.reset(1000);
  CHECK(c.data() == memory);
  // Around the sizes of large pages, to the last byte.
  constexpr std::size_t kLarge = std::size_t{1} << 21;
  for (const std::size_t size :
       {kLarge / 2 - 1, kLarge / 2, kLarge - 1, kLarge, kLarge + 1, 3 * kLarge / 2, 3 * kLarge}) {
    Buffer<std::uint8_t> bytes(size);
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{7});
    CHECK(std::count(bytes.begin(), bytes.end(), 7) == std::ssize(bytes.span()));
    const std::vector<int> equal = ccvt::vector_in_large_pages(size, 3);
    CHECK(equal == std::vector<int>(size, 3));
  }
  CHECK_THROWS_AS(Buffer<double>(SIZE_MAX / 4), std::bad_alloc);
}

TEST_CASE("the recorder charges phases, and counts the tasks of outer loops") {
  const auto begin = Recorder::Clock::now();
  Recorder recorder;
  std::vector<Recorder::Loop> loops;
  recorder.listen([&](const Recorder::Loop& loop) { loops.push_back(loop); });
  const Arena arena(2, nullptr, &recorder);
  const auto spin = [](double seconds) {
    const auto start = Recorder::Clock::now();
    while (std::chrono::duration<double>(Recorder::Clock::now() - start).count() < seconds) {
    }
  };
  {
    const auto charge = arena.phase(Phase::swap);
    arena.for_each(10, 3, [&](std::size_t) {
      spin(0.001);
      arena.for_each(5, 1, [](std::size_t) {});
    });
    {
      const auto other = arena.phase(Phase::update);
      spin(0.01);
    }
    recorder.rest();
    spin(0.1);
    recorder.go_on();
    arena.for_each(2, 1, [&](std::size_t) { spin(0.001); });
  }
  recorder.rest();
  const double elapsed = std::chrono::duration<double>(Recorder::Clock::now() - begin).count();
  const auto& swap = recorder.shares()[static_cast<std::size_t>(Phase::swap)];
  const auto& update = recorder.shares()[static_cast<std::size_t>(Phase::update)];
  CHECK(swap.loops == 2);
  CHECK(swap.tasks == 4 + 2);
  CHECK(swap.work_seconds >= 0.012);
  CHECK(swap.work_seconds <= 2 * swap.seconds);
  CHECK(update.seconds >= 0.01);
  CHECK(update.loops == 0);
  double charged = 0;
  for (const Recorder::Share& share : recorder.shares()) charged += share.seconds;
  CHECK(charged <= elapsed - 0.1);
  REQUIRE(loops.size() == 2);
  CHECK(loops[0].tasks.size() == 4);
  CHECK(loops[1].begin >= loops[0].end + 0.01);
}

TEST_SUITE_END();
