// First codewords, drawn in rounds.
#include "codebook/seeding.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <vector>

#include "ccvt/codebook.h"
#include "parallel/arena.h"
#include "support/generate.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Index;
using ccvt::plus_plus_in_rounds;
using ccvt::Points;
using ccvt::view_points;
using namespace ccvt::test;

namespace {

using Place = std::vector<float>;

std::vector<Place> places(const Points<float>& points) {
  std::vector<Place> all;
  for (Index p = 0; p < points.cols(); ++p) {
    all.emplace_back(points.col(p).begin(), points.col(p).end());
  }
  return all;
}

std::vector<Place> places(const std::vector<double>& sites, std::size_t dimension) {
  std::vector<Place> all;
  for (std::size_t k = 0; k < sites.size(); k += dimension) {
    const auto first = sites.begin() + static_cast<std::ptrdiff_t>(k);
    all.emplace_back(first, first + static_cast<std::ptrdiff_t>(dimension));
  }
  return all;
}

/// The sum of squared distances to the nearest site.
double energy(const Points<float>& points, const std::vector<double>& sites) {
  const Eigen::Map<const Eigen::MatrixXd> all(
      sites.data(), points.rows(), static_cast<Eigen::Index>(sites.size()) / points.rows());
  double sum = 0;
  for (Index p = 0; p < points.cols(); ++p) {
    sum += (all.colwise() - points.col(p).cast<double>()).colwise().squaredNorm().minCoeff();
  }
  return sum;
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("rounds draw as many distinct points as wanted") {
  const auto points = make_points<float>(Layout::random, uneven_box(11), 700);
  const auto all = places(points);
  const std::set<Place> known(all.begin(), all.end());
  for (const Index sites : {1, 2, 3, 200, 700}) {
    CAPTURE(sites);
    const auto drawn = places(plus_plus_in_rounds(view_points(points), sites, 5, 1), 11);
    CHECK(drawn.size() == static_cast<std::size_t>(sites));
    CHECK(std::set<Place>(drawn.begin(), drawn.end()).size() == drawn.size());
    CHECK(
        std::all_of(drawn.begin(), drawn.end(), [&](const Place& x) { return known.contains(x); }));
  }
}

TEST_CASE("where there are fewer places than sites, each place is drawn, and then any") {
  Points<float> points(9, 600);
  for (Index p = 0; p < points.cols(); ++p) points.col(p).setConstant(static_cast<float>(p % 7));
  const auto drawn = places(plus_plus_in_rounds(view_points(points), 300, 5, 1), 9);
  CHECK(drawn.size() == 300);
  CHECK(std::set<Place>(drawn.begin(), drawn.end()).size() == 7);
}

TEST_CASE("sites drawn by distance find clouds that random ones miss") {
  // 60 clouds of very different sizes: one has half of the points.
  Points<float> points = make_points<float>(Layout::random, Box::unit(10), 6000);
  for (Index p = 0; p < points.cols(); ++p) {
    const Index cloud = p % 2 == 0 ? 0 : 1 + p / 2 % 59;
    points(cloud % 10, p) += 20.0F * static_cast<float>(1 + cloud / 10);
  }
  double by_distance = 0;
  double by_chance = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    by_distance += energy(points, plus_plus_in_rounds(view_points(points), 150, seed, 1));
    std::vector<double> sites;
    for (const Index p : ccvt::draw_distinct(150, 6000, seed, 2)) {
      for (Index d = 0; d < 10; ++d) sites.push_back(points(d, p));
    }
    by_chance += energy(points, sites);
  }
  CHECK(by_distance < 0.5 * by_chance);
}

TEST_CASE("many codewords in many dimensions: same bits for any number of threads") {
  const auto points = make_points<float>(Layout::random, uneven_box(12), 1500);
  for (const auto method : {CodebookMethod::lloyd, CodebookMethod::exact}) {
    CodebookOptions options;
    options.method = method;
    options.threads = 1;
    const auto one = train_codebook(points, 150, options);
    for (const int threads : {2, 3, 8}) {
      options.threads = threads;
      const auto many = train_codebook(points, 150, options);
      CHECK(one.codes == many.codes);
      CHECK(one.codebook.codewords() == many.codebook.codewords());
    }
  }
}

TEST_SUITE_END();
