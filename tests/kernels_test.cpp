// The loops over points, against the same sums and comparisons one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "geometry/metric.h"
#include "kernels/keys.h"
#include "kernels/streams.h"
#include "support/generate.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
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

TEST_SUITE_END();
