// The loops over points, against the same sums and comparisons one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "geometry/metric.h"
#include "geometry/squares.h"
#include "kernels/about.h"
#include "kernels/keys.h"
#include "kernels/nearest.h"
#include "kernels/products.h"
#include "kernels/rows.h"
#include "kernels/streams.h"
#include "random.h"
#include "support/generate.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Random;
using ccvt::squared_difference;
using namespace ccvt::test;

namespace {

enum class Faces { none, all, last };

constexpr Index sizes[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 64, 100, 257};

/// A block: a stream for each dimension.
template <class Scalar>
std::vector<Scalar> make_block(const Box& box, Index count) {
  const auto points = make_points<Scalar>(Layout::random, box, count, 11);
  std::vector<Scalar> block;
  for (int d = 0; d < box.dimension(); ++d) {
    for (Index k = 0; k < count; ++k) block.push_back(points(d, k));
  }
  return block;
}

/// What is wrong with the places found above and below thresholds around one of the keys. Keys that
/// differ from the threshold by less than `slack` may be found or not.
template <class Scalar, class AnyCut>
std::string places_faults(const std::vector<Scalar>& block, int dimension, const AnyCut& cut,
                          const std::vector<Scalar>& keys, double slack) {
  using ccvt::kernels::Beyond;
  const auto count = static_cast<Index>(keys.size());
  std::vector<Index> places(keys.size());
  for (const std::size_t middle : {std::size_t{0}, keys.size() / 2, keys.size() - 1}) {
    const Scalar threshold = keys[middle];
    for (const Beyond beyond : {Beyond::above, Beyond::below}) {
      const Index found = ccvt::kernels::places_beyond(block.data(), count, count, dimension, cut,
                                                       beyond, threshold, places.data());
      if (found < 0 || found > count) return "an impossible number of places";
      std::vector<bool> is_found(keys.size(), false);
      for (Index k = 0; k < found; ++k) {
        const Index place = places[static_cast<std::size_t>(k)];
        if (place < 0 || place >= count) return "a place outside the block";
        if (k > 0 && place <= places[static_cast<std::size_t>(k) - 1]) return "not ascending";
        is_found[static_cast<std::size_t>(place)] = true;
      }
      for (std::size_t k = 0; k < keys.size(); ++k) {
        const double by = static_cast<double>(keys[k]) - static_cast<double>(threshold);
        const double past = beyond == Beyond::above ? by : -by;
        if (past > slack && !is_found[k]) return "missed place " + std::to_string(k);
        if (past < -slack && is_found[k]) return "should not have found " + std::to_string(k);
      }
    }
  }
  return "";
}

/// What is wrong with a stretch in the middle of a block, against the same points in a block of
/// their own.
template <class Scalar, class AnyCut>
std::string stretch_faults(const std::vector<Scalar>& block, Index count, int dimension,
                           const AnyCut& cut) {
  using ccvt::kernels::Beyond;
  const Index first = count / 3;
  const Index size = count - first - count / 5;
  std::vector<Scalar> own;
  for (int d = 0; d < dimension; ++d) {
    const auto from = block.begin() + static_cast<std::ptrdiff_t>(d) * count + first;
    own.insert(own.end(), from, from + size);
  }
  const auto [highest, lowest] =
      ccvt::kernels::key_extremes(own.data(), size, cut, own.data(), size, cut, dimension);
  const Scalar* const stretch = block.data() + first;
  const auto extreme = [&](Beyond beyond) {
    return ccvt::kernels::extreme_key(stretch, count, size, dimension, cut, beyond);
  };
  if (extreme(Beyond::above) != highest) return "highest key";
  if (extreme(Beyond::below) != lowest) return "lowest key";
  const Scalar middle = (highest + lowest) / 2;
  for (const Beyond beyond : {Beyond::above, Beyond::below}) {
    std::vector<Index> places(own.size());
    std::vector<Index> expected(own.size());
    const Index found = ccvt::kernels::places_beyond(stretch, count, size, dimension, cut, beyond,
                                                     middle, places.data());
    ccvt::kernels::places_beyond(own.data(), size, size, dimension, cut, beyond, middle,
                                 expected.data());
    const auto all = static_cast<std::size_t>(found);
    if (!std::equal(places.begin(), places.begin() + found, expected.begin())) return "places";
    if (all > 0 && all == own.size()) return "all of them";
  }
  return "";
}

/// Eight interleaved partial sums, as promised: bits do not depend on the instruction set.
double add_up(const std::vector<double>& terms) {
  std::array<double, 8> sum{};
  for (std::size_t k = 0; k < terms.size(); ++k) sum[k % 8] += terms[k];
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

}  // namespace

TEST_SUITE_BEGIN("kernels");

TEST_CASE_TEMPLATE("sums and spreads, bit for bit", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 5}) {
    const Box box = uneven_box(dimension);
    const Metric torus(dimension, Domain::periodic(box));
    for (const Index count : sizes) {
      CAPTURE(dimension);
      CAPTURE(count);
      const auto block = make_block<Scalar>(box, count);
      std::vector<double> centre(static_cast<std::size_t>(dimension));
      for (std::size_t d = 0; d < centre.size(); ++d) {
        centre[d] = box.lower[static_cast<Index>(d)] + 0.1 * torus.extent()[d];
      }
      for (const bool periodic : {false, true}) {
        std::vector<double> squared(static_cast<std::size_t>(count), 0.0);
        for (int d = 0; d < dimension; ++d) {
          std::vector<double> terms;
          const auto& origin = centre[static_cast<std::size_t>(d)];
          const Scalar* stream = block.data() + d * count;
          for (Index k = 0; k < count; ++k) {
            const double difference = static_cast<double>(stream[k]) - origin;
            terms.push_back(periodic ? torus.wrap(difference, d) : difference);
            squared[static_cast<std::size_t>(k)] += terms.back() * terms.back();
          }
          CHECK(ccvt::kernels::sum_from(stream, count, origin,
                                        periodic ? torus.extent()[d] : 0.0) == add_up(terms));
        }
        const auto spread = ccvt::kernels::spread_around(
            block.data(), count, dimension, centre.data(), periodic ? torus.extent() : nullptr);
        CHECK(spread.squared_radius == *std::max_element(squared.begin(), squared.end()));
        const auto [low, high] = ccvt::kernels::range(block.data(), count);
        CHECK(low == *std::min_element(block.begin(), block.begin() + count));
        CHECK(high == *std::max_element(block.begin(), block.begin() + count));
        CHECK(spread.energy == doctest::Approx(add_up(squared)).epsilon(1e-14));
      }
    }
  }
}

TEST_CASE_TEMPLATE("keys and their extremes, also across faces", Scalar, float, double) {
  const double epsilon = 20 * static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  for (const int dimension : {1, 2, 3, 4}) {
    const Box box = uneven_box(dimension);
    const Metric torus(dimension, Domain::periodic(box));
    for (const Index count : sizes) {
      CAPTURE(dimension);
      CAPTURE(count);
      const auto block = make_block<Scalar>(box, count);
      // Near the lower face, the upper face, and in the middle.
      for (const double where : {0.05, 0.5, 0.95}) {
        // Across no faces, those of all dimensions, or those of the last.
        for (const auto faces : {Faces::none, Faces::all, Faces::last}) {
          std::vector<Scalar> origin;
          std::vector<Scalar> turn;
          std::vector<Scalar> extent;
          std::vector<Scalar> normal;
          std::vector<double> exact(static_cast<std::size_t>(count), 0.0);
          double size = 0;
          for (int d = 0; d < dimension; ++d) {
            const bool wrapped =
                faces == Faces::all || (faces == Faces::last && d == dimension - 1);
            const double along = torus.extent()[d];
            const double middle = box.lower[d] + where * along;
            const Metric::Unrolled frame = torus.unrolled(middle, d);
            origin.push_back(static_cast<Scalar>(wrapped ? frame.origin : middle));
            turn.push_back(static_cast<Scalar>(frame.turn));
            extent.push_back(static_cast<Scalar>(along));
            normal.push_back(static_cast<Scalar>(d % 2 == 0 ? 0.75 : -0.5));
            size += std::abs(middle) + 2 * along;
            for (Index k = 0; k < count; ++k) {
              const auto x = static_cast<double>(block[static_cast<std::size_t>(d * count + k)]);
              const double difference = wrapped ? torus.wrap(x - middle, d) : x - middle;
              // Half way around, either way is the shortest.
              const bool tie = wrapped && std::abs(std::abs(difference) - along / 2) < 1e-6;
              exact[static_cast<std::size_t>(k)] +=
                  tie ? std::numeric_limits<double>::quiet_NaN()
                      : difference * static_cast<double>(normal.back());
            }
          }
          std::vector<Scalar> keys(static_cast<std::size_t>(count));
          ccvt::kernels::Extremes<Scalar> extremes{};
          const auto visit = [&](const auto& cut) {
            ccvt::kernels::keys(block.data(), count, dimension, cut, keys.data());
            extremes = ccvt::kernels::key_extremes(block.data(), count, cut, block.data(), count,
                                                   cut, dimension);
            CHECK(places_faults(block, dimension, cut, keys, epsilon * size) == "");
            CHECK(stretch_faults(block, count, dimension, cut) == "");
          };
          switch (faces) {
            case Faces::none:
              visit(ccvt::kernels::Cut<Scalar>{origin.data(), normal.data()});
              break;
            case Faces::all:
              visit(ccvt::kernels::WrappedCut<Scalar>{origin.data(), normal.data(), turn.data(),
                                                      extent.data()});
              break;
            case Faces::last:
              visit(ccvt::kernels::FaceCut<Scalar>{origin.data(), normal.data(), turn.back(),
                                                   extent.back() * normal.back(), dimension - 1});
              break;
          }
          for (std::size_t k = 0; k < keys.size(); ++k) {
            if (std::isnan(exact[k])) continue;
            CHECK(std::abs(static_cast<double>(keys[k]) - exact[k]) <= epsilon * size);
          }
          const auto [low, high] = std::minmax_element(keys.begin(), keys.end());
          CHECK(std::abs(static_cast<double>(extremes.lowest_j - *low)) <= epsilon * size);
          CHECK(std::abs(static_cast<double>(extremes.highest_i - *high)) <= epsilon * size);
        }
      }
    }
  }
}

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

TEST_CASE_TEMPLATE("rows as streams, relative to a centre, bit for bit", Scalar, float, double) {
  constexpr Index kStride = 4 * ccvt::kernels::kRowGroup;
  for (const int dimension : {1, 3, 15, 16, 17, 32, 61, 784}) {
    CAPTURE(dimension);
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 11, 3);
    const auto centre = make_points<double>(Layout::random, uneven_box(dimension), 1, 4);
    std::vector<const Scalar*> rows;
    for (Index k = 0; k < kStride; ++k) rows.push_back(points.col((7 * k) % 11).data());
    for (Index count = 0; count <= kStride; count += ccvt::kernels::kRowGroup) {
      std::vector<float> block(static_cast<std::size_t>(kStride * dimension), -1);
      ccvt::kernels::centred_rows(rows.data(), count, dimension, centre.data(), 0.7, block.data(),
                                  kStride);
      bool same = true;
      for (int d = 0; d < dimension; ++d) {
        for (Index k = 0; k < kStride; ++k) {
          const auto row = static_cast<std::size_t>(k);
          const double expected = (rows[row][d] - centre.data()[d]) * 0.7;
          const float found = block[static_cast<std::size_t>(d * kStride + k)];
          same = same && found == (k < count ? static_cast<float>(expected) : -1);
        }
      }
      CHECK(same);
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
