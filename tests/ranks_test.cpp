// Problems of several ranks, which are threads here; tests/mpi has the same with processes, and
// more.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/lloyd.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "random.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"
#include "support/thread_ranks.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Problem;
using ccvt::test::message_of;
using ccvt::test::messages_of;

namespace {

void check_message(int count, const std::function<void(ccvt::Ranks&)>& work,
                   const std::string& expected) {
  const std::set<std::string> messages = messages_of(count, work);
  REQUIRE(messages.size() == 1);
  CHECK(messages.begin()->find(expected) != std::string::npos);
}

/// Ranks whose messages fail on all of them at once, from one exchange on.
class FailingRanks final : public ccvt::Ranks {
 public:
  FailingRanks(ccvt::Ranks& ranks, int good) : ranks_(ranks), good_(good) {}
  [[nodiscard]] int rank() const override { return ranks_.rank(); }
  [[nodiscard]] int count() const override { return ranks_.count(); }
  [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> own) override {
    return ranks_.gather(own);
  }
  [[nodiscard]] std::vector<Bytes> exchange(std::vector<Bytes> to) override {
    auto come = ranks_.exchange(std::move(to));
    if (good_-- <= 0) throw std::length_error("a message is too long");
    return come;
  }
  void send(int to, Bytes message) override { ranks_.send(to, std::move(message)); }
  [[nodiscard]] Bytes receive(int from) override { return ranks_.receive(from); }

 private:
  ccvt::Ranks& ranks_;
  int good_;
};

/// Ranks that send, and take what has been sent, now and then late.
class LateRanks final : public ccvt::Ranks {
 public:
  explicit LateRanks(ccvt::Ranks& ranks)
      : ranks_(ranks), random_(static_cast<std::uint64_t>(ranks.rank())) {}
  [[nodiscard]] int rank() const override { return ranks_.rank(); }
  [[nodiscard]] int count() const override { return ranks_.count(); }
  [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> own) override {
    wait();
    return ranks_.gather(own);
  }
  [[nodiscard]] std::vector<Bytes> exchange(std::vector<Bytes> to) override {
    wait();
    return ranks_.exchange(std::move(to));
  }
  void send(int to, Bytes message) override {
    wait();
    ranks_.send(to, std::move(message));
  }
  [[nodiscard]] Bytes receive(int from) override {
    wait();
    return ranks_.receive(from);
  }

 private:
  void wait() {
    if (random_.uniform() > 0.05) return;
    std::this_thread::sleep_for(
        std::chrono::microseconds(static_cast<int>(random_.uniform() * 500)));
  }

  ccvt::Ranks& ranks_;
  ccvt::Random random_;
};

/// White noise in a unit box.
struct Noise {
  int dimension;
  Index points;
  Index sites;
  bool periodic = true;

  [[nodiscard]] Box box() const { return Box::unit(dimension); }
  template <class... Given>
  [[nodiscard]] Problem<float> problem(Given&&... given) const {
    Problem<float> made(std::forward<Given>(given)..., sites);
    if (periodic) made.set_domain(Domain::periodic(box()));
    return made;
  }
};

/// So many ranks get the bits of one process.
void check_same(const Noise& noise, int count) {
  CAPTURE(noise.dimension);
  CAPTURE(noise.sites);
  CAPTURE(count);
  const Index all = noise.points;
  const ccvt::Points<float> points = ccvt::sample_uniform<float>(noise.box(), all, 3);
  const Options options{.threads = 1};
  const auto expected = ccvt::tessellate(noise.problem(points), options);
  std::vector<Index> owners(static_cast<std::size_t>(all), -1);
  std::vector<int> same(static_cast<std::size_t>(count), 0);
  ThreadRanks(count).run([&](ccvt::Ranks& on_time) {
    LateRanks ranks(on_time);
    const Index begin = all / count * ranks.rank();
    const Index end = ranks.rank() + 1 == count ? all : begin + all / count;
    const auto own = ccvt::sample_uniform_part<float>(noise.box(), all, begin, end, 3);
    const Problem<float> problem =
        noise.problem(static_cast<ccvt::Ranks&>(ranks), ccvt::view_points(own));
    const auto result = ccvt::tessellate(problem, options);
    std::copy(result.owners.begin(), result.owners.end(), owners.begin() + begin);
    same[static_cast<std::size_t>(ranks.rank())] =
        result.sites == expected.sites && result.summary.energy == expected.summary.energy &&
                result.summary.swaps == expected.summary.swaps
            ? 1
            : 0;
  });
  CHECK(owners == expected.owners);
  CHECK(std::count(same.begin(), same.end(), 1) == count);
}

}  // namespace

TEST_SUITE_BEGIN("ranks");

TEST_CASE("ranks: threads that are ranks get the bits of one process, however late messages are") {
  for (const int dimension : {2, 3}) {
    for (const int count : {2, 3, 5}) check_same({dimension, 30011, 200}, count);
  }
}

TEST_CASE("ranks: messages get on while tasks are run") {
  const ccvt::Box box = ccvt::Box::unit(2);
  ThreadRanks all(2);
  all.run([&](ccvt::Ranks& ranks) {
    const Index begin = 10000 * ranks.rank();
    const auto own = ccvt::sample_uniform_part<float>(box, 20000, begin, begin + 10000, 3);
    const Problem<float> problem(ranks, ccvt::view_points(own), 400);
    const auto result = ccvt::tessellate(problem, {.threads = 1});
    CHECK(result.summary.swaps > 0);
  });
  CHECK(all.progressed() > 100);
}

TEST_CASE("ranks: the same in as many dimensions as they can have, where pairs are screened") {
  for (const int dimension : {1, 5, 7, 8}) {
    for (const bool periodic : {false, true}) {
      check_same({dimension, 6007, 200, periodic}, 3);
      check_same({dimension, 2003, 30, periodic}, 2);
    }
  }
  // More pairs may gain than rounds of a tournament are for.
  check_same({8, 900, 300, false}, 4);
}

TEST_CASE("ranks: initial owners, in any number of dimensions, lead to the bits of one process") {
  for (const int dimension : {2, 12}) {
    CAPTURE(dimension);
    constexpr Index kPoints = 3001;
    constexpr Index kSites = 150;
    const auto points = ccvt::sample_uniform<float>(Box::unit(dimension), kPoints, 4);
    std::vector<Index> capacities(kSites, 20);
    capacities[7] = 21;
    std::vector<Index> owners;
    for (Index s = 0; s < kSites; ++s) {
      owners.insert(owners.end(), static_cast<std::size_t>(capacities[static_cast<std::size_t>(s)]),
                    s);
    }
    ccvt::Random(3, 3).shuffle(std::span(owners));
    const Options options{.threads = 1};
    Problem<float> alone(points, kSites);
    alone.set_capacities(capacities).set_initial_owners(owners);
    const auto expected = ccvt::tessellate(alone, options);
    for (const int count : {1, 2, 3, 5}) {
      CAPTURE(count);
      // The last but one of three and more has no points.
      const auto begin_of = [&](int rank) {
        if (count > 2 && rank == count - 1) --rank;
        return kPoints * rank / count;
      };
      std::vector<Index> found(kPoints, -1);
      std::atomic<int> same = 0;
      ThreadRanks(count).run([&](ccvt::Ranks& on_time) {
        LateRanks ranks(on_time);
        const Index begin = begin_of(ranks.rank());
        const Index end = begin_of(ranks.rank() + 1);
        const ccvt::Points<float> own = points.middleCols(begin, end - begin);
        Problem<float> problem(ranks, ccvt::view_points(own), kSites);
        problem.set_capacities(capacities)
            .set_initial_owners({owners.begin() + begin, owners.begin() + end});
        const auto result = ccvt::tessellate(problem, options);
        std::copy(result.owners.begin(), result.owners.end(), found.begin() + begin);
        same += result.sites == expected.sites &&
                        result.summary.energy == expected.summary.energy &&
                        result.summary.swaps == expected.summary.swaps &&
                        result.summary.initialization_used == "owners"
                    ? 1
                    : 0;
      });
      CHECK(found == expected.owners);
      CHECK(same == count);
    }
  }
}

TEST_CASE("ranks: what is wrong with a problem is thrown on all") {
  const Box box = Box::unit(2);
  const auto points = [&](Index count) { return ccvt::sample_uniform<double>(box, count, 3); };
  const ccvt::Points<double> good = points(3000);
  ccvt::Points<double> bad = good;
  bad(1, 7) = 2;
  const auto problem = [&](ccvt::Ranks& ranks, Index sites) {
    return Problem<double>(ranks, ccvt::view_points(good), sites);
  };
  check_message(
      3,
      [&](ccvt::Ranks& ranks) {
        Problem<double>(ranks, ccvt::view_points(ranks.rank() == 1 ? bad : good), 40)
            .set_domain(Domain::euclidean(box));
      },
      "coordinate 1 of points[3007] is 2: it must lie in the box");
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        const ccvt::Points<double> own = ranks.rank() == 1 ? good.topRows(1) : good;
        Problem<double>(ranks, ccvt::view_points(own), 40);
      },
      "ranks: rank 1 has points of 1 dimensions for 40 sites, rank 0 has 2 for 40");
  check_message(
      520,
      [&](ccvt::Ranks& ranks) {
        const ccvt::PointsView<double> many{good.data(), 1, 2147483647, 0};
        Problem<double>(ranks, many, 1000);
      },
      "points: there are 1116691496440 of them on all ranks, but at most 1099511627776");
  check_message(
      2, [&](ccvt::Ranks& ranks) { ccvt::lloyd(problem(ranks, 40)); },
      "problem: is one of several ranks, which lloyd() does not know");
  check_message(
      2, [&](ccvt::Ranks& ranks) { problem(ranks, 40).set_initial_owners({0}); },
      "initial_owners: there are 1 for 3000 points: there must be one per point");
  const auto from = [&](ccvt::Ranks& ranks, const std::vector<Index>& owners) {
    Problem<double> made = problem(ranks, 3000);
    made.set_initial_owners(owners);
    ccvt::tessellate(made);
  };
  std::vector<Index> owners(3000);
  for (Index p = 0; p < 3000; ++p) owners[static_cast<std::size_t>(p)] = p;
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        std::vector<Index> own = owners;
        if (ranks.rank() == 1) own[5] = 3000;
        from(ranks, own);
      },
      "initial_owners[3005] is 3000: it must be in 0..2999");
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        std::vector<Index> own = owners;
        if (ranks.rank() == 1) own[5] = 4;
        from(ranks, own);
      },
      "initial_owners: site 4 owns 3 points on all ranks together, but its capacity is 2: the two "
      "must be equal");
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        const Problem<double> without = problem(ranks, 3000);
        Problem<double> with = without;
        with.set_initial_owners(owners);
        ccvt::tessellate(ranks.rank() == 1 ? with : without);
      },
      "initial_owners: rank 0 has none for its points, others have: all must be given");
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        ccvt::tessellate(problem(ranks, 40),
                         {.threads = 1, .initialization = ccvt::Initialization::coherent});
      },
      "options.initialization: is coherent, which is the default beyond 8 dimensions, too");
  const auto run_with = [&](int others, const auto& change) {
    return [&problem, others, change](ccvt::Ranks& ranks) {
      ccvt::Options options{.threads = 1};
      if (ranks.rank() == others) change(options);
      ccvt::tessellate(problem(ranks, 40), options);
    };
  };
  check_message(
      3, run_with(2, [](ccvt::Options& options) { options.seed = 9; }),
      "the option seed is 9 on rank 2, but 0 on rank 0: all ranks must be given the same");
  check_message(2, run_with(1, [](ccvt::Options& options) { options.energy_tolerance = 0.25; }),
                "the option energy_tolerance is 0.25 on rank 1, but 0 on rank 0");
  check_message(2, run_with(0, [](ccvt::Options& options) { options.max_iterations = 7; }),
                "the option max_iterations is 1000000 on rank 1, but 7 on rank 0");
  check_message(2, run_with(1, [](ccvt::Options& options) { options.tile_sites = 0; }),
                "tile_sites");
  check_message(
      2,
      [&](ccvt::Ranks& ranks) {
        Problem<double> own = problem(ranks, 40);
        std::vector<Index> capacities = own.capacities();
        capacities[0] -= ranks.rank();
        capacities[1] += ranks.rank();
        own.set_capacities(capacities);
        ccvt::tessellate(own, {.threads = 1});
      },
      "the capacities: rank 1 and rank 0 must be given the same");
}

TEST_CASE("ranks: a message that fails is thrown, whatever it was for") {
  const Box box = Box::unit(2);
  const ccvt::Points<float> points = ccvt::sample_uniform<float>(box, 8000, 3);
  std::set<std::string> messages;
  int good = 0;
  for (; messages.count("nothing thrown") == 0; ++good) {
    REQUIRE(good < 1000);
    messages = messages_of(2, [&](ccvt::Ranks& ranks) {
      FailingRanks failing(ranks, good);
      const auto own = points.middleCols(4000 * ranks.rank(), 4000).eval();
      try {
        ccvt::tessellate(Problem<float>(failing, ccvt::view_points(own), 200), {.threads = 1});
      } catch (const std::exception& error) {  // length_error, or what tells of it on all ranks
        throw ccvt::InvalidInput(error.what());
      }
    });
    REQUIRE(messages.size() == 1);
    if (messages.count("nothing thrown") == 0) {
      CHECK(messages.begin()->find("a message is too long") != std::string::npos);
    }
  }
  CHECK(good > 3);  // points join more than once
}

TEST_CASE("ranks: a part of the points that are drawn, and of a file's") {
  const ccvt::test::TemporaryDirectory directory;
  const Box box = Box::unit(3);
  const ccvt::Points<double> all = ccvt::sample_uniform<double>(box, 9001, 3);
  const auto path = directory.path() / "points.npy";
  ccvt::write_points(path, all);
  for (const auto& part_of_all : {std::pair<Index, Index>{0, 9001},
                                  {0, 0},
                                  {17, 18},
                                  {4095, 8193},
                                  {9000, 9001},
                                  {9001, 9001}}) {
    const Index begin = part_of_all.first;
    const Index end = part_of_all.second;
    CAPTURE(begin);
    CHECK((ccvt::sample_uniform_part<double>(box, 9001, begin, end, 3) ==
           all.middleCols(begin, end - begin)));
    const ccvt::ReadOptions part{.first_row = static_cast<std::uint64_t>(begin),
                                 .end_row = static_cast<std::uint64_t>(end)};
    CHECK((ccvt::read_points<double>(path, part) == all.middleCols(begin, end - begin)));
  }
  CHECK(message_of([&] { ccvt::sample_uniform_part<double>(box, 9, 4, 10); }) ==
        "first: the points 4 to 10 are asked for, of 9: it must hold that 0 <= first <= end <= "
        "count");
  const auto table = directory.path() / "points.csv";
  ccvt::write_points(table, all);
  CHECK(message_of([&] { ccvt::read_points<double>(table, {.first_row = 3}); }) ==
        table.string() +
            ": first_row and end_row ask for a part of the rows, which is read of .npy, .fvecs and "
            ".bvecs files only");
  const auto columns = directory.path() / "columns.npy";
  ccvt::test::put(columns, ccvt::test::npy_file("<f8", "(2, 1)", std::string(16, '\0'), true));
  CHECK(message_of([&] { ccvt::read_points<double>(columns, {.first_row = 1}); }) ==
        columns.string() +
            ": is in Fortran order; a part of its rows is read of files in C order only");
}

TEST_SUITE_END();
