// k-means++ of several streams at once, against the same draws point by point.
#include "codebook/plus_plus.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "parallel/arena.h"
#include "random.h"
#include "support/generate.h"

namespace ccvt::test {
namespace {

class OneByOne {
 public:
  explicit OneByOne(const Points<float>& points)
      : points_(points),
        squared_(static_cast<std::size_t>(points.cols()), std::numeric_limits<float>::max()) {}

  std::vector<double> draw(Index sites, std::uint64_t seed, std::uint64_t stream) {
    Random random(seed, stream);
    const bool greedy = points_.rows() <= kGreedyDimensions;
    const int draws = greedy ? 2 + static_cast<int>(std::log(sites)) : 1;
    std::vector<double> drawn;
    for (Index s = 0; s < sites; ++s) {
      Index chosen = random.index_below(static_cast<Index>(points_.cols()));
      double least = std::numeric_limits<double>::infinity();
      const double all = std::accumulate(squared_.begin(), squared_.end(), 0.0);
      for (int k = 0; k < draws && s > 0 && all > 0; ++k) {
        const Index p = at(random.uniform() * all);
        const double left = sum(lowered(p));
        if (left >= least) continue;
        least = left;
        chosen = p;
      }
      squared_ = lowered(chosen);
      for (Index d = 0; d < points_.rows(); ++d) drawn.push_back(points_(d, chosen));
    }
    return drawn;
  }

 private:
  /// The first point up to which squares sum to more than that, or the last.
  [[nodiscard]] Index at(double place) const {
    double sum = 0;
    std::size_t p = 0;
    for (; p + 1 < squared_.size(); ++p) {
      sum += double{squared_[p]};
      if (sum > place) break;
    }
    return static_cast<Index>(p);
  }

  [[nodiscard]] std::vector<float> lowered(Index to) const {
    std::vector<float> squared = squared_;
    for (std::size_t p = 0; p < squared.size(); ++p) {
      float sum = 0;
      for (Index d = 0; d < points_.rows(); ++d) {
        const float difference = points_(d, static_cast<Index>(p)) - points_(d, to);
        sum += difference * difference;
      }
      squared[p] = std::min(sum, squared[p]);
    }
    return squared;
  }

  /// In eight interleaved parts of 64 values at a time.
  static double sum(const std::vector<float>& values) {
    double total = 0;
    for (std::size_t begin = 0; begin < values.size(); begin += 64) {
      std::vector<float> part(8, 0.0F);
      for (std::size_t k = begin; k < std::min(begin + 64, values.size()); ++k) {
        part[(k - begin) % 8] += values[k];
      }
      const double first = (part[0] + part[4]) + (part[1] + part[5]);
      total += first + ((part[2] + part[6]) + (part[3] + part[7]));
    }
    return total;
  }

  const Points<float>& points_;
  std::vector<float> squared_;
};

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("sites drawn for several streams at once are those of each stream, for any threads") {
  // Up to several tiles of points, the last of them not full.
  struct Case {
    int dimension;
    Index count;
    Index sites;
  };
  for (const Case& made :
       std::vector<Case>{{2, 9001, 40}, {7, 130, 130}, {8, 1, 1}, {9, 3000, 30}, {60, 700, 25}}) {
    CAPTURE(made.dimension);
    const Index sites = made.sites;
    const auto points =
        make_points<float>(Layout::clusters, uneven_box(made.dimension), made.count);
    const std::vector<std::uint64_t> streams = {4, 5, 9};
    std::vector<std::vector<double>> expected;
    for (const std::uint64_t k : streams) expected.push_back(OneByOne(points).draw(sites, 3, k));
    for (const int threads : {1, 3}) {
      CHECK(plus_plus(view_points(points), sites, 3, streams, Arena(threads)) == expected);
    }
    const auto last = plus_plus(view_points(points), sites, 3, std::span(streams).last(1));
    CHECK(last.front() == expected.back());
  }
}

TEST_CASE("where all points are in one place, any are drawn") {
  Points<float> points(3, 100);
  points.setConstant(2.5F);
  const std::vector<std::uint64_t> streams = {1, 2};
  const auto drawn = plus_plus(view_points(points), 20, 3, streams);
  REQUIRE(drawn.size() == 2);
  CHECK(drawn[0] == std::vector<double>(60, 2.5));
}

TEST_SUITE_END();

}  // namespace ccvt::test
