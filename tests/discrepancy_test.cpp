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
  for (const int dimension : {1, 2, 3, 5, 9}) {
    CAPTURE(dimension);
    Points<double> points = white(dimension, 700, 3).points();
    for (Eigen::Index p = 0; p < 700; p += 3) points(p % dimension, p) = 0.25;
    const PointSet set(points, Domain::euclidean(Box::unit(dimension)));
    double sum = 0;
    for (Eigen::Index a = 0; a < 700; ++a) {
      sum -= 1400 * ((1 - points.col(a).array().square()) / 2).prod();
      for (Eigen::Index b = 0; b < 700; ++b) {
        sum += (1 - points.col(a).array().max(points.col(b).array())).prod();
      }
    }
    const double square = std::pow(3.0, -dimension) + sum / 700 / 700;
    CHECK(star_discrepancy(set, 1) == doctest::Approx(std::sqrt(square)).epsilon(1e-9));
    for (const int threads : {2, 3})
      CHECK(star_discrepancy(set, threads) == star_discrepancy(set, 1));
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
