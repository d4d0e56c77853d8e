#include "ccvt/sampling.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "sampling/strata.h"

using ccvt::Box;
using ccvt::Distribution;
using ccvt::Index;
using ccvt::InvalidInput;
using ccvt::sample_uniform;

namespace {

constexpr Distribution all_distributions[] = {Distribution::white, Distribution::jittered,
                                              Distribution::square, Distribution::hexagonal};

// A box away from the origin whose sides differ.
Box uneven_box(int dimension) {
  Box box = Box::unit(dimension);
  for (int d = 0; d < dimension; ++d) {
    box.lower[d] = -3 + d;
    box.upper[d] = box.lower[d] + 0.7 + 0.9 * (d % 3);
  }
  return box;
}

template <class Matrix>
bool inside(const Matrix& points, const Box& box) {
  const Eigen::MatrixXd p = points.template cast<double>();
  return ((p.colwise() - box.lower.eigen()).array() >= 0).all() &&
         ((p.colwise() - box.upper.eigen()).array() < 0).all();
}

template <class Matrix>
bool same_bytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(a(0, 0)) * static_cast<std::size_t>(a.size())) == 0;
}

// The message that refuses a call, or "" when it is not refused.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

// The variance of the number of points in random boxes of the unit cube, over that of independent
// points: 1 for white noise.
double relative_count_variance(Distribution distribution, int dimension, Index count) {
  double squared = 0;
  double expected = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto points = sample_uniform<double>(Box::unit(dimension), count, seed, distribution);
    const auto corners = sample_uniform<double>(Box::unit(dimension), 10, seed + 1000);
    for (int k = 0; k < 10; ++k) {
      const Eigen::VectorXd lower = 0.4 * corners.col(k);
      const Eigen::VectorXd upper = lower.array() + 0.55;
      const auto in =
          (points.colwise() - lower).array() >= 0 && (points.colwise() - upper).array() < 0;
      const auto found = static_cast<double>(in.colwise().all().count());
      const double p = std::pow(0.55, dimension);
      squared += (found - p * count) * (found - p * count);
      expected += p * (1 - p) * count;
    }
  }
  return squared / expected;
}

double smallest_distance_on_torus(const Eigen::MatrixXd& points, const Eigen::VectorXd& extent) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index a = 0; a < points.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      const Eigen::ArrayXd d = (points.col(a) - points.col(b)).array().abs();
      smallest = std::min(smallest, d.min(extent.array() - d).matrix().norm());
    }
  }
  return smallest;
}

}  // namespace

TEST_SUITE_BEGIN("sampling");

TEST_CASE_TEMPLATE("any count in any dimension, inside the box", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 4, 5, 8, 17, 64, 130}) {
    const Box box = uneven_box(dimension);
    for (const Index count : {1, 2, 3, 5, 7, 8, 64, 97, 1000, 4096, 5003}) {
      for (const Distribution distribution : all_distributions) {
        CAPTURE(dimension);
        CAPTURE(count);
        const auto points = sample_uniform<Scalar>(box, count, 3, distribution);
        CHECK(points.rows() == dimension);
        CHECK(points.cols() == count);
        CHECK(inside(points, box));
      }
    }
  }
}

TEST_CASE("strata: every cell once, of equal volume, without overlap, in any part of the range") {
  for (const int dimension : {1, 2, 3, 5, 9}) {
    const Box box = uneven_box(dimension);
    for (const Index count : {1, 2, 3, 7, 12, 35, 97, 257}) {
      const ccvt::Strata strata(box.extent(), count);
      Eigen::MatrixXd lower(dimension, count);
      Eigen::MatrixXd upper(dimension, count);
      std::vector<int> seen(static_cast<std::size_t>(count));
      for (Index first = 0; first < count; first += 10) {
        strata.visit(
            box.lower, first, std::min(first + 10, count),
            [&](std::int64_t cell, std::span<const double> corner, std::span<const double> size) {
              ++seen[static_cast<std::size_t>(cell)];
              for (int d = 0; d < dimension; ++d) {
                const auto e = static_cast<std::size_t>(d);
                lower(d, cell) = corner[e];
                upper(d, cell) = corner[e] + size[e];
              }
            });
      }
      CAPTURE(dimension);
      CAPTURE(count);
      CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
      const double share = box.volume() / count;
      const double slack = 1e-12;
      CHECK(((upper - lower).colwise().prod().array() - share).abs().maxCoeff() <
            slack * share * 10);
      // Equal volumes that sum to the box, inside it and disjoint: they fill it.
      CHECK(((lower.colwise() - box.lower.eigen()).array() >= -slack).all());
      CHECK(((upper.colwise() - box.upper.eigen()).array() <= slack).all());
      int overlaps = 0;
      for (Index a = 0; a < count; ++a) {
        for (Index b = 0; b < a; ++b) {
          const auto common = lower.col(a).array().max(lower.col(b).array()) + slack <
                              upper.col(a).array().min(upper.col(b).array());
          overlaps += common.all() ? 1 : 0;
        }
      }
      CHECK(overlaps == 0);
    }
  }
}

TEST_CASE("strata are nearly cubic") {
  const auto worst_ratio = [](const Eigen::VectorXd& extent, Index count) {
    double worst = 1;
    const ccvt::Strata strata(extent, count);
    strata.visit(Eigen::VectorXd::Zero(extent.size()), 0, count,
                 [&](std::int64_t, std::span<const double>, std::span<const double> size) {
                   const auto [least, most] = std::minmax_element(size.begin(), size.end());
                   worst = std::max(worst, *most / *least);
                 });
    return worst;
  };
  for (Index count = 1; count <= 3000; ++count) {
    CAPTURE(count);
    const double square = worst_ratio(Eigen::Vector2d(1, 1), count);
    CHECK(square <= (count < 8 ? 3 : 2) + 1e-9);
    CHECK(worst_ratio(Eigen::Vector3d(1, 1, 1), count) <= 3 + 1e-9);
    // A long box once there are enough points to cut its short side.
    if (count >= 80) CHECK(worst_ratio(Eigen::Vector2d(10, 1), count) <= 2 + 1e-9);
  }
  for (const Index side : {2, 3, 10, 33}) {
    CHECK(worst_ratio(Eigen::Vector2d(1, 1), side * side) == doctest::Approx(1));
    CHECK(worst_ratio(Eigen::Vector3d(2, 2, 2), side * side * side) == doctest::Approx(1));
  }
}

TEST_CASE("jittered: exactly one point in each stratum") {
  for (const int dimension : {1, 2, 3, 6}) {
    const Box box = uneven_box(dimension);
    for (const Index count : {1, 6, 97, 1024, 5000}) {
      const auto points = sample_uniform<double>(box, count, 5);
      const ccvt::Strata strata(box.extent(), count);
      int outside = 0;
      strata.visit(
          box.lower, 0, count,
          [&](std::int64_t p, std::span<const double> corner, std::span<const double> size) {
            for (int d = 0; d < dimension; ++d) {
              const auto e = static_cast<std::size_t>(d);
              const double x = points(d, p) - corner[e];
              outside += x < -1e-12 || x > size[e] + 1e-12 ? 1 : 0;
            }
          });
      CHECK(outside == 0);
    }
  }
}

TEST_CASE("jittered: in a square of k^2 points, one in each cell of the k by k grid") {
  constexpr int k = 37;
  const auto points = sample_uniform<float, 2>(Box::unit(2), k * k, 9);
  std::vector<int> found(k * k);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Eigen::Array2i cell = (points.col(p).cast<double>() * k).array().floor().cast<int>();
    ++found[static_cast<std::size_t>(cell[1] * k + cell[0])];
  }
  CHECK(std::all_of(found.begin(), found.end(), [](int n) { return n == 1; }));
}

TEST_CASE("jittered points are uniform in their cells, white ones in the box") {
  // The mean over all points of (x - corner) / side is 1/2, its variance 1/12, without correlation.
  constexpr int k = 100;
  for (const Distribution distribution : {Distribution::jittered, Distribution::white}) {
    const double scale = distribution == Distribution::jittered ? k : 1;
    const auto points = sample_uniform<double, 2>(Box::unit(2), k * k, 4, distribution);
    const Eigen::Array2Xd scaled = points.array() * scale;
    const Eigen::Array2Xd centred = scaled - scaled.floor() - 0.5;
    const double sigma = std::sqrt(1.0 / 12) / k;
    CHECK(std::abs(centred.row(0).mean()) < 4 * sigma);
    CHECK(std::abs(centred.row(1).mean()) < 4 * sigma);
    CHECK(std::abs(centred.square().mean() - 1.0 / 12) < 4 * std::sqrt(1.0 / 180 / 2) / k);
    CHECK(std::abs((centred.row(0) * centred.row(1)).mean()) < 4.0 / 12 / k);
  }
}

TEST_CASE("counts in boxes vary far less for jittered points than for white ones") {
  for (const int dimension : {1, 2, 3}) {
    for (const Index count : {1000, 1021}) {
      CAPTURE(dimension);
      CAPTURE(count);
      const double white = relative_count_variance(Distribution::white, dimension, count);
      const double jittered = relative_count_variance(Distribution::jittered, dimension, count);
      CHECK(white > 0.7);
      CHECK(white < 1.4);
      // About (surface cells) / 6 over p (1 - p) count.
      CHECK(jittered < (dimension == 1 ? 0.01 : dimension == 2 ? 0.06 : 0.25));
      CHECK(jittered > 0);
    }
  }
}

TEST_CASE("square: the centres of an exact grid where there is one") {
  const Box box{Eigen::Vector2d(1, -1), Eigen::Vector2d(4, 1)};
  const auto points = sample_uniform<double, 2>(box, 6, 0, Distribution::square);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const Eigen::Vector2d centre(1.5 + x, -0.5 + y);
      CHECK((points.colwise() - centre).colwise().norm().minCoeff() < 1e-12);
    }
  }
  // 35 = 5 x 7, though six rows would be a little nearer to squares.
  const auto grid = sample_uniform<double, 2>(Box::unit(2), 35, 0, Distribution::square);
  CHECK(smallest_distance_on_torus(grid, Eigen::Vector2d(1, 1)) == doctest::Approx(1.0 / 7));
}

TEST_CASE("hexagonal: six neighbours at one distance in 2D, eight in 3D") {
  // 8 columns and 8 rows on a torus of the lattice's own proportions.
  const Box flat{Eigen::Vector2d(0, 0), Eigen::Vector2d(8, 8 * std::sqrt(0.75))};
  const Box cube{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(4, 4, 4)};
  for (const Box& box : {flat, cube}) {
    const Index count = box.dimension() == 2 ? 64 : 128;
    const double spacing = box.dimension() == 2 ? 1 : std::sqrt(0.75);
    const Eigen::MatrixXd points = sample_uniform<double>(box, count, 0, Distribution::hexagonal);
    CHECK(smallest_distance_on_torus(points, box.extent()) == doctest::Approx(spacing));
    int neighbours = 0;
    for (Index a = 0; a < count; ++a) {
      for (Index b = 0; b < count; ++b) {
        const Eigen::ArrayXd d = (points.col(a) - points.col(b)).array().abs();
        const double distance = d.min(box.extent().array() - d).matrix().norm();
        neighbours += a != b && distance < spacing * 1.001 ? 1 : 0;
      }
    }
    CHECK(neighbours == count * (box.dimension() == 2 ? 6 : 8));
  }
}

TEST_CASE("grids of awkward counts leave no part of the box empty and no two points close") {
  for (const int dimension : {2, 3}) {
    const auto probes = sample_uniform<double>(Box::unit(dimension), 3000, 1);
    for (Index count = 20; count < 160; ++count) {
      const double spacing = std::pow(count, -1.0 / dimension);
      for (const Distribution distribution : {Distribution::square, Distribution::hexagonal}) {
        CAPTURE(dimension);
        CAPTURE(count);
        const Eigen::MatrixXd points =
            sample_uniform<double>(Box::unit(dimension), count, 0, distribution);
        double gap = 0;
        for (Eigen::Index q = 0; q < probes.cols(); ++q) {
          gap = std::max(gap, (points.colwise() - probes.col(q)).colwise().norm().minCoeff());
        }
        CHECK(gap < 1.5 * spacing);
        const Eigen::VectorXd far = Eigen::VectorXd::Constant(dimension, 1e9);
        CHECK(smallest_distance_on_torus(points, far) > 0.4 * spacing);
      }
    }
  }
}

TEST_CASE("fixed and dynamic dimension, and one seed, give the same bytes; another does not") {
  for (const Distribution distribution : {Distribution::white, Distribution::jittered}) {
    const Box box = uneven_box(3);
    const auto dynamic = sample_uniform<float>(box, 10007, 1, distribution);
    const Eigen::MatrixXf fixed = sample_uniform<float, 3>(box, 10007, 1, distribution);
    CHECK(same_bytes<Eigen::MatrixXf>(dynamic, fixed));
    const auto other = sample_uniform<float>(box, 10007, 2, distribution);
    CHECK((dynamic.array() == other.array()).count() < 100);
    const auto row = sample_uniform<double, 1>(Box::unit(1), 5, 1, distribution);
    CHECK(row.cols() == 5);
  }
}

TEST_CASE("float coordinates stay in the box where rounding would leave it") {
  // Between these bounds there are only eight floats, and neither bound is one of them.
  Box box = Box::unit(2);
  box.lower.eigen().setConstant(1 + 0.3 * 0x1p-23);
  box.upper.eigen().setConstant(1 + 8.6 * 0x1p-23);
  for (const Distribution distribution : all_distributions) {
    const auto points = sample_uniform<float, 2>(box, 1000, 1, distribution);
    CHECK(inside(points, box));
    CHECK(points.maxCoeff() == 1 + 8 * 0x1p-23F);
  }
  // The upper bound is a float, to which values just below it would round.
  box.lower.eigen().setConstant(0);
  box.upper.eigen().setConstant(1);
  CHECK(sample_uniform<float, 2>(box, 1 << 25, 1, Distribution::white).maxCoeff() < 1);
}

TEST_CASE("refused inputs name what is wrong") {
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  const auto box = [](double lower, double upper) {
    return Box{Eigen::Vector2d(0, lower), Eigen::Vector2d(1, upper)};
  };
  const auto message = [](const Box& b, Index count = 10) {
    return refusal([&] { sample_uniform<float>(b, count); });
  };
  const auto mentions = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(message(box(0, 1)).empty());
  CHECK(mentions(message(box(0, 1), 0), "count: is 0"));
  CHECK(mentions(message(box(0, 1), -7), "count: is -7"));
  CHECK(mentions(message(box(nan, 1)), "lower[1] is nan"));
  CHECK(mentions(message(box(0, INFINITY)), "upper[1] is inf"));
  CHECK(mentions(message(box(2, 2)), "lower[1] is 2 and upper[1] is 2"));
  CHECK(mentions(message(box(0, 1e39)), "upper[1] is 1e+39"));
  CHECK(mentions(message(box(1 + 1e-12, 1 + 1e-10)), "no number of type float"));
  CHECK(mentions(message(Box::unit(0)), "0 dimensions"));
  CHECK(mentions(message({Eigen::Vector2d(0, 0), Eigen::Vector3d(1, 1, 1)}), "lower has 2"));
  const std::string other = refusal([] { sample_uniform<double, 2>(Box::unit(3), 10); });
  CHECK(mentions(other, "box: has 3 dimensions, but points of 2"));
  const Box widest{Eigen::Vector2d(0, -1.7e308), Eigen::Vector2d(1, 1.7e308)};
  const std::string extent = refusal([&] { sample_uniform<double>(widest, 10); });
  CHECK(mentions(extent, "extent must be finite"));
}

TEST_SUITE_END();
