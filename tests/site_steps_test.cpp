// Bounds follow the steps of sites: never above what is to be bounded, and below it by no more than
// the farthest point of a cell makes them.
#include "exact/site_steps.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/bounds.h"
#include "random.h"

namespace ccvt::test {
namespace {

using Position = std::vector<long double>;

long double squared(const Position& a, const Position& b) {
  long double sum = 0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

struct Case {
  int dimension;
  double scale;   // of all coordinates
  double offset;  // of all of them, in units of the scale
  double step;    // in the same
  bool few;       // sites that move
};

class Moved {
 public:
  static constexpr std::size_t kSites = 150;

  explicit Moved(const Case& made) : made_(made), random_(7, 1) {
    for (std::size_t k = 0; k < kSites * dimension(); ++k) {
      from_.push_back(made.scale * (made.offset + random_.uniform()));
      const bool moves = !made.few || k / dimension() % 4 == 1;
      to_.push_back(from_.back() + (moves ? made.scale * made.step * (random_.uniform() - .5) : 0));
    }
  }

  void check() {
    const SiteSteps steps(from_, to_, dimension());
    CHECK_FALSE(steps.none());
    CHECK(steps.all() == !made_.few);
    SiteSteps::Scratch scratch;
    std::vector<SiteSteps::Cell> cells;
    std::vector<std::vector<double>> bounds;
    std::vector<double> radius;
    std::vector<double> growth;  // of what points cost at their own site
    for (const SiteNumber i : sites_below(kSites)) {
      CHECK(steps.moved(i) == (from_at(i) != to_at(i)));
      radius.push_back(made_.scale * random_.uniform());
      growth.push_back(made_.scale * made_.scale * (random_.uniform() - .5));
      bounds.emplace_back();
      const Position x = from_at(i);
      for (const SiteNumber j : sites_below(kSites)) {
        // The least over the ball: where points are nearest to j.
        const long double apart = std::sqrt(squared(x, from_at(j)));
        bounds.back().push_back(static_cast<double>(apart * apart - 2 * radius.back() * apart));
      }
      cells.push_back(
          {to_.data() + i * dimension(), radius.back(), growth.back(), bounds.back().data()});
    }
    const auto before = bounds;
    steps.follow(cells, scratch);
    for (const SiteNumber i : sites_below(kSites)) {
      for (const SiteNumber j : sites_below(kSites)) {
        const Position d = difference(to_at(j), from_at(j));
        const long double length = std::sqrt(squared(d, Position(d.size(), 0)));
        // Of points in a ball around where the site is now.
        const long double change = squared(to_at(i), to_at(j)) - squared(to_at(i), from_at(j)) -
                                   2 * radius[i] * length -
                                   (steps.all() ? growth[i] : 0);  // else the caller's
        const long double off = static_cast<long double>(bounds[i][j]) - before[i][j] - change;
        const long double about =
            std::abs(before[i][j]) + squared(to_at(i), to_at(j)) + made_.scale * made_.scale;
        REQUIRE(off <= 1e-17L * about);
        REQUIRE(off >= -1e-3L * made_.scale * length - 1e-13L * about);
      }
    }
  }

 private:
  [[nodiscard]] Position at(const std::vector<double>& sites, SiteNumber s) const {
    const double* const x = sites.data() + s * dimension();
    return {x, x + dimension()};
  }
  [[nodiscard]] Position from_at(SiteNumber s) const { return at(from_, s); }
  [[nodiscard]] Position to_at(SiteNumber s) const { return at(to_, s); }
  [[nodiscard]] std::size_t dimension() const { return static_cast<std::size_t>(made_.dimension); }
  static Position difference(Position a, const Position& b) {
    for (std::size_t d = 0; d < a.size(); ++d) a[d] -= b[d];
    return a;
  }

  Case made_;
  Random random_;
  std::vector<double> from_;
  std::vector<double> to_;
};

}  // namespace

TEST_SUITE_BEGIN("site steps");

TEST_CASE("bounds follow steps of any length, wherever the sites are") {
  for (const int dimension : {1, 3, 17, 200}) {
    for (const double step : {1e-9, 1e-2, 3.0}) {
      for (const double scale : {1.0, 1e-140, 1e140}) {
        for (const bool few : {false, true}) {
          CAPTURE(dimension);
          CAPTURE(step);
          CAPTURE(scale);
          CAPTURE(few);
          Moved({dimension, scale, 0, step, few}).check();
        }
      }
      Moved({dimension, 1, 1e5, step, false}).check();
    }
  }
}

TEST_CASE("without steps nothing changes") {
  const std::vector<double> sites = {1, 2, 3, 4};
  const SiteSteps steps(sites, sites, 2);
  CHECK(steps.none());
  CHECK_FALSE(steps.moved(SiteNumber(1)));
}

TEST_CASE("sites whose bounds are not above zero are found") {
  Random random(3, 1);
  for (const Index count : {1, 7, 8, 9, 100}) {
    CAPTURE(count);
    std::vector<double> bound;
    std::vector<double> weight;
    for (Index k = 0; k < count; ++k) {
      bound.push_back(random.uniform() - .2);
      weight.push_back(random.uniform() * .2);
    }
    constexpr double kOwn = .1;
    if (count > 8) {
      bound[3] = weight[3] - kOwn;  // zero but for rounding
      bound[8] = std::nan("");
      bound[5] = weight[5] - kOwn + 1e-9;
    }
    std::vector<Index> expected;
    for (Index k = 0; k < count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (!(bound[at] + kOwn - weight[at] > 1e-12)) expected.push_back(k);
    }
    std::vector<Index> found(bound.size(), -1);
    const Index number =
        kernels::bounds_within(bound.data(), weight.data(), kOwn, count, found.data());
    REQUIRE(number == std::ssize(expected));
    found.resize(expected.size());
    CHECK(found == expected);
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
