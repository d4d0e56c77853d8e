// A callback that turns true in the middle is heard soon, wherever that is, and what comes back is
// whole.

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ccvt/ccvt.h"
#include "parallel/arena.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/thread_ranks.h"

namespace ccvt::test {
namespace {

TEST_SUITE_BEGIN("cancel");

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// A callback that turns true some time after it was made, and notes who asks and when.
class Signal {
 public:
  explicit Signal(milliseconds after) : due_(Clock::now() + after) {}

  std::function<bool()> callback() {
    return [this] {
      if (std::this_thread::get_id() != thread_) ++elsewhere;
      return Clock::now() >= due_;
    };
  }
  /// Seconds since it turned true; negative when it has not.
  [[nodiscard]] double late() const {
    return std::chrono::duration<double>(Clock::now() - due_).count();
  }
  std::atomic<int> elsewhere{0};

 private:
  Clock::time_point due_;
  std::thread::id thread_ = std::this_thread::get_id();
};

/// Calls work(callback) with signals that come later and later, until it ends before them.
template <class Work>
void check_heard(const Work& work) {
  // Allows for a machine that is busy with other things, and for sanitizers.
  constexpr double kLatest = 5;
  for (const int after : {0, 5, 60}) {
    CAPTURE(after);
    Signal signal{milliseconds(after)};
    const bool cancelled = work(signal.callback());
    CHECK(signal.elsewhere == 0);
    CHECK(signal.late() < kLatest);
    if (after == 0) CHECK(cancelled);
    if (!cancelled) return;  // it was faster
    CHECK(signal.late() >= 0);
  }
}

/// Whether `work` throws Cancelled.
template <class Work>
bool is_cancelled(const Work& work) {
  try {
    work();
  } catch (const Cancelled&) {
    return true;
  }
  return false;
}

TEST_CASE("tessellate: every start, in the start and after it") {
  for (const int dimension : {2, 3, 12}) {
    const auto points = make_points<float>(Layout::random, Box::unit(dimension), 400'000);
    for (const auto start :
         {Initialization::balanced, Initialization::coherent, Initialization::random}) {
      CAPTURE(dimension);
      for (const int threads : {1, 2}) {
        check_heard([&](const auto& cancelled) {
          const auto result = tessellate(
              points, 4000, {.threads = threads, .initialization = start, .cancelled = cancelled});
          CHECK(capacity_error(result.owners, 4000) == 0);
          CHECK(result.sites.allFinite());
          CHECK(result.summary.energy ==
                doctest::Approx(energy(points, result.sites, result.owners)).epsilon(1e-3));
          return result.summary.termination == Termination::cancelled;
        });
      }
    }
  }
}

TEST_CASE("tessellate: initial owners stay when a run is cancelled or late from the first") {
  const auto points = sample_uniform<double>(Box::unit(2), 3000, 6);
  std::vector<Index> owners(3000);
  for (std::size_t p = 0; p < owners.size(); ++p) owners[p] = static_cast<Index>(p % 100);
  Problem<double> problem(points, 100);
  problem.set_initial_owners(owners);
  const auto cancelled = tessellate(problem, {.cancelled = [] { return true; }});
  CHECK(cancelled.owners == owners);
  CHECK(cancelled.summary.termination == Termination::cancelled);
  const auto late = tessellate(problem, {.time_limit = 1e-9});
  CHECK(late.owners == owners);
  CHECK(late.summary.termination == Termination::time_limit);
}

TEST_CASE("a solver called by Options::cancelled is cancelled, or refuses") {
  const auto points = sample_uniform<double>(Box::unit(2), 20'000, 6);
  using Use = std::function<void(Solver<double>&)>;
  const TemporaryDirectory directory;
  const fs::path file = directory / "run.ccvt";
  const std::vector<std::pair<const char*, Use>> uses = {
      {"cancel", [](Solver<double>& solver) { solver.cancel(); }},
      {"step", [](Solver<double>& solver) { solver.step(); }},
      {"run", [](Solver<double>& solver) { solver.run(); }},
      {"owners", [](Solver<double>& solver) { static_cast<void>(solver.owners()); }},
      {"save", [&](Solver<double>& solver) { solver.save(file); }},
      {"load", [&](Solver<double>& solver) { solver.load(file); }}};
  for (const auto& use : uses) {
    CAPTURE(use.first);
    Solver<double>* called = nullptr;
    Options options{.threads = 2};
    options.cancelled = [&] {
      if (called != nullptr) use.second(*called);
      return false;
    };
    Solver<double> solver(Problem<double>(points, 100), options);
    called = &solver;
    const std::string name = use.first;
    if (name == "cancel") {
      solver.run();
      CHECK(solver.summary().termination == Termination::cancelled);
    } else {
      CHECK(message_of([&] {
              solver.run();
            }).starts_with("Solver::" + name + ": is called by Options::cancelled"));
      CHECK(!fs::exists(file));
      called = nullptr;
      solver.run();
      CHECK(solver.summary().termination != Termination::running);
    }
    CHECK(capacity_error(solver.owners(), 100) == 0);
  }
}

TEST_CASE("solvers of ranks called by Options::cancelled are cancelled together, or refuse") {
  const Points<double> points = sample_uniform<double>(Box::unit(2), 8'000, 6);
  for (const bool cancels : {true, false}) {
    CAPTURE(cancels);
    std::mutex mutex;
    ThreadRanks(2).run([&](Ranks& ranks) {
      const Points<double> own = points.middleCols(4'000 * ranks.rank(), 4'000);
      Solver<double>* called = nullptr;
      Options options{.threads = 1};
      options.cancelled = [&] {
        if (cancels && ranks.rank() == 0) called->cancel();
        if (!cancels) static_cast<void>(called->owners());
        return false;
      };
      Solver<double> solver(Problem<double>(ranks, view_points(own), 40), options);
      called = &solver;
      const std::string message = message_of([&] { solver.run(); });
      const std::lock_guard lock(mutex);
      if (cancels) {
        CHECK(solver.summary().termination == Termination::cancelled);
      } else {
        CHECK(message.starts_with("Solver::owners: is called by Options::cancelled"));
      }
    });
  }
}

TEST_CASE("tessellate: too many points for a start of their own are dealt out near by") {
  // Cancelled at once: what must not take long is the join of 2^24 points and more.
  const Index sites = 2000;
  const auto points = sample_uniform<float, 2>(Box::unit(2), (1 << 24) + 4000, 1);
  Signal signal{milliseconds(0)};
  const auto result = tessellate(points, sites, {.cancelled = signal.callback()});
  CHECK(signal.late() < 60);  // 1 s, but for sanitizers and busy machines
  CHECK(result.summary.termination == Termination::cancelled);
  CHECK(capacity_error(result.owners, sites) < 1e-6);
  CHECK(std::count(result.owners.begin(), result.owners.end(), -1) == 0);
  CHECK(result.summary.normalized_energy < 50);  // random owners: 333
  REQUIRE(result.summary.warnings.size() == 1);
  CHECK(result.summary.warnings[0].find("of 16781216 went to sites that had room") !=
        std::string::npos);
}

TEST_CASE("tessellate: few points join, however soon a run ends") {
  const auto points = sample_uniform<float, 2>(Box::unit(2), 1000, 1);
  for (const Options& options : {Options{.threads = 1, .time_limit = 1e-9},
                                 Options{.threads = 1, .cancelled = [] { return true; }}}) {
    const auto result = tessellate(points, 50, options);
    CHECK(result.summary.warnings.empty());
    CHECK(result.summary.normalized_energy < 0.25);
    CHECK(result.summary.termination ==
          (options.cancelled ? Termination::cancelled : Termination::time_limit));
  }
}

TEST_CASE("codebooks: seeding, levels, pricing, the last assignment") {
  const auto vectors = make_points<float>(Layout::random, Box::unit(10), 60'000);
  const std::vector<Index> capacities = [] {
    std::vector<Index> result(3000, 20);
    result[0] = 10;
    result[1] = 30;
    return result;
  }();
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    for (const auto seeding : {Seeding::kmeans_plus_plus, Seeding::random}) {
      CAPTURE(to_string(method));
      const auto kept = method == CodebookMethod::lloyd ? std::vector<Index>() : capacities;
      check_heard([&](const auto& cancelled) {
        const auto training = train_codebook(
            vectors, 3000,
            {.method = method, .seeding = seeding, .capacities = kept, .cancelled = cancelled});
        REQUIRE(training.codes.size() == 60'000);
        CHECK(training.codebook.codewords().allFinite());
        if (method != CodebookMethod::lloyd) {
          std::vector<Index> sizes(3000, 0);
          for (const Index code : training.codes) ++sizes[static_cast<std::size_t>(code)];
          CHECK(sizes == capacities);
        }
        CHECK(training.summary.distortion > 0);
        CHECK(training.summary.gap <= 1);
        return training.summary.termination == Termination::cancelled;
      });
    }
  }
}

TEST_CASE("lloyd, encode, metrics, densities") {
  const auto points = make_points<float>(Layout::random, Box::unit(9), 100'000);
  check_heard([&](const auto& cancelled) {
    const auto result = lloyd(points, 2000, {.cancelled = cancelled});
    CHECK(std::count(result.owners.begin(), result.owners.end(), -1) == 0);
    return result.summary.termination == Termination::cancelled;
  });
  const Codebook codebook(make_points<double>(Layout::random, Box::unit(9), 5000));
  check_heard([&](const auto& cancelled) {
    return is_cancelled(
        [&] { static_cast<void>(codebook.encode(points, Coding::nearest, 0, cancelled)); });
  });
  for (const int dimension : {1, 2, 3, 5}) {
    const PointSet set(make_points<double>(Layout::random, Box::unit(dimension), 3000),
                       Domain::periodic(Box::unit(dimension)));
    for (const double highest : {2.0, 20.0}) {
      check_heard([&](const auto& cancelled) {
        return is_cancelled([&] {
          analyze({&set, 1}, {.max_frequency = highest, .cancelled = cancelled});
        });
      });
    }
  }
  std::vector<float> values(std::size_t{160} * 160 * 160, 1.0F);
  const DensityGrid grid{std::span<const float>(values), {160, 160, 160}, Box::unit(3)};
  for (const auto sampling : {DensitySampling::white, DensitySampling::stratified}) {
    check_heard([&](const auto& cancelled) {
      return is_cancelled(
          [&] { sample_density<float>(grid, 1'000'000, 1, sampling, 0, cancelled); });
    });
    check_heard([&](const auto& cancelled) {
      return is_cancelled([&] {
        sample_function<float>([](std::span<const double> x) { return x[0]; }, 1, Box::unit(3),
                               1'000'000, 1, sampling, 1, cancelled);
      });
    });
  }
  check_heard([&](const auto& cancelled) {
    bool ended = false;
    return is_cancelled([&] {
             VolumeOptions options;
             options.tessellation.cancelled = cancelled;
             const auto samples = sample_volume<float>(grid, 3000, options);
             for (const double radius : samples.radii) CHECK(std::isfinite(radius));
             ended = samples.summary.termination == Termination::cancelled;
           }) ||
           ended;
  });
}

TEST_CASE("an exception from the callback passes through joins and pricing") {
  const auto points = make_points<float>(Layout::random, Box::unit(3), 300'000);
  const auto due = Clock::now() + milliseconds(60);
  const auto angry = [due]() -> bool {
    if (Clock::now() > due) throw std::runtime_error("enough");
    return false;
  };
  CHECK_THROWS_WITH_AS(tessellate(points, 3000, {.cancelled = angry}), "enough",
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(train_codebook(points, 3000, {.cancelled = angry}), "enough",
                       std::runtime_error);
}

TEST_CASE("an arena asks on the thread that called, and stops all") {
  for (const int threads : {1, 2, 4}) {
    Signal signal{milliseconds(50)};
    Stop stop(signal.callback());
    const Arena arena(threads, &stop);
    CHECK_THROWS_AS(arena.for_each(100'000, 1,
                                   [](std::size_t) {
                                     std::this_thread::sleep_for(std::chrono::microseconds(500));
                                   }),
                    Stopped);
    CHECK(signal.late() < 2);
    CHECK(signal.elsewhere == 0);
    CHECK_THROWS_AS(arena.check(), Stopped);
    { const Stop::Pause pause(stop); }
    stop.off();
    CHECK_NOTHROW(arena.check());
    stop.allow(milliseconds(30));
    CHECK_NOTHROW(arena.check());
    std::this_thread::sleep_for(milliseconds(40));
    CHECK_THROWS_AS(arena.check(), Stopped);
  }
}

TEST_CASE("what had better be done to its end gets the time that it is given, and nothing else") {
  const auto ask = [](Stop& stop) {
    std::this_thread::sleep_for(milliseconds(21));  // longer than between two asks
    stop.check();
  };
  bool wanted = true;
  Stop stop([&] { return !wanted; });
  {
    const Stop::Patience patience(stop, std::chrono::hours(1));
    CHECK_NOTHROW(ask(stop));
    wanted = false;
    CHECK_NOTHROW(ask(stop));
    CHECK(stop.wished());
    CHECK_NOTHROW(ask(stop));
  }
  CHECK_THROWS_AS(ask(stop), Stopped);

  Stop unheard([] { return true; });
  {
    const Stop::Patience patience(unheard, milliseconds(30));
    CHECK_NOTHROW(unheard.check());
    CHECK_NOTHROW(unheard.check());
    std::this_thread::sleep_for(milliseconds(40));
    CHECK_THROWS_AS(ask(unheard), Stopped);
  }

  // To one who has waited before, no more is owed; and he may have been promised to wait.
  Stop patient([] { return true; });
  patient.be_patient(std::chrono::hours(1));
  CHECK(patient.wished());
  { const Stop::Patience patience(patient, std::chrono::hours(2)); }
  CHECK_NOTHROW(ask(patient));
}

TEST_SUITE_END();

}  // namespace
}  // namespace ccvt::test
