// Steps of codewords beyond the centroids of their cells, beside steps to these.
#include "codebook/codeword_steps.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/codebook.h"
#include "cell_sizes.h"
#include "exact/assignment.h"
#include "exact/centroids.h"
#include "exact/grouping.h"
#include "random.h"

using ccvt::Arena;
using ccvt::CodewordSteps;
using ccvt::Domain;
using ccvt::ExactAssignment;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Points;
using ccvt::Random;

namespace {

Points<float> cloud(Index count, int dimension, std::uint64_t seed) {
  Random random(seed, 1);
  Points<float> points(dimension, count);
  for (Eigen::Index k = 0; k < points.size(); ++k) {
    double sum = 0;
    for (int part = 0; part < 6; ++part) sum += random.uniform();
    points.data()[k] = static_cast<float>(sum - 3);
  }
  return points;
}

struct Descended {
  int iterations = 0;
  double energy = 0;
  std::vector<double> energies;  ///< of the cells that were kept, at their own centroids
};

/// Exact assignments and steps in turn, until an assignment is optimal for its own centroids.
Descended descend(const Points<float>& points, Index sites, bool smooth) {
  const Arena arena(1);
  const Metric metric(static_cast<int>(points.rows()), Domain());
  const auto view = ccvt::view_points(points);
  const auto n = static_cast<std::size_t>(sites);
  std::vector<double> centroids(points.data(), points.data() + sites * points.rows());
  std::vector<double> weights(n, 0.0);
  std::vector<Index> owners = ccvt::nearest_owners(metric, view, centroids, arena);
  const std::vector<Index> capacities = ccvt::equal_capacities(view.count, sites);
  CodewordSteps steps(centroids, static_cast<std::size_t>(points.rows()), capacities, smooth,
                      arena);
  ExactAssignment<float> assignment(metric, view, sites, {}, arena);
  Descended result;
  bool assigned = false;
  for (; result.iterations < 5000; ++result.iterations) {
    std::vector<Index> given = owners;
    std::vector<double> weights_given = weights;
    const bool optimal = assignment.improve(steps.sites(), weights, owners) ==
                         ExactAssignment<float>::Round::optimal;
    result.energy = assignment.last().energy - steps.excess();
    if (assigned) result.energies.push_back(result.energy);
    if (assigned && optimal && steps.at_centroids()) break;
    ccvt::move_to_centroids(metric, view, ccvt::Grouping(owners, n), arena, centroids);
    if (!steps.advance(centroids, ccvt::cell_sizes(owners, n), assigned && optimal)) {
      owners = std::move(given);
      weights = std::move(weights_given);
      CHECK(steps.at_centroids());
      CHECK(steps.sites() == centroids);
    }
    assigned = true;
  }
  return result;
}

}  // namespace

TEST_SUITE("codeword_steps") {
  TEST_CASE("steps beyond centroids take fewer iterations, and the energy never rises") {
    int plain_iterations = 0;
    int iterations = 0;
    double plain_energy = 0;
    double energy = 0;
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      for (const int dimension : {2, 3}) {
        CAPTURE(seed);
        const Points<float> points = cloud(20011, dimension, seed);  // capacities float
        const Descended plain = descend(points, 12, false);
        const Descended smooth = descend(points, 12, true);
        for (const Descended& one : {plain, smooth}) {
          for (std::size_t k = 1; k < one.energies.size(); ++k) {
            CHECK(one.energies[k] <= one.energies[k - 1] * (1 + 1e-12));
          }
        }
        plain_iterations += plain.iterations;
        iterations += smooth.iterations;
        plain_energy += plain.energy;
        energy += smooth.energy;
      }
    }
    MESSAGE("iterations " << iterations << ", to centroids " << plain_iterations << "; energy "
                          << energy << ", " << plain_energy);
    CHECK(iterations < plain_iterations / 2);
    CHECK(energy < 1.005 * plain_energy);
  }

  TEST_CASE("a step that does not lower the energy is taken back") {
    const Arena arena(1);
    const std::vector<Index> capacities = {3, 3};
    std::vector<double> centroids = {-1, 1};
    CodewordSteps steps(centroids, 1, capacities, true, arena);
    const std::vector<double>& sites = steps.sites();
    const auto advance = [&](double a, double b, bool rests = false) {
      centroids = {a, b};
      return steps.advance(centroids, capacities, rests);
    };
    // Centroids move by half as much each time: the way is twice as long as the first step.
    REQUIRE(advance(-1.5, 1.5));
    CHECK(steps.at_centroids());
    CHECK(steps.excess() == 0);
    REQUIRE(advance(-1.75, 1.75));
    CHECK_FALSE(steps.at_centroids());
    CHECK(sites[0] == doctest::Approx(-2));
    CHECK(sites[1] == doctest::Approx(2));
    CHECK(steps.excess() == doctest::Approx(6 * .25 * .25));
    // What is assigned there has its centroids nearer to each other than before.
    CHECK_FALSE(advance(-1.7, 1.7));
    CHECK(sites == std::vector<double>{-1.75, 1.75});
    CHECK(steps.at_centroids());
    CHECK(centroids == sites);
    // From there to centroids, until steps tell a direction again.
    REQUIRE(advance(-1.875, 1.875));
    CHECK(steps.at_centroids());
    REQUIRE(advance(-1.9375, 1.9375));
    CHECK_FALSE(steps.at_centroids());
    CHECK(sites[1] == doctest::Approx(2));
    REQUIRE(advance(-2, 2, true));
    CHECK(sites == std::vector<double>{-2, 2});
    CHECK(steps.at_centroids());
  }

  TEST_CASE("with many vectors a codeword a training is stable, optimal, and at its centroids") {
    const Points<float> points = cloud(4000, 2, 5);
    ccvt::CodebookOptions options;
    options.restarts = 1;
    std::vector<double> energies;
    options.on_iteration = [&](const ccvt::IterationRecord& record) {
      if (record.points == 4000) energies.push_back(record.energy);
      return true;
    };
    const auto trained = ccvt::train_codebook(points, 10, options);
    CHECK(trained.summary.termination == ccvt::Termination::stable);
    CHECK(std::abs(trained.summary.gap) < 1e-12);
    for (std::size_t k = 2; k < energies.size(); ++k) {
      CHECK(energies[k] <= energies[k - 1] * (1 + 1e-12));
    }
    const auto codewords = trained.codebook.codewords();
    std::vector<double> sites(codewords.data(), codewords.data() + codewords.size());
    const std::vector<double> before = sites;
    ccvt::move_to_centroids(Metric(2, Domain()), ccvt::view_points(points),
                            ccvt::Grouping(trained.codes, 10), Arena(1), sites);
    for (std::size_t k = 0; k < sites.size(); ++k) CHECK(sites[k] == doctest::Approx(before[k]));
  }

  TEST_CASE("codebooks of large cells are the same for any number of threads, and optimal") {
    for (const int dimension : {2, 12}) {
      CAPTURE(dimension);
      const Points<float> points = cloud(70000, dimension, 9);
      ccvt::CodebookOptions options;
      options.restarts = 1;
      options.effort = 0;
      options.max_iterations = 60;
      const auto train = [&](int threads) {
        options.threads = threads;
        return ccvt::train_codebook(points, 3, options);
      };
      const auto one = train(1);
      CHECK(std::abs(one.summary.gap) < 1e-12);
      for (const int threads : {2, 3}) {
        const auto more = train(threads);
        CHECK(more.codes == one.codes);
        CHECK(more.codebook.codewords() == one.codebook.codewords());
        CHECK(more.summary.iterations == one.summary.iterations);
      }
    }
  }
}
