// The loops over positions and scattered points, against the same sums and comparisons one by one.
#include <doctest/doctest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/build_info.h"
#include "geometry/metric.h"
#include "geometry/squares.h"
#include "kernels/about.h"
#include "kernels/nearest.h"
#include "kernels/products.h"
#include "kernels/rows.h"
#include "random.h"
#include "support/baseline.h"
#include "support/generate.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Random;
using ccvt::squared_difference;
using namespace ccvt::test;

TEST_SUITE_BEGIN("kernels");

TEST_CASE("the nearest of positions, also on a torus, and for many points") {
  for (const int dimension : {1, 2, 3, 7, 8, 9, 24, 50}) {
    const Box box = uneven_box(dimension);
    const Metric plain(dimension, Domain());
    const Metric torus(dimension, Domain::periodic(box));
    for (const Index count : {1, 2, 5, 40}) {
      CAPTURE(dimension);
      CAPTURE(count);
      const auto positions = make_points<double>(Layout::duplicates, box, count, 3);
      const auto queries = make_points<double>(Layout::random, box, 32, 4);
      std::vector<double> streams(static_cast<std::size_t>(queries.size()));
      for (Index q = 0; q < 32; ++q) {
        for (int d = 0; d < dimension; ++d) {
          streams[static_cast<std::size_t>(d * 32 + q)] = queries(d, q);
        }
      }
      std::vector<std::int32_t> chosen(32, -1);
      if (dimension == 2 || dimension == 3) {
        ccvt::kernels::nearest_positions(streams.data(), 32, dimension, positions.data(), count,
                                         chosen.data());
      }
      for (Index q = 0; q < 32; ++q) {
        const double* query = queries.col(q).data();
        for (const Metric* metric : {&plain, &torus}) {
          Index nearest = 0;
          for (Index k = 1; k < count; ++k) {
            if (metric->squared_distance(query, positions.col(k).data()) <
                metric->squared_distance(query, positions.col(nearest).data())) {
              nearest = k;
            }
          }
          const double best = metric->squared_distance(query, positions.col(nearest).data());
          const Index found =
              ccvt::kernels::nearest_position(query, positions.data(), count, dimension,
                                              metric->periodic() ? metric->extent() : nullptr);
          REQUIRE((found >= 0 && found < count));
          CHECK(metric->squared_distance(query, positions.col(found).data()) ==
                doctest::Approx(best).epsilon(1e-14));
          if (metric == &plain && chosen[0] >= 0) {
            CHECK(chosen[static_cast<std::size_t>(q)] == nearest);  // the first of several
          }
        }
      }
    }
  }
}

TEST_CASE("squared distances to packs of positions, also on a torus") {
  using ccvt::kernels::kPack;
  for (const int dimension : {1, 2, 3, 7, 24}) {
    const Box box = uneven_box(dimension);
    for (const Metric& metric :
         {Metric(dimension, Domain()), Metric(dimension, Domain::periodic(box))}) {
      CAPTURE(dimension);
      CAPTURE(metric.periodic());
      const auto positions = make_points<double>(Layout::random, box, 3 * kPack, 3);
      const auto queries = make_points<double>(Layout::random, box, 5, 4);
      std::vector<double> packs;
      for (Index pack = 0; pack < 3; ++pack) {
        for (int d = 0; d < dimension; ++d) {
          for (Index k = 0; k < kPack; ++k) packs.push_back(positions(d, pack * kPack + k));
        }
      }
      for (Index q = 0; q < queries.cols(); ++q) {
        const double* query = queries.col(q).data();
        std::vector<double> squared(3 * kPack, -1);
        ccvt::kernels::squared_distances(query, packs.data(), 3, dimension,
                                         metric.periodic() ? metric.extent() : nullptr,
                                         squared.data());
        for (Index k = 0; k < positions.cols(); ++k) {
          const double expected = metric.squared_distance(query, positions.col(k).data());
          CHECK(squared[static_cast<std::size_t>(k)] == doctest::Approx(expected).epsilon(1e-14));
        }
      }
    }
  }
}

TEST_CASE("squared distances of several positions to packs are bit for bit those of each") {
  using ccvt::kernels::kPack;
  using ccvt::kernels::squared_distances;
  for (const int dimension : {1, 2, 7, 24}) {
    const Box box = uneven_box(dimension);
    for (const Metric& metric :
         {Metric(dimension, Domain()), Metric(dimension, Domain::periodic(box))}) {
      CAPTURE(dimension);
      CAPTURE(metric.periodic());
      const double* const extent = metric.periodic() ? metric.extent() : nullptr;
      const auto packs = make_points<double>(Layout::random, box, 3 * kPack, 3);
      const auto queries = make_points<double>(Layout::random, box, 9, 4);
      for (Index count = 0; count <= queries.cols(); ++count) {
        CAPTURE(count);
        std::vector<std::vector<double>> squared(10, std::vector<double>(3 * kPack, -1));
        std::vector<const double*> query;
        std::vector<double*> out;
        for (Index q = 0; q < count; ++q) {
          query.push_back(queries.col(q).data());
          out.push_back(squared[static_cast<std::size_t>(q)].data());
        }
        squared_distances(query.data(), count, packs.data(), 3, dimension, extent, out.data());
        for (Index q = 0; q < count; ++q) {
          std::vector<double> alone(3 * kPack, -2);
          squared_distances(query[static_cast<std::size_t>(q)], packs.data(), 3, dimension, extent,
                            alone.data());
          CHECK(squared[static_cast<std::size_t>(q)] == alone);
        }
        CHECK(squared[static_cast<std::size_t>(count)] == std::vector<double>(3 * kPack, -1));
      }
    }
  }
}

TEST_CASE_TEMPLATE("squared distances to scattered points, bit for bit", Scalar, float, double) {
  for (const int dimension : {1, 2, 7, 8, 9, 16, 37}) {
    CAPTURE(dimension);
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 11, 3);
    const auto query = make_points<double>(Layout::random, uneven_box(dimension), 1, 4);
    for (Index count = 0; count <= points.cols(); ++count) {
      std::vector<const Scalar*> rows;
      for (Index k = 0; k < count; ++k) rows.push_back(points.col((7 * k) % 11).data());
      std::vector<double> squared(static_cast<std::size_t>(count) + 1, -1);
      ccvt::kernels::squared_distances_of(rows.data(), count, dimension, query.data(),
                                          squared.data());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        CHECK(squared[k] == squared_difference(rows[k], query.data(), dimension));
      }
      CHECK(squared.back() == -1);
    }
  }
}

TEST_CASE("kernels are those of the instruction set that is asked for") {
  // HWY_STATIC_TARGET is what this file is compiled for.
  const std::string baseline = hwy::TargetName(HWY_STATIC_TARGET);
  if (ccvt::test::asks_for_baseline()) CHECK(ccvt::build_info().instruction_set == baseline);
  // Cells are padded to the first, and filled by the second.
  CHECK(ccvt::kernels::product_points() % ccvt::kernels::kRowGroup == 0);
  CHECK(ccvt::kernels::dot_points<float>() % ccvt::kernels::kRowGroup == 0);
}

TEST_CASE_TEMPLATE("rows as streams, relative to a centre, bit for bit", Scalar, float, double) {
  constexpr Index kStride = 4 * ccvt::kernels::kRowGroup;
  for (const int dimension : {1, 3, 15, 16, 17, 32, 61, 784}) {
    CAPTURE(dimension);
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 11, 3);
    const auto centre = make_points<double>(Layout::random, uneven_box(dimension), 1, 4);
    std::vector<const Scalar*> rows;
    for (Index k = 0; k < kStride; ++k) rows.push_back(points.col((7 * k) % 11).data());
    for (Index width = 0; width <= kStride; width += ccvt::kernels::kRowGroup) {
      for (const Index count : {width, width - 1, width - ccvt::kernels::kRowGroup}) {
        if (count < 1) continue;
        std::vector<float> block(static_cast<std::size_t>(kStride * dimension), -1);
        ccvt::kernels::centred_rows(rows.data(), count, width, dimension, centre.data(), 0.7,
                                    block.data(), kStride);
        bool same = true;
        for (int d = 0; d < dimension; ++d) {
          for (Index k = 0; k < kStride; ++k) {
            const auto row = static_cast<std::size_t>(std::min(k, count - 1));
            const double expected = (rows[row][d] - centre.data()[d]) * 0.7;
            const float found = block[static_cast<std::size_t>(d * kStride + k)];
            same = same && found == (k < width ? static_cast<float>(expected) : -1);
          }
        }
        CHECK(same);
      }
    }
  }
}

TEST_CASE("scattered points relative to a centre, one after the other, bit for bit") {
  for (const int dimension : {1, 3, 7, 8, 9, 16, 61}) {
    CAPTURE(dimension);
    const auto points = make_points<double>(Layout::random, uneven_box(dimension), 5, 3);
    const auto centre = make_points<double>(Layout::random, uneven_box(dimension), 1, 4);
    std::vector<const double*> rows;
    for (Index count = 0; count <= 5; ++count) {
      const auto size = static_cast<std::size_t>(count * dimension);
      std::vector<float> block(size + 1, -1);
      ccvt::kernels::centred_points(rows.data(), count, dimension, centre.data(), 0.7,
                                    block.data());
      for (std::size_t k = 0; k < size; ++k) {
        const auto d = static_cast<Index>(k) % dimension;
        const double x = rows[k / static_cast<std::size_t>(dimension)][d];
        CHECK(block[k] == static_cast<float>((x - centre(d, 0)) * 0.7));
      }
      CHECK(block.back() == -1);
      rows.push_back(points.col(4 - count % 5).data());
    }
  }
}

TEST_CASE("squared distances in float, to scattered points and to packs") {
  constexpr auto kPack = static_cast<std::size_t>(ccvt::kernels::kFloatPack);
  constexpr Index kPoints = 11;
  for (const int dimension : {1, 2, 7, 8, 9, 16, 37, 64}) {
    CAPTURE(dimension);
    const auto points = make_points<float>(Layout::random, uneven_box(dimension), kPoints, 3);
    const auto query = make_points<float>(Layout::random, uneven_box(dimension), 6, 4);
    const auto about = [&](float squared, Index k, Index q = 0) {
      const double expected =
          squared_difference(points.col(k).data(), query.col(q).data(), dimension);
      const double share = (dimension + 3) * double{std::numeric_limits<float>::epsilon()};
      return std::abs(double{squared} - expected) <= share * expected;
    };
    for (Index count = 0; count <= kPoints; ++count) {
      std::vector<const float*> rows;
      for (Index k = 0; k < count; ++k) rows.push_back(points.col((7 * k) % kPoints).data());
      std::vector<const float*> queries;
      for (Index q = 0; q < query.cols(); ++q) queries.push_back(query.col(q).data());
      for (Index some = 0; some <= query.cols(); ++some) {
        constexpr Index kStride = kPoints + 1;
        std::vector<float> squared(static_cast<std::size_t>(kStride * query.cols()), -1);
        ccvt::kernels::about_squared_distances_of(rows.data(), count, dimension, queries.data(),
                                                  some, squared.data(), kStride);
        bool right = true;
        for (Index q = 0; q < query.cols(); ++q) {
          for (Index k = 0; k < kStride; ++k) {
            const float found = squared[static_cast<std::size_t>(q * kStride + k)];
            right =
                right && (q < some && k < count ? about(found, (7 * k) % kPoints, q) : found == -1);
          }
        }
        CHECK(right);
      }
    }
    // In two packs, places apart.
    const auto place = [&](Index k) { return static_cast<std::size_t>(k) * (kPack / 8 + 3); };
    std::vector<float> packs(2 * kPack * static_cast<std::size_t>(dimension), 0.0F);
    for (Index k = 0; k < kPoints; ++k) {
      const std::size_t pack = place(k) / kPack * kPack * static_cast<std::size_t>(dimension);
      for (int d = 0; d < dimension; ++d) {
        packs[pack + static_cast<std::size_t>(d) * kPack + place(k) % kPack] = points(d, k);
      }
    }
    std::vector<float> squared(2 * kPack + 1, -1);
    ccvt::kernels::about_squared_distances(query.data(), packs.data(), 2, dimension,
                                           squared.data());
    for (Index k = 0; k < kPoints; ++k) CHECK(about(squared[place(k)], k));
    CHECK(squared.back() == -1);
  }
}

TEST_CASE_TEMPLATE("rows are added one after the other, to the bit", Scalar, float, double) {
  Random random(3, 1);
  for (const int dimension : {1, 2, 7, 8, 9, 40}) {
    for (const Index count : {0, 1, 3, 4, 5, 12}) {
      CAPTURE(dimension);
      CAPTURE(count);
      const auto width = static_cast<std::size_t>(dimension);
      std::vector<Scalar> x(static_cast<std::size_t>(count) * width);
      for (Scalar& value : x) value = static_cast<Scalar>(random.uniform() - .3);
      std::vector<const Scalar*> rows;
      for (Index k = 0; k < count; ++k) rows.push_back(x.data() + k * dimension);
      std::vector<double> centre(width);
      std::vector<double> sum(width);
      for (std::size_t d = 0; d < width; ++d) {
        centre[d] = random.uniform();
        sum[d] = random.uniform();
      }
      std::vector<double> expected = sum;
      for (const Scalar* const row : rows) {
        for (std::size_t d = 0; d < width; ++d) expected[d] += double{row[d]} - centre[d];
      }
      ccvt::kernels::add_rows(rows.data(), count, dimension, centre.data(), sum.data());
      CHECK(sum == expected);
    }
  }
}

TEST_CASE("the least cost of each row") {
  const Index stride = 2 * ccvt::kernels::product_points();
  std::vector<float> cost;
  std::vector<float> expected;
  Random random(3, 1);
  for (int row = 0; row < 5; ++row) {
    expected.push_back(std::numeric_limits<float>::max());
    for (Index k = 0; k < stride; ++k) {
      cost.push_back(static_cast<float>(random.uniform() - .5));
      expected.back() = std::min(expected.back(), cost.back());
    }
  }
  std::vector<float> least(5, 0.0F);
  ccvt::kernels::least_costs(cost.data(), stride, 5, least.data());
  CHECK(least == expected);
}

TEST_SUITE_END();
