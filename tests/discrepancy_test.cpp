#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ccvt/metrics.h"
#include "support/lattices.h"

namespace ccvt::test {

TEST_SUITE_BEGIN("metrics");

TEST_CASE("star discrepancy is the integral that defines it") {
  for (const Index count : {2, 7, 30}) {
    const PointSet set = white(2, count, 8);
    // Between the sorted coordinates the number of points in a box is constant.
    std::vector<double> cuts[2];
    for (int d = 0; d < 2; ++d) {
      cuts[d] = {0, 1};
      for (Eigen::Index p = 0; p < count; ++p) cuts[d].push_back(set.points()(d, p));
      std::sort(cuts[d].begin(), cuts[d].end());
    }
    double integral = 0;
    for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i) {
      for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j) {
        const auto inside = (set.points().row(0).array() <= cuts[0][i]) &&
                            (set.points().row(1).array() <= cuts[1][j]);
        const double share = static_cast<double>(inside.count()) / count;
        const auto moment = [&](int d, std::size_t k, int power) {
          return (std::pow(cuts[d][k + 1], power) - std::pow(cuts[d][k], power)) / power;
        };
        integral += share * share * moment(0, i, 1) * moment(1, j, 1) -
                    2 * share * moment(0, i, 2) * moment(1, j, 2) +
                    moment(0, i, 3) * moment(1, j, 3);
      }
    }
    CHECK(star_discrepancy(set, 2) == doctest::Approx(std::sqrt(integral)).epsilon(1e-10));
  }
  // White noise: the mean square is (2^-D - 3^-D) / n.
  double square = 0;
  for (std::uint64_t s = 1; s <= 40; ++s) {
    square += std::pow(star_discrepancy(white(3, 100, s)), 2) / 40;
  }
  CHECK(square == doctest::Approx((1.0 / 8 - 1.0 / 27) / 100).epsilon(0.25));
}

TEST_CASE("star discrepancy is that of the sum over all pairs, one by one") {
  struct Size {
    int dimension;
    Index count;
  };
  // Up to four dimensions so many that the sum is divided; then it is not.
  for (const Size size : {Size{1, 700}, {2, 700}, {3, 3000}, {4, 6000}, {9, 700}}) {
    const int dimension = size.dimension;
    const Index count = size.count;
    CAPTURE(dimension);
    Points<double> points = white(dimension, count, 3).points();
    for (Eigen::Index p = 0; p < count; p += 3) points(p % dimension, p) = 0.25;  // some are equal
    const PointSet set(points, Domain::euclidean(Box::unit(dimension)));
    const double n = count;
    double sum = 0;
    for (Eigen::Index a = 0; a < count; ++a) {
      sum -= 2 * n * ((1 - points.col(a).array().square()) / 2).prod();
      for (Eigen::Index b = 0; b <= a; ++b) {
        double product = b < a ? 2 : 1;
        for (int d = 0; d < dimension; ++d) product *= 1 - std::max(points(d, a), points(d, b));
        sum += product;
      }
    }
    const double square = std::pow(3.0, -dimension) + sum / n / n;
    const double found = star_discrepancy(set, 1);
    CHECK(found == doctest::Approx(std::sqrt(square)).epsilon(1e-8));
    for (const int threads : {2, 3}) CHECK(star_discrepancy(set, threads) == found);
  }
}

TEST_CASE("star discrepancy of many even points does not drown in rounding") {
  constexpr Index kCount = 200'000;
  Points<double> points(1, kCount);
  for (Index p = 0; p < kCount; ++p) points(0, p) = (p + 0.5) / kCount;
  const PointSet set(points, Domain::euclidean(Box::unit(1)));
  CHECK(star_discrepancy(set) == doctest::Approx(1 / std::sqrt(12.0) / kCount).epsilon(1e-3));
}

TEST_SUITE_END();

}  // namespace ccvt::test
