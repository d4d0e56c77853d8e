// Clouds with strays, with many points in one place, and at the end of what numbers bear.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

#include "ccvt/thin.h"
#include "parallel/arena.h"
#include "random.h"
#include "support/message.h"
#include "support/processor_time.h"
#include "thin/owners.h"

namespace ccvt::test {
namespace {

/// Evenly dense, but for chance, on the unit sphere; normals are the same.
Points<double> sphere(Index count) {
  Random random(3);
  Points<double> points(3, count);
  for (Index p = 0; p < count; ++p) {
    const double z = 2 * random.uniform() - 1;
    const double turn = 8 * std::atan(1.0) * random.uniform();
    const double r = std::sqrt(1 - z * z);
    points.col(p) << r * std::cos(turn), r * std::sin(turn), z;
  }
  return points;
}

/// Of so many points on the unit sphere, packed hexagonally.
double packed(Index count) { return std::sqrt(32 * std::atan(1.0) / (std::sqrt(3.0) * count)); }

double spacing_of(const Points<double>& points, Index sites) {
  ThinOptions options;
  options.tessellation.max_iterations = 1;
  options.spread = false;
  return thin(points, sites, options).spacing;
}

}  // namespace

TEST_SUITE_BEGIN("thin");

TEST_CASE("strays and points in one place do not change the spacing") {
  Points<double> points = sphere(6000);
  CHECK(spacing_of(points, 3000) / packed(3000) == doctest::Approx(1).epsilon(0.1));
  points.leftCols(12) *= 1e6;
  CHECK(spacing_of(points, 3000) / packed(3000) == doctest::Approx(1).epsilon(0.1));
  points.leftCols(4000).setZero();  // what a scanner writes where it has seen nothing
  CHECK(spacing_of(points, 3000) / packed(1000) == doctest::Approx(1).epsilon(0.1));
  points.setZero();
  CHECK(spacing_of(points, 3000) == 0);
}

TEST_CASE("owners are found soon where many chosen points are in one place") {
  Points<float> points = Points<float>::Zero(3, 80000);
  points.rightCols(1000).setRandom();
  std::vector<Index> chosen(40000);
  std::iota(chosen.begin(), chosen.end(), 0);
  const double start = processor_seconds();
  const auto owners = nearest_chosen(view_points(points), chosen, Arena(1));
  CHECK(processor_seconds() - start < 1);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    CHECK(owners[p] < 40000);
    if (p < 40000) CHECK(owners[p] == static_cast<Index>(p));
  }
}

TEST_CASE("choices in the same places are told") {
  Points<double> points = sphere(100);
  const auto warnings_of = [&] { return thin(points, 50, {}).summary.warnings; };
  CHECK(warnings_of().empty());
  points.leftCols(70).colwise() = points.col(0).eval();
  const auto warnings = warnings_of();
  REQUIRE(warnings.size() == 1);
  // There are 31 places.
  CHECK(
      warnings[0].ends_with(" of the 50 points chosen lie where another one does: many points are "
                            "in the same places"));
  CHECK(std::stoi(warnings[0]) >= 19);
}

TEST_CASE("normals that are too long are refused by their weight") {
  Points<double> points = sphere(100);
  const Points<double> normals = points;
  points *= 0.9e140;
  ThinOptions options;
  options.normal_weight = 100;
  const auto message = message_of([&] { thin(points, 10, options, normals); });
  CAPTURE(message);
  CHECK(message.find("normal_weight: is 100, for points that are ") == 0);
  CHECK(message.find("e+139 apart; the product must be at most 1e+140") != std::string::npos);
  options.normal_weight = 0.01;
  CHECK(message_of([&] { thin(points, 10, options, normals); }) == "nothing thrown");
}

TEST_SUITE_END();

}  // namespace ccvt::test
