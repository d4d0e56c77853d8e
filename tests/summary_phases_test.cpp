// What a summary says of where time went.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

#include "ccvt/solver.h"
#include "support/files.h"
#include "support/generate.h"

using ccvt::Box;
using ccvt::Options;
using ccvt::Problem;
using ccvt::Solver;
using namespace ccvt::test;

TEST_SUITE_BEGIN("solver");

TEST_CASE("phases add up to the run, and on_loop tells of their loops") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 30000);
  // Another program may take the processor between two phases: the best of three runs counts.
  double largest_share = 0;
  for (int run = 0; run < 3; ++run) {
    std::int64_t loops = 0;
    std::int64_t tasks = 0;
    Options options{.threads = 2};
    options.on_loop = [&](const ccvt::LoopRecord& loop) {
      ++loops;
      tasks += std::ssize(loop.tasks);
      REQUIRE(loop.end >= loop.begin);
    };
    const auto result = ccvt::tessellate(points, 300, options);
    double seconds = 0;
    for (const auto& phase : result.summary.phases) {
      CAPTURE(phase.name);
      CHECK(phase.work_seconds <= 2 * phase.seconds + 1e-3);
      seconds += phase.seconds;
      loops -= phase.loops;
      tasks -= phase.tasks;
    }
    CHECK(loops == 0);
    CHECK(tasks == 0);
    CHECK(seconds <= result.summary.seconds_total);
    CHECK(result.summary.full().find("    swap") != std::string::npos);
    largest_share = std::max(largest_share, seconds / result.summary.seconds_total);
  }
  CHECK(largest_share >= 0.95);
}

TEST_CASE(
    "phases are no longer than the run, with callbacks between steps and after a checkpoint") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 30000);
  const TemporaryDirectory directory;
  Options options{.checkpoint = directory / "kept"};
  options.on_iteration = [](const ccvt::IterationRecord&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return true;
  };
  const auto seconds_of_phases = [](const ccvt::Summary& summary) {
    double seconds = 0;
    for (const auto& phase : summary.phases) seconds += phase.seconds;
    return seconds;
  };
  const Problem<float> problem(points, 300);
  { const Solver<float> begun(problem, options); }  // is kept at once
  for (int run = 0; run < 2; ++run) {
    Solver<float> solver(problem, options);
    solver.run();
    CHECK(solver.summary().seconds_total > 0);
    CHECK(seconds_of_phases(solver.summary()) <= solver.summary().seconds_total);
    options.checkpoint.clear();
  }
}

TEST_SUITE_END();
