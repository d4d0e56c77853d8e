// Runs of several ranks, which are threads here, that are saved and go on with any other number;
// tests/checkpoint/kills.py has processes that are killed.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "checkpoint/tile_parts.h"
#include "parallel/recorder.h"
#include "parallel/together.h"
#include "random.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/same.h"
#include "support/thread_ranks.h"

using ccvt::Box;
using ccvt::CheckpointRecord;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Ranks;
using ccvt::Solver;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

namespace fs = std::filesystem;

constexpr int kStop = 4;  // iterations after which runs are cut short

/// Calls work(ranks) on so many ranks; of none, once, with null.
void run_on(int count, const std::function<void(Ranks*)>& work) {
  if (count == 0) return work(nullptr);
  ThreadRanks(count).run([&](Ranks& ranks) { work(&ranks); });
}

/// A problem that any number of ranks can be given.
template <class Scalar>
struct Given {
  Points<Scalar> points;
  Index sites;
  Options options;
  std::function<void(Problem<Scalar>&)> set_up = [](Problem<Scalar>&) {};

  /// This rank's points: not as many for each, and for some none.
  [[nodiscard]] std::pair<Index, Index> part(const Ranks* ranks) const {
    const auto all = static_cast<Index>(points.cols());
    if (ranks == nullptr) return {0, all};
    const auto place = [&](int rank) {
      if (rank == ranks->count()) return all;
      const double part = static_cast<double>(std::max(rank - 1, 0)) / ranks->count();
      return static_cast<Index>(all * part * part);
    };
    return {place(ranks->rank()), place(ranks->rank() + 1)};
  }
  /// Calls work(solver) on so many ranks.
  void solve(int count, const Options& with,
             const std::function<void(Solver<Scalar>&, Ranks*)>& work) const {
    run_on(count, [&](Ranks* ranks) {
      const auto [first, end] = part(ranks);
      const Points<Scalar> own = points.middleCols(first, end - first);
      Problem<Scalar> problem = ranks == nullptr
                                    ? Problem<Scalar>(points, sites)
                                    : Problem<Scalar>(*ranks, ccvt::view_points(own), sites);
      set_up(problem);
      Options own_options = with;
      own_options.threads = 1 + (ranks == nullptr ? 0 : ranks->rank() % 2);
      Solver<Scalar> solver(problem, own_options);
      work(solver, ranks);
    });
  }
  void solve(int count, const std::function<void(Solver<Scalar>&, Ranks*)>& work) const {
    solve(count, options, work);
  }
};

/// What ranks have come to together.
template <class Scalar>
struct Outcome {
  Points<Scalar> sites;
  std::vector<Index> owners;
  ccvt::Summary summary;
  std::mutex mutex = {};
  bool differs = false;  ///< one rank's sites from those of another

  void take(const Given<Scalar>& given, const Solver<Scalar>& solver, const Ranks* ranks) {
    const std::vector<Index> own = solver.owners();
    const std::lock_guard lock(mutex);
    owners.resize(static_cast<std::size_t>(given.points.cols()), -1);
    std::copy(own.begin(), own.end(), owners.begin() + given.part(ranks).first);
    differs = differs || (sites.size() > 0 && !same_bits(sites, solver.sites()));
    sites = solver.sites();
    summary = solver.summary();
  }
};

/// The file of a checkpoint but for the times that it holds, and the digest of the part they are
/// in.
std::string without_times(std::string bytes, int iterations) {
  constexpr std::size_t kHeader = 40;  // with the length of the first part at 16
  std::uint64_t length = 0;
  REQUIRE(bytes.size() > kHeader);
  std::memcpy(&length, &bytes[16], sizeof length);
  const std::size_t times = 8 * (3 + 4 * ccvt::kPhases + static_cast<std::size_t>(iterations));
  const std::size_t end = kHeader + static_cast<std::size_t>(length);
  REQUIRE(end + 8 < bytes.size());
  REQUIRE(times < length);
  std::fill(bytes.begin() + std::ptrdiff_t(end - times), bytes.begin() + std::ptrdiff_t(end + 8),
            '\0');
  return bytes;
}

template <class Scalar>
void save_after(const Given<Scalar>& given, int count, int steps, const fs::path& file) {
  std::vector<int> done(static_cast<std::size_t>(std::max(count, 1)), 0);
  given.solve(count, [&](Solver<Scalar>& solver, const Ranks* ranks) {
    bool goes_on = true;
    for (int k = 0; k < steps; ++k) goes_on = solver.step() && goes_on;
    if (goes_on) solver.save(file);
    done[static_cast<std::size_t>(ranks == nullptr ? 0 : ranks->rank())] = goes_on ? 1 : 0;
  });
  REQUIRE(std::count(done.begin(), done.end(), 1) == std::ptrdiff_t(done.size()));
}

/// Each number of ranks saves after so many steps, and each other one goes on from there.
template <class Scalar>
void check_all_ways(const Given<Scalar>& given, const std::vector<int>& steps,
                    const std::vector<int>& counts = {0, 1, 2, 3, 4}) {
  const TemporaryDirectory directory;
  Outcome<Scalar> whole;
  given.solve(0, [&](Solver<Scalar>& solver, const Ranks* ranks) {
    solver.run();
    whole.take(given, solver, ranks);
  });
  for (const int step : steps) {
    CAPTURE(step);
    REQUIRE(step < whole.summary.iterations);
    std::string expected;
    for (const int from : counts) {
      CAPTURE(from);
      const fs::path file = directory / "run";
      save_after(given, from, step, file);
      const std::string bytes = without_times(get(file), step);
      if (expected.empty()) expected = bytes;
      CHECK(bytes == expected);
      for (const int to : counts) {
        CAPTURE(to);
        Outcome<Scalar> end;
        given.solve(to, [&](Solver<Scalar>& solver, const Ranks* ranks) {
          solver.load(file);
          solver.run();
          end.take(given, solver, ranks);
        });
        CHECK(differences(whole, end) == "");
        CHECK(!end.differs);
      }
    }
    CHECK(directory.entries() == 1);
  }
}

template <class Scalar>
Given<Scalar> cloud(int dimension, Index points, Index sites, const Options& options,
                    const Domain& domain = {}) {
  return {make_points<Scalar>(Layout::random, uneven_box(dimension), points), sites, options,
          [domain](Problem<Scalar>& problem) { problem.set_domain(domain); }};
}

/// A run that is saved after three steps, by as many ranks.
struct Saved {
  Given<float> given = cloud<float>(2, 900, 20, {.seed = 4, .tile_sites = 3});
  TemporaryDirectory directory;
  fs::path file = directory / "run";
  std::string bytes;

  Saved() {
    save_after(given, 3, 3, file);
    bytes = get(file);
  }
  /// What each rank of some says that loads the file into a solver with these options.
  [[nodiscard]] std::string refusal(int count, const Options& options) const {
    std::set<std::string> messages;
    std::mutex mutex;
    given.solve(count, options, [&](Solver<float>& solver, const Ranks*) {
      const std::string message = message_of([&] { solver.load(file); });
      const std::lock_guard lock(mutex);
      messages.insert(message);
    });
    REQUIRE(messages.size() == 1);
    const std::string start = file.string() + ": ";
    return messages.begin()->rfind(start, 0) == 0 ? messages.begin()->substr(start.size())
                                                  : *messages.begin();
  }
};

/// While one lives, no file of this process may be longer.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

/// So many parts for each rank, of a few bytes.
std::vector<ccvt::TilePart> parts_for(int count, const std::vector<int>& of_rank) {
  std::vector<ccvt::TilePart> parts;
  for (int r = 0; r < count; ++r) {
    for (int k = 0; k < of_rank[static_cast<std::size_t>(r)]; ++k) {
      const std::size_t number = parts.size();
      parts.push_back({number,
                       number + 1,
                       {0, 1 + number % 3},
                       r,
                       k == 0,
                       k + 1 == of_rank[static_cast<std::size_t>(r)]});
    }
  }
  return parts;
}

std::vector<std::byte> bytes_of(const ccvt::TilePart& part) {
  return std::vector<std::byte>(part.bytes(), static_cast<std::byte>(part.first));
}

/// Throws at one of the calls.
void fail_at(int call, int number) {
  if (call == number) throw ccvt::IoError("call " + std::to_string(number));
}

/// Nothing is on its way between ranks: what is sent now is what comes next.
bool is_silent(Ranks& ranks) {
  const int next = (ranks.rank() + 1) % ranks.count();
  const int before = (ranks.rank() + ranks.count() - 1) % ranks.count();
  bool silent = true;
  for (const int to : {next, 0}) ranks.send(to, {std::byte{77}});
  silent = ranks.receive(before) == Ranks::Bytes{std::byte{77}};
  for (int r = 0; ranks.rank() == 0 && r < ranks.count(); ++r) {
    silent = ranks.receive(r) == Ranks::Bytes{std::byte{77}} && silent;
  }
  return silent;
}

}  // namespace

TEST_SUITE_BEGIN("ranks");

TEST_CASE_TEMPLATE("Saved by any number of ranks, a run goes on with any other", Scalar, float,
                   double) {
  check_all_ways(
      cloud<Scalar>(2, 4000, 150, {.seed = 1, .tile_sites = 9}, Domain::periodic(uneven_box(2))),
      {0, 1, 8});
  check_all_ways(cloud<Scalar>(3, 3000, 90, {.seed = 2, .tile_sites = 9}), {0, 5});
}

TEST_CASE("Of whatever options, from ranks to one process and back") {
  const auto check = [](const Options& options) {
    check_all_ways(cloud<double>(2, 2000, 120, options, Domain::periodic(uneven_box(2))), {3},
                   {0, 2, 3});
  };
  check({.seed = 5, .multilevel = false, .cached_passes = 3});
  check({.seed = 5, .multilevel = false, .cached_passes = 3, .tile_sites = 1});
  check({.pairs = ccvt::PairSelection::all, .tile_sites = 7});
  check_all_ways(cloud<float>(1, 900, 12, {.tile_sites = 2}), {1}, {0, 2, 3});
}

TEST_CASE("With capacities, sites that stay and sites that are given, fewer tiles than ranks") {
  const std::vector<Index> capacities = unequal_capacities(40);
  Given<double> given = cloud<double>(2, sum_of(capacities), 40, {.seed = 3, .tile_sites = 5});
  given.set_up = [&](Problem<double>& problem) {
    problem.set_domain(Domain::periodic(uneven_box(2), {true, false}));
    problem.set_capacities(capacities);
    problem.set_initial_sites(given.points.rightCols(40));
    problem.set_fixed_sites(given.points.leftCols(7));
  };
  check_all_ways(given, {2}, {0, 2, 4});
  check_all_ways(cloud<float>(2, 600, 10, {}), {2}, {0, 2, 3});
}

TEST_CASE("From initial owners on, which a digest of all ranks tells from others") {
  std::vector<Index> owners(800);
  for (std::size_t p = 0; p < owners.size(); ++p) owners[p] = static_cast<Index>(p % 40);
  ccvt::Random(7, 7).shuffle(std::span(owners));
  Given<double> given = cloud<double>(2, 800, 40, {.tile_sites = 5});
  const auto set_up = [&](Problem<double>& problem) {
    problem.set_domain(Domain::periodic(uneven_box(2)));
    problem.set_fixed_sites(given.points.leftCols(3));
    const auto first = owners.begin() + problem.first_own_point();
    problem.set_initial_owners({first, first + problem.points().count});
  };
  given.set_up = set_up;
  check_all_ways(given, {1, 4}, {0, 1, 2, 4});
  const TemporaryDirectory directory;
  save_after(given, 3, 1, directory / "run");
  std::swap(owners[500], owners[700]);
  REQUIRE(owners[500] != owners[700]);
  for (const int count : {0, 4}) {
    std::set<std::string> messages;
    std::mutex mutex;
    given.solve(count, [&](Solver<double>& solver, const Ranks*) {
      const std::string message = message_of([&] { solver.load(directory / "run"); });
      const std::lock_guard lock(mutex);
      messages.insert(message);
    });
    REQUIRE(messages.size() == 1);
    CHECK(messages.begin()->find("the initial owners are not the same") != std::string::npos);
  }
}

TEST_CASE("With cells that are large enough for patches") {
  check_all_ways(cloud<float>(2, 60'000, 16, {.seed = 1, .descent_points = 0, .tile_sites = 2}),
                 {1, 12}, {0, 3});
}

TEST_CASE("A run goes on after each iteration with another number of ranks") {
  const TemporaryDirectory directory;
  const Given<float> given = cloud<float>(2, 5000, 130, {.seed = 6, .tile_sites = 8});
  Outcome<float> whole;
  given.solve(0, [&](Solver<float>& solver, const Ranks* ranks) {
    solver.run();
    whole.take(given, solver, ranks);
  });
  REQUIRE(whole.summary.iterations > 10);
  Outcome<float> end;
  for (int k = 0; k < whole.summary.iterations; ++k) {
    given.solve((7 * k + k / 3) % 5, [&](Solver<float>& solver, const Ranks* ranks) {
      if (k > 0) solver.load(directory / "run");
      if (solver.step()) return solver.save(directory / "run");
      end.take(given, solver, ranks);
    });
  }
  CHECK(differences(whole, end) == "");
}

TEST_CASE("Runs of ranks that are kept go on from their file, however they were cut short") {
  const Given<float> given = cloud<float>(2, 3000, 80, {.seed = 4, .tile_sites = 8});
  Outcome<float> whole;
  given.solve(0, [&](Solver<float>& solver, const Ranks* ranks) {
    solver.run();
    whole.take(given, solver, ranks);
  });
  for (const int way : {0, 1, 2, 3}) {
    CAPTURE(way);
    const TemporaryDirectory directory;
    Options options = given.options;
    options.checkpoint = directory / "kept";
    const auto limited = [&](const Ranks* ranks, int& iterations) {
      Options own = options;
      own.threads = 1;
      if (way == 0) own.max_iterations = kStop;
      const bool last = ranks->rank() + 1 == ranks->count();
      own.on_iteration = [&iterations, last, way](const ccvt::IterationRecord&) {
        return ++iterations < kStop || way != 1 || !last;  // on one rank only
      };
      if (way == 2) own.cancelled = [&iterations, last] { return last && iterations >= kStop; };
      return own;
    };
    std::mutex mutex;
    std::vector<ccvt::Summary> summaries;
    ThreadRanks(3).run([&](Ranks& ranks) {
      const auto [first, end] = given.part(&ranks);
      const Points<float> own = given.points.middleCols(first, end - first);
      int iterations = 0;
      Solver<float> solver(Problem<float>(ranks, ccvt::view_points(own), given.sites),
                           limited(&ranks, iterations));
      while (way != 3 || iterations < kStop) {
        if (!solver.step()) break;
      }
      solver.cancel();
      const std::lock_guard lock(mutex);
      summaries.push_back(solver.summary());
    });
    for (const ccvt::Summary& summary : summaries) {
      CHECK(summary.termination ==
            (way == 0 ? Termination::iteration_limit : Termination::cancelled));
      CHECK(summary.iterations == kStop);
    }
    std::vector<CheckpointRecord> events;
    options.on_checkpoint = [&](const CheckpointRecord& record) {
      const std::lock_guard lock(mutex);
      events.push_back(record);
    };
    Outcome<float> end;
    given.solve(2, options, [&](Solver<float>& solver, const Ranks* ranks) {
      solver.run();
      end.take(given, solver, ranks);
    });
    CHECK(differences(whole, end) == "");
    REQUIRE(events.size() == 2);  // one a rank
    for (const CheckpointRecord& record : events) {
      CHECK(record.event == CheckpointRecord::Event::continued);
      CHECK(record.iteration == kStop);
    }
  }
}

TEST_CASE("All ranks save when it is time for one") {
  const TemporaryDirectory directory;
  const Given<float> given = cloud<float>(2, 900, 20, {.seed = 4});
  Options options = given.options;
  options.checkpoint = directory / "kept";
  options.checkpoint_seconds = 0;
  options.max_iterations = 3;
  std::mutex mutex;
  std::vector<int> saved;
  options.on_checkpoint = [&](const CheckpointRecord& record) {
    CHECK(record.event == CheckpointRecord::Event::saved);
    const std::lock_guard lock(mutex);
    saved.push_back(record.iteration);
  };
  given.solve(2, options, [](Solver<float>& solver, const Ranks*) { solver.run(); });
  std::sort(saved.begin(), saved.end());
  CHECK(saved == std::vector<int>{0, 0, 1, 1, 2, 2, 3, 3, 3, 3});
}

TEST_CASE("What is refused is refused on all ranks") {
  Saved saved;
  const Options same = saved.given.options;
  for (const int count : {1, 2, 4}) {
    CAPTURE(count);
    Options other = same;
    other.seed = 5;
    CHECK(saved.refusal(count, other) ==
          "is of another run: the option seed is 4 there, and here 5");
    put(saved.file, saved.bytes.substr(0, saved.bytes.size() - 1));
    CHECK(saved.refusal(count, same).find("bytes, but was written with") != std::string::npos);
    std::string damaged = saved.bytes;
    damaged[100] ^= 1;
    put(saved.file, damaged);
    CHECK(saved.refusal(count, same) == "is damaged: what it has of the sites is not as written");
    std::uint64_t tiles = 0;
    std::memcpy(&tiles, &saved.bytes[24], sizeof tiles);
    for (const std::uint64_t from_end :
         {std::uint64_t{20}, tiles}) {  // of the last rank, the first
      damaged = saved.bytes;
      damaged[damaged.size() - static_cast<std::size_t>(from_end)] ^= 1;
      put(saved.file, damaged);
      CHECK(saved.refusal(count, same) == "is damaged: what it has of cells is not as written");
    }
    fs::remove(saved.file);
    CHECK(saved.refusal(count, same) == "there is no such file");
    put(saved.file, saved.bytes);
    CHECK(saved.refusal(count, same) == "nothing thrown");
    saved.given.points(0, 450) += 0.001F;  // of one rank
    CHECK(saved.refusal(count, same) == "is of another run: the points are not the same");
    saved.given.points(0, 450) = make_points<float>(Layout::random, uneven_box(2), 900)(0, 450);
  }
}

TEST_CASE("A refused file leaves all ranks as they were, and a run that has ended saves none") {
  const Saved saved;
  std::string damaged = saved.bytes;
  damaged[damaged.size() - 20] ^= 1;
  put(saved.file, damaged);
  Outcome<float> whole;
  Outcome<float> end;
  saved.given.solve(0, [&](Solver<float>& solver, const Ranks* ranks) {
    solver.run();
    whole.take(saved.given, solver, ranks);
  });
  std::set<std::string> messages;
  saved.given.solve(3, [&](Solver<float>& solver, const Ranks* ranks) {
    for (int k = 0; k < 5; ++k) solver.step();
    static_cast<void>(message_of([&] { solver.load(saved.file); }));
    solver.run();
    end.take(saved.given, solver, ranks);
    const std::string message = message_of([&] { solver.save(saved.file); });
    const std::lock_guard lock(end.mutex);
    messages.insert(message);
  });
  CHECK(differences(whole, end) == "");
  CHECK(messages ==
        std::set<std::string>{saved.file.string() + ": a run that has ended leaves no checkpoint"});
}

TEST_CASE("Where one rank cannot write, all hear why; a later failure does not end the run") {
  const TemporaryDirectory directory;
  const Given<float> given = cloud<float>(2, 40'000, 200, {.seed = 4, .level_points = 4});
  Options options = given.options;
  options.checkpoint = directory / "none" / "kept";
  const std::set<std::string> messages = messages_of(3, [&](Ranks& ranks) {
    const auto [first, end] = given.part(&ranks);
    const Points<float> own = given.points.middleCols(first, end - first);
    Solver<float>(Problem<float>(ranks, ccvt::view_points(own), given.sites), options);
  });
  CHECK(messages == std::set<std::string>{"IoError: " + options.checkpoint.string() +
                                          ": cannot be written: there is no directory '" +
                                          (directory / "none").string() + "'"});

  options.checkpoint = directory / "kept";
  options.checkpoint_seconds = 0;
  Outcome<float> whole;
  Outcome<float> end;
  given.solve(0, [&](Solver<float>& solver, const Ranks* ranks) {
    solver.run();
    whole.take(given, solver, ranks);
  });
  {
    const FileLimit limit(100'000);  // coarse levels take less
    given.solve(3, options, [&](Solver<float>& solver, const Ranks* ranks) {
      solver.run();
      end.take(given, solver, ranks);
      CHECK(solver.summary().warnings.size() == 1);
    });
  }
  CHECK(differences(whole, end) == "");
  const std::string& warning = end.summary.warnings.at(0);
  CHECK(warning.find("no checkpoint could be written: " + options.checkpoint.string() +
                     ": cannot be written: File too large") != std::string::npos);
  CHECK(directory.entries() == 1);
  // What was kept before is whole.
  Options others = given.options;
  others.checkpoint = directory / "kept";
  Outcome<float> again;
  given.solve(2, others, [&](Solver<float>& solver, const Ranks* ranks) {
    CHECK(solver.summary().iterations > 0);
    CHECK(solver.summary().iterations < whole.summary.iterations);
    solver.run();
    again.take(given, solver, ranks);
  });
  CHECK(differences(whole, again) == "");
}

TEST_CASE("Parts of a file come in their order, and whatever fails leaves no rank waiting") {
  const std::vector<std::vector<int>> shapes = {
      {1, 1, 1, 1}, {3, 2, 3, 1}, {0, 2, 0, 3}, {2, 0, 0, 0}, {0, 1, 4, 1}};
  for (const int count : {1, 2, 3, 4}) {
    for (const std::vector<int>& shape : shapes) {
      const auto parts = parts_for(count, shape);
      const auto all = static_cast<int>(parts.size());
      for (int failing = 0; failing <= 2 * all; ++failing) {  // making one, or taking one, or none
        CAPTURE(count);
        CAPTURE(failing);
        const auto make = [&](const ccvt::TilePart& part) {
          fail_at(failing, static_cast<int>(part.first));
          return bytes_of(part);
        };
        const std::string expected =
            failing == 2 * all ? "nothing thrown" : "IoError: call " + std::to_string(failing);
        std::vector<std::byte> joined;
        for (const auto& part : parts) {
          const auto bytes = bytes_of(part);
          joined.insert(joined.end(), bytes.begin(), bytes.end());
        }
        for (const bool to_first : {true, false}) {
          CAPTURE(to_first);
          std::vector<std::byte> taken;
          std::vector<int> silent(static_cast<std::size_t>(count), 0);
          std::vector<int> right(parts.size(), 0);
          const auto messages = messages_of(count, [&](Ranks& ranks) {
            int calls = all;
            const auto pass_on = [&] {
              if (to_first) {
                return parts_to_first(&ranks, parts, make, [&](const Ranks::Bytes& bytes) {
                  fail_at(failing, calls++);
                  taken.insert(taken.end(), bytes.begin(), bytes.end());
                });
              }
              parts_from_first(&ranks, parts, make,
                               [&](const ccvt::TilePart& part, const Ranks::Bytes& bytes) {
                                 fail_at(failing, all + static_cast<int>(part.first));
                                 right[part.first] =
                                     part.rank == ranks.rank() && bytes == bytes_of(part) ? 1 : 0;
                               });
            };
            const std::string message = message_of([&] { agree(&ranks, pass_on); });
            silent[static_cast<std::size_t>(ranks.rank())] = is_silent(ranks) ? 1 : 0;
            if (message != "nothing thrown") throw ccvt::IoError(message.substr(9));
          });
          CHECK(messages == std::set<std::string>{expected});
          CHECK(std::count(silent.begin(), silent.end(), 1) == count);
          if (failing < 2 * all) continue;
          if (to_first) CHECK(taken == joined);
          if (!to_first) CHECK(std::count(right.begin(), right.end(), 1) == all);
        }
      }
    }
  }
}

TEST_SUITE_END();
