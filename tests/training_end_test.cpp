#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/sampling.h"
#include "codebook/trainer.h"
#include "support/thread_ranks.h"

namespace ccvt::test {
namespace {

/// Energy less the dual objective, over the energy, by looking at all pairs; where all codewords
/// have the same capacity.
double gap_of(const Points<double>& points, const Training& training) {
  const auto& words = training.codebook.codewords();
  const auto& weights = training.codebook.weights();
  double energy = 0;
  double dual = 0;
  for (Index p = 0; p < points.cols(); ++p) {
    energy +=
        (points.col(p) - words.col(training.codes[static_cast<std::size_t>(p)])).squaredNorm();
    double least = std::numeric_limits<double>::infinity();
    for (Index s = 0; s < words.cols(); ++s) {
      least = std::min(least, (points.col(p) - words.col(s)).squaredNorm() - weights[s]);
    }
    dual += least;
  }
  const double capacity = static_cast<double>(points.cols()) / static_cast<double>(words.cols());
  for (Index s = 0; s < words.cols(); ++s) dual += capacity * weights[s];
  return (energy - dual) / energy;
}

}  // namespace

TEST_SUITE_BEGIN("training end");

TEST_CASE("without time for a last assignment, codes and weights are those of the one before") {
  const auto points = sample_uniform(Box::unit(3), 6000, 5, Distribution::white);
  const Columns<double> start(points.leftCols(60));
  double largest = 0;
  for (const int last_ask :
       {1, 3, 6, 10, 15}) {  // while centroids, or the seventh assignment, are found
    bool sixth = false;
    int asked = 0;
    CodebookOptions options{.effort = 0, .threads = 1};
    options.on_iteration = [&](const IterationRecord& record) {
      sixth = record.iteration == 6;
      return true;
    };
    options.cancelled = [&] {
      if (!sixth) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(21));  // asked again as soon as can be
      return ++asked > last_ask;
    };
    Trainer<double> trainer(Problem<double>(points, 60), options, kFewBytes,
                            std::chrono::milliseconds(0));
    const Training training = trainer.run(&start);
    const CodebookSummary& summary = training.summary;
    CHECK(summary.termination == Termination::cancelled);
    CHECK(summary.iterations == 6);
    CHECK(summary.usage.smallest == 100);
    CHECK(summary.usage.largest == 100);
    CHECK_FALSE(training.codebook.weights().isZero());
    CHECK(std::abs(summary.gap - gap_of(points, training)) < 1e-12);
    largest = std::max(largest, summary.gap);
    REQUIRE(summary.warnings.size() == 1);
    CHECK(summary.warnings[0].find("by the gap at most") != std::string::npos);
  }
  CHECK(largest > 0);
  CHECK(largest < 0.01);
}

TEST_CASE(
    "a step beyond centroids that was taken back is not what a cancelled training ends with") {
  const auto points = sample_uniform(Box::unit(2), 8000, 5, Distribution::white);
  const Columns<double> start(points.leftCols(40));
  for (int last = 3; last < 30; ++last) {
    CAPTURE(last);
    double energy = 0;
    int iteration = 0;
    int asked = 0;
    CodebookOptions options{.effort = 0, .threads = 1};
    options.on_iteration = [&](const IterationRecord& record) {
      iteration = record.iteration;
      energy = record.energy;
      return true;
    };
    options.cancelled = [&] {  // in the assignment that comes next
      if (iteration < last) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(21));
      return ++asked > 3;
    };
    Trainer<double> trainer(Problem<double>(points, 40), options, kFewBytes,
                            std::chrono::milliseconds(0));
    const CodebookSummary summary = trainer.run(&start).summary;
    CHECK(summary.energy <= energy * (1 + 1e-12));
    CHECK(summary.usage.smallest == 200);
    CHECK(summary.usage.largest == 200);
  }
}

TEST_CASE("lloyd that is cancelled in an iteration ends with the nearest codewords") {
  const auto points = sample_uniform<float>(Box::unit(8), 20'000, 5, Distribution::white);
  for (const int last_ask : {1, 2, 3, 5}) {
    int iteration = 0;
    int asked = 0;
    CodebookOptions options{.method = CodebookMethod::lloyd, .threads = 1};
    options.on_iteration = [&](const IterationRecord& record) {
      iteration = record.iteration;
      return true;
    };
    options.cancelled = [&] {
      if (iteration < 3) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(21));
      return ++asked > last_ask;
    };
    const Training training = train_codebook(points, 200, options);
    CHECK(training.summary.termination == Termination::cancelled);
    CHECK(training.codes == training.codebook.encode(points, Coding::nearest));
  }
}

TEST_CASE("breeding leaves most of the time that there is") {
  const auto points = sample_uniform<float>(Box::unit(4), 20'000, 5, Distribution::white);
  const CodebookOptions options{.effort = 1'000'000, .time_limit = 3, .threads = 1};
  const CodebookSummary summary = train_codebook(points, 20, options).summary;
  CHECK(summary.seconds_seeding < 2.5);
  CHECK(summary.iterations > 0);
}

TEST_CASE("training ends when its time is over, with capacities met") {
  const auto points = sample_uniform<float>(Box::unit(2), 20'000, 5, Distribution::white);
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    CAPTURE(to_string(method));
    const CodebookOptions soon{.method = method, .time_limit = 1e-9};
    const CodebookSummary ended = train_codebook(points, 100, soon).summary;
    CHECK(ended.termination == Termination::time_limit);
    if (method != CodebookMethod::lloyd) CHECK(ended.usage.smallest == 200);

    // Between two iterations, as they are long.
    CodebookOptions later{.method = method, .effort = 0, .time_limit = 0.3};
    later.on_iteration = [](const IterationRecord& record) {
      const auto start = std::chrono::steady_clock::now();
      while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(100)) {
      }
      return record.iteration < 10;
    };
    const CodebookSummary cut = train_codebook(points, 100, later).summary;
    CHECK(cut.termination == Termination::time_limit);
    CHECK(cut.iterations <= 3);
    if (method != CodebookMethod::lloyd) CHECK(cut.usage.smallest == 200);

    later.time_limit = 1e6;
    later.on_iteration = {};
    CHECK(train_codebook(points, 100, later).summary.termination == Termination::stable);
  }
}

TEST_CASE("ranks: the time of one ends training for all") {
  const auto points = sample_uniform<float>(Box::unit(2), 3000, 5, Distribution::white);
  for (const auto method : {CodebookMethod::exact, CodebookMethod::lloyd}) {
    ThreadRanks(3).run([&](Ranks& ranks) {
      CodebookOptions options{.method = method, .effort = 0, .threads = 1};
      if (ranks.rank() == 1) options.time_limit = 1e-9;
      const Points<float> own = points.middleCols(1000 * ranks.rank(), 1000);
      const CodebookSummary summary = train_codebook(ranks, view_points(own), 30, options).summary;
      CHECK(summary.termination == Termination::time_limit);
      CHECK(summary.iterations == 1);
      if (method == CodebookMethod::exact) CHECK(summary.usage.largest == 100);
    });
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
