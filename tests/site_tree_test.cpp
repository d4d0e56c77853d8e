// Nearest sites, found by trees and grids, against looking at each. Distances are compared, never
// numbers: ties happen.
#include "spatial/site_tree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <vector>

#include "parallel/arena.h"
#include "random.h"
#include "relax/nearest_sites.h"
#include "spatial/site_bins.h"
#include "spatial/site_search.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::NearestSites;
using ccvt::PointNumber;
using ccvt::Points;
using ccvt::Random;
using ccvt::SiteBins;
using ccvt::SiteNumber;
using ccvt::SiteSearch;
using ccvt::SiteState;
using ccvt::SiteTree;
using namespace ccvt::test;

namespace {

struct Sites {
  Sites(Layout layout, int dim, bool is_periodic, Index count)
      : dimension(dim),
        box(uneven_box(dim)),
        domain(is_periodic ? Domain::periodic(box) : Domain()),
        metric(dim, domain),
        positions(make_points<double>(layout, box, count)) {
    // On a torus sites lie in [lower, upper).
    for (Index s = 0; s < count; ++s) {
      for (int d = 0; d < dim; ++d) positions(d, s) = metric.into_box(positions(d, s), d);
    }
  }
  [[nodiscard]] std::span<const double> span() const {
    return {positions.data(), static_cast<std::size_t>(positions.size())};
  }
  [[nodiscard]] Real squared(const double* query, Index site) const {
    return squared_distance(domain, dimension, query, positions.col(site).data());
  }

  int dimension;
  Box box;
  Domain domain;
  Metric metric;
  Points<double> positions;
};

// Rounding of differences that wrap: of the size of the box.
bool equal_distances(Real a, Real b) { return std::abs(a - b) <= 1e-13L * (1 + a + b); }

// Random places, the sites' own and, on a torus, the corners of the box, both faces included.
std::vector<Points<double>> queries_for(const Sites& sites, Index count) {
  std::vector<Points<double>> queries;
  const auto anywhere = make_points<double>(Layout::random, sites.box, count, 77);
  for (Index q = 0; q < count; ++q) queries.emplace_back(anywhere.col(q));
  for (Index s = 0; s < std::min<Index>(5, static_cast<Index>(sites.positions.cols())); ++s) {
    queries.emplace_back(sites.positions.col(s));
  }
  queries.emplace_back(sites.box.lower.eigen());
  queries.emplace_back(sites.box.upper.eigen());
  return queries;
}

void check_nearest(const Sites& sites, const SiteTree& tree, const std::vector<bool>& gone,
                   const double* query) {
  Real best = std::numeric_limits<Real>::infinity();
  for (Index s = 0; s < sites.positions.cols(); ++s) {
    if (!gone[static_cast<std::size_t>(s)]) best = std::min(best, sites.squared(query, s));
  }
  const Index found = tree.nearest(query);
  REQUIRE(found >= 0);
  REQUIRE(found < sites.positions.cols());
  REQUIRE_FALSE(gone[static_cast<std::size_t>(found)]);
  REQUIRE(equal_distances(sites.squared(query, found), best));
  REQUIRE(tree.nearest(query) == found);
}

void check_nearest_k(const Sites& sites, const SiteTree& tree, const std::vector<bool>& gone,
                     const double* query, int k) {
  std::vector<Real> all;
  for (Index s = 0; s < sites.positions.cols(); ++s) {
    if (!gone[static_cast<std::size_t>(s)]) all.push_back(sites.squared(query, s));
  }
  std::sort(all.begin(), all.end());
  std::vector<Index> found{-7};  // what is there stays
  tree.nearest(query, k, found);
  REQUIRE(found.front() == -7);
  REQUIRE(found.size() == 1 + std::min(static_cast<std::size_t>(k), all.size()));
  REQUIRE(std::set<Index>(found.begin(), found.end()).size() == found.size());
  for (std::size_t r = 1; r < found.size(); ++r) {
    REQUIRE_FALSE(gone[static_cast<std::size_t>(found[r])]);
    REQUIRE(equal_distances(sites.squared(query, found[r]), all[r - 1]));
  }
}

void check_within(const Sites& sites, const SiteTree& tree, const std::vector<bool>& gone,
                  const double* query, double radius) {
  std::vector<Index> found;
  tree.within(query, radius, found);
  const std::set<Index> distinct(found.begin(), found.end());
  REQUIRE(distinct.size() == found.size());
  for (Index s = 0; s < sites.positions.cols(); ++s) {
    const Real squared = sites.squared(query, s);
    const Real limit = static_cast<Real>(radius) * radius;
    const bool is_found = distinct.count(s) > 0;
    if (gone[static_cast<std::size_t>(s)]) {
      REQUIRE_FALSE(is_found);
    } else if (!equal_distances(squared, limit)) {
      REQUIRE(is_found == (squared < limit));
    }
  }
}

template <class Visit>
void for_each_arrangement(Visit visit) {
  for (const bool periodic : {false, true}) {
    for (const int dimension : {1, 2, 3, 5, 8, 12, 13, 16}) {
      for (const Layout layout : all_layouts) {
        CAPTURE(periodic);
        CAPTURE(dimension);
        CAPTURE(name_of(layout));
        visit(Sites(layout, dimension, periodic, 90));
      }
    }
  }
}

template <class Scalar>
std::vector<ccvt::Near<Scalar, 0>> found_by(const NearestSites<Scalar>& nearest,
                                            const ccvt::PointsView<Scalar>& points,
                                            const std::vector<PointNumber>& which,
                                            const Arena& arena) {
  return ccvt::with_dimension(nearest.dimension_of_copies(), [&]<std::size_t Dimension>() {
    std::vector<ccvt::Near<Scalar, 0>> all;
    typename NearestSites<Scalar>::template Found<Dimension> found;
    for (int twice = 0; twice < 2; ++twice) {  // also with memory of the last time
      nearest.template find<Dimension>(points, which, arena, found);
    }
    for (const auto& near : found.points) {
      all.push_back({near.site, near.point});
      if constexpr (Dimension > 0) {
        REQUIRE(std::equal(near.x.begin(), near.x.end(), points[near.point.index()]));
      }
    }
    return all;
  });
}

}  // namespace

TEST_SUITE_BEGIN("site tree");

TEST_CASE("the nearest available site, down to the last, whatever the order of removal") {
  for_each_arrangement([](const Sites& sites) {
    const auto queries = queries_for(sites, 3);
    for (const bool coherent : {false, true}) {
      std::vector<Index> order(90);
      std::iota(order.begin(), order.end(), 0);
      Random random(2);
      random.shuffle(std::span(order));
      if (coherent) {
        std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
          return sites.positions(0, a) < sites.positions(0, b);
        });
      }
      SiteTree tree(sites.metric, sites.span());
      std::vector<bool> gone(90, false);
      Index left = 90;
      for (const Index site : order) {
        REQUIRE(tree.available() == left);
        for (const auto& query : queries) check_nearest(sites, tree, gone, query.data());
        if (left % 9 == 1) {
          check_nearest_k(sites, tree, gone, queries[0].data(), 7);
          check_within(sites, tree, gone, queries[0].data(), 0.6);
        }
        tree.remove(site);
        gone[static_cast<std::size_t>(site)] = true;
        --left;
      }
      CHECK(tree.available() == 0);
      CHECK(tree.nearest(queries[0].data()) == -1);
      std::vector<Index> found;
      tree.nearest(queries[0].data(), 3, found);
      tree.within(queries[0].data(), 100, found);
      CHECK(found.empty());
    }
  });
}

TEST_CASE("the k nearest sites, and all within a radius") {
  for_each_arrangement([](const Sites& sites) {
    const SiteTree tree(sites.metric, sites.span());
    const std::vector<bool> gone(90, false);
    for (const auto& query : queries_for(sites, 8)) {
      for (const int k : {1, 2, 5, 30, 89, 90, 200}) {
        check_nearest_k(sites, tree, gone, query.data(), k);
      }
      // The last reaches round the torus several times.
      for (const double radius : {0.0, 0.05, 0.4, 1.1, 9.0}) {
        check_within(sites, tree, gone, query.data(), radius);
      }
    }
  });
}

TEST_CASE("one and two sites") {
  for (const bool periodic : {false, true}) {
    for (const Index count : {1, 2}) {
      const Sites sites(Layout::random, 2, periodic, count);
      const SiteTree tree(sites.metric, sites.span());
      const std::vector<bool> gone(static_cast<std::size_t>(count), false);
      for (const auto& query : queries_for(sites, 20)) {
        check_nearest(sites, tree, gone, query.data());
      }
    }
  }
}

TEST_CASE_TEMPLATE("nearest sites of many points at once", Scalar, float, double) {
  const Arena arena(2);
  for (const bool periodic : {false, true}) {
    for (const int dimension : {1, 2, 3, 4, 9}) {
      if (periodic && dimension > 5) continue;
      for (const Layout layout : all_layouts) {
        // With 1500 a bin's sites are few enough in 3D that none is seen all around the torus.
        for (const Index count : {1, 2, 17, 200, 1500}) {
          if (count == 1500 && dimension != 3) continue;
          CAPTURE(periodic);
          CAPTURE(dimension);
          CAPTURE(name_of(layout));
          CAPTURE(count);
          const Sites sites(layout, dimension, periodic, count);
          SiteState state(dimension, count);
          std::copy_n(sites.positions.data(), sites.positions.size(), state.position.begin());
          for (const Layout of_points : {Layout::random, Layout::grid, Layout::clusters}) {
            // Few points a site, and so many that a bin's cells are told apart.
            const bool bins = dimension == 2 || dimension == 3;
            const Index total = bins && count <= 17 ? 4000 : 400;
            Points<Scalar> points = make_points<Scalar>(of_points, sites.box, total, 9);
            points.col(0) = sites.box.lower.eigen().cast<Scalar>();
            points.col(1) = sites.box.upper.eigen().cast<Scalar>();
            std::vector<PointNumber> which;
            for (Index p = 0; p < total; p += 1 + p % 2) which.emplace_back(p);
            const NearestSites<Scalar> nearest(sites.metric, state, sites.box);
            const auto found = found_by(nearest, ccvt::view_points(points), which, arena);
            for (std::size_t k = 0; k < which.size(); ++k) {
              const Scalar* x = points.col(found[k].point.index()).data();
              Real best = std::numeric_limits<Real>::infinity();
              for (Index s = 0; s < count; ++s) {
                best = std::min(best, squared_distance(sites.domain, dimension, x,
                                                       sites.positions.col(s).data()));
              }
              REQUIRE(found[k].site < state.count());
              REQUIRE(equal_distances(
                  squared_distance(sites.domain, dimension, x,
                                   sites.positions.col(found[k].site.index()).data()),
                  best));
            }
            std::vector<PointNumber> asked;
            for (const auto& near : found) asked.push_back(near.point);
            std::sort(asked.begin(), asked.end());
            REQUIRE(asked == which);
          }
        }
      }
    }
  }
}

// Every site within the radius once, with its squared distance, and no other.
void check_search(const Sites& sites, const SiteSearch& search, const double* query,
                  double radius) {
  std::vector<int> times(static_cast<std::size_t>(sites.positions.cols()), 0);
  std::vector<Index> scratch;
  search.within(query, radius, scratch, [&](Index site, double squared) {
    ++times[static_cast<std::size_t>(site)];
    CHECK(equal_distances(squared, sites.squared(query, site)));
  });
  for (Index s = 0; s < sites.positions.cols(); ++s) {
    const Real squared = sites.squared(query, s);
    const Real limit = static_cast<Real>(radius) * radius;
    const int found = times[static_cast<std::size_t>(s)];
    CHECK(found <= 1);
    if (squared == 0) CHECK(found == 1);
    if (!equal_distances(squared, limit)) CHECK((found == 1) == (squared < limit));
  }
}

TEST_CASE("a clump of sites much smaller than a bin") {
  for (const int dimension : {2, 3}) {
    for (const double width : {1e-6, 1e-9, 1e-12}) {
      CAPTURE(dimension);
      CAPTURE(width);
      const Box box = Box::unit(dimension);
      const Metric metric(dimension, Domain());
      constexpr Index kClump = 60;
      const auto even = make_points<double>(Layout::random, box, 1000, 3);
      const auto small = make_points<double>(Layout::random, box, kClump, 4);
      SiteState state(dimension, 1000 + kClump);
      Points<double> points(dimension, 2000);
      const auto near = make_points<double>(Layout::random, box, 2000, 5);
      for (int d = 0; d < dimension; ++d) {
        for (Index s = 0; s < 1000; ++s) state.at(SiteNumber(s))[d] = even(d, s);
        for (Index s = 0; s < kClump; ++s)
          state.at(SiteNumber(1000 + s))[d] = 0.3 + width * small(d, s);
        for (Index p = 0; p < 2000; ++p) points(d, p) = 0.3 + width * (2 * near(d, p) - 0.5);
      }
      std::vector<PointNumber> which(2000);
      std::iota(which.begin(), which.end(), PointNumber(0));
      const NearestSites<double> nearest(metric, state, box);
      const auto found = found_by(nearest, ccvt::view_points(points), which, Arena(1));
      for (std::size_t k = 0; k < which.size(); ++k) {
        const double* x = points.col(found[k].point.index()).data();
        double best = std::numeric_limits<double>::infinity();
        for (const SiteNumber s : state.all()) {
          best = std::min(best, metric.squared_distance(x, state.at(s)));
        }
        REQUIRE(metric.squared_distance(x, state.at(found[k].site)) == best);
      }
    }
  }
}

TEST_CASE("sites near a position, in bins or through a tree") {
  for (const bool periodic : {false, true}) {
    for (const int dimension : {1, 2, 3, 4}) {
      for (const Layout layout : all_layouts) {
        for (const Index count : {1, 2, 17, 500}) {
          CAPTURE(periodic);
          CAPTURE(dimension);
          CAPTURE(name_of(layout));
          CAPTURE(count);
          const Sites sites(layout, dimension, periodic, count);
          const SiteSearch search(sites.metric, sites.span());
          for (const auto& query : queries_for(sites, 10)) {
            std::vector<double> inside(query.data(), query.data() + dimension);
            for (int d = 0; d < dimension; ++d) {
              inside[static_cast<std::size_t>(d)] =
                  sites.metric.into_box(inside[static_cast<std::size_t>(d)], d);
            }
            for (const double radius : {0.0, 0.1, 0.7, 3.0, 1e6}) {
              check_search(sites, search, inside.data(), radius);
            }
          }
        }
      }
    }
  }
}

TEST_CASE("bins hold even sites, and only where they pay") {
  const auto bins_of = [](const Sites& sites) {
    const Box& box = sites.box;
    return SiteBins::sort(sites.metric, sites.span(), box.lower.data(), box.upper.data());
  };
  for (const int dimension : {2, 3}) {
    const Sites even(Layout::random, dimension, false, 1000);
    const auto bins = bins_of(even);
    REQUIRE(bins);
    CHECK(bins->site_count() == 1000);
    CHECK(bins->bin_count() >= 500);
    CHECK(bins->bin_count() <= 2000);
    std::vector<int> times(1000, 0);
    for (std::size_t place = 0; place < 1000; ++place) {
      const auto site = static_cast<std::size_t>(bins->site(place));
      ++times[site];
      for (int d = 0; d < dimension; ++d) {
        CHECK(bins->position(place)[d] == even.positions(d, static_cast<Index>(site)));
      }
    }
    CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n == 1; }));
    CHECK_FALSE(bins_of(Sites(Layout::clusters, dimension, false, 1000)));
    CHECK_FALSE(bins_of(Sites(Layout::one_place, dimension, false, 1000)));
  }
  CHECK_FALSE(bins_of(Sites(Layout::random, 1, false, 1000)));
  CHECK_FALSE(bins_of(Sites(Layout::random, 4, false, 1000)));
}

TEST_SUITE_END();
