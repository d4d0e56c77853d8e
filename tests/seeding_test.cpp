// First codewords, drawn in rounds.
#include "codebook/seeding.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/codebook.h"
#include "codebook/linkage.h"
#include "codebook/plus_plus.h"
#include "codebook/reseat.h"
#include "codebook/rough_lloyd.h"
#include "codebook/sample.h"
#include "codebook/share.h"
#include "exact/centroids.h"
#include "geometry/squares.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "random.h"
#include "support/generate.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Domain;
using ccvt::Grouping;
using ccvt::Index;
using ccvt::Metric;
using ccvt::plus_plus_in_rounds;
using ccvt::Points;
using ccvt::PointsView;
using ccvt::Pricer;
using ccvt::Prices;
using ccvt::RoughLloyd;
using ccvt::Seeds;
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

TEST_CASE("rough Lloyd iterations are those without bounds, wherever they go on from") {
  // Bounds are kept in 12 dimensions, not in 5.
  for (const int dimension : {5, 12}) {
    CAPTURE(dimension);
    const auto points = make_points<float>(Layout::clusters, uneven_box(dimension), 3000);
    const Metric metric(dimension, Domain());
    const Arena arena(2);
    const PointsView<float> view = view_points(points);
    Seeds kept{plus_plus_in_rounds(view, 40, 3, 1), {}, 0};
    kept.owners = nearest_owners(metric, view, kept.sites, arena);
    Seeds plain = kept;
    RoughLloyd lloyd(metric, view, 40, arena);
    const Pricer<float> pricer(metric, view, arena);
    const std::vector<double> weights(40, 0.0);
    for (int round = 0; round < 4; ++round) {
      CAPTURE(round);
      lloyd.relax(kept);
      for (int i = 0; i < 12; ++i) {
        const double before = plain.energy;
        const Prices prices = pricer.price({plain.sites, weights}, plain.owners);
        plain.energy = prices.cheapest_energy;
        if (prices.moved == 0 || (i > 0 && before - plain.energy < 1e-3 * before)) break;
        move_to_centroids(metric, view, Grouping(plain.owners, 40), arena, plain.sites);
      }
      CHECK(kept.owners == plain.owners);
      CHECK(kept.sites == plain.sites);
      CHECK(kept.energy == plain.energy);
      if (round == 2) break;
      // Elsewhere: some sites change places with others, or far away.
      for (Seeds* const seeds : {&kept, &plain}) {
        for (std::size_t d = 0; d < static_cast<std::size_t>(dimension); ++d) {
          seeds->sites[d] += 3.0 * round;
        }
        for (Index& owner : seeds->owners) owner = owner == 7 ? 8 : owner;
      }
    }
  }
}

TEST_CASE("shared sites are as many in each cloud as its points fill, to within one") {
  // 8 clouds with 1 to 8 parts of 36, far apart; 72 sites, of which seeding by distance gives the
  // small clouds too many.
  constexpr Index kSites = 72;
  Points<float> points = make_points<float>(Layout::random, Box::unit(5), 3600);
  std::vector<Index> cloud_of;
  for (Index cloud = 0; cloud < 8; ++cloud)
    cloud_of.resize(cloud_of.size() + 100 * static_cast<std::size_t>(cloud + 1), cloud);
  for (Index p = 0; p < points.cols(); ++p) {
    points(0, p) += 9.0F * static_cast<float>(cloud_of[static_cast<std::size_t>(p)]);
  }
  const auto count_sites = [](const std::vector<double>& sites) {
    std::array<Index, 8> count{};
    for (std::size_t k = 0; k < sites.size(); k += 5) {
      ++count[static_cast<std::size_t>(std::clamp(sites[k] / 9 + 0.4, 0.0, 7.0))];
    }
    return count;
  };
  // Every cloud has nine.
  std::vector<double> seeds;
  for (Index cloud = 0, first = 0; cloud < 8; first += 100 * ++cloud) {
    for (Index k = 0; k < 9; ++k) {
      const auto x = points.col(first + k);
      seeds.insert(seeds.end(), x.begin(), x.end());
    }
  }
  const auto owners =
      ccvt::nearest_owners(Metric(5, Domain()), view_points(points), seeds, Arena(1));
  for (const bool uneven : {false, true}) {
    CAPTURE(uneven);
    std::vector<Index> capacities(kSites, 50);
    for (std::size_t k = 0; uneven && k < capacities.size(); ++k)
      capacities[k] += k % 2 == 0 ? 40 : -40;
    const auto shared =
        ccvt::share_sites(view_points(points), owners, seeds, capacities, 3, Arena(1));
    CHECK(shared.size() == std::size_t{kSites} * 5);
    const auto count = count_sites(shared);
    for (std::size_t cloud = 0; cloud < 8; ++cloud) {
      CHECK(std::abs(count[cloud] - 2 * (static_cast<Index>(cloud) + 1)) <= 1);
    }
    CHECK(shared == ccvt::share_sites(view_points(points), owners, seeds, capacities, 3, Arena(3)));
    const std::set<Place> distinct = [&] {
      const auto all = places(shared, 5);
      return std::set<Place>(all.begin(), all.end());
    }();
    CHECK(distinct.size() == kSites);
  }
}

TEST_CASE("sites of a cloud stand together, however many there are") {
  constexpr std::size_t kClouds = 7;
  for (const std::size_t n : {std::size_t{700}, ccvt::kLinkedTogether + 500}) {
    CAPTURE(n);
    ccvt::Random random(3, 3);
    std::vector<double> sites;
    for (std::size_t k = 0; k < n; ++k) {
      const auto cloud = static_cast<double>(k * k % kClouds);  // 0, 1, 2 or 4
      for (int d = 0; d < 3; ++d) sites.push_back(10 * cloud * (d == 0 ? 1 : 0) + random.uniform());
    }
    const std::vector<ccvt::SiteNumber> order = ccvt::linkage_order(sites, 3, Arena(1));
    CHECK(order == ccvt::linkage_order(sites, 3, Arena(3)));
    std::vector<int> times(n, 0);
    std::size_t runs = 0;
    double last = -1;
    for (const ccvt::SiteNumber s : order) {
      ++times[s];
      const double cloud = std::floor(sites[s * 3] / 10);
      runs += cloud != last ? 1 : 0;
      last = cloud;
    }
    CHECK(std::all_of(times.begin(), times.end(), [](int k) { return k == 1; }));
    CHECK(runs == 4);
  }
}

TEST_CASE("cells that are merged and split take their points along") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(4), 3000);
  std::vector<double> sites;
  for (Index k = 0; k < 40; ++k) {
    sites.insert(sites.end(), points.col(k).begin(), points.col(k).end());
  }
  const ccvt::Metric metric(4, ccvt::Domain());
  const Arena arena(1);
  const auto view = view_points(points);
  std::vector<Index> owners = ccvt::nearest_owners(metric, view, sites, arena);
  ccvt::move_to_centroids(metric, view, ccvt::Grouping(owners, 40), arena, sites);
  const auto cost = [&] {
    double sum = 0;
    for (Index p = 0; p < points.cols(); ++p) {
      const auto s = static_cast<std::size_t>(owners[static_cast<std::size_t>(p)]);
      sum += ccvt::squared_difference(points.col(p).data(), sites.data() + 4 * s, 4);
    }
    return sum;
  };
  const double before = cost();
  const std::vector<double> given = sites;
  CHECK(ccvt::reseat_sites(view, owners, sites, arena));
  CHECK(sites != given);
  CHECK(cost() < before);
}

TEST_CASE("sites are shared where points, cells or places are few") {
  const auto line = make_points<float>(Layout::two_places, Box::unit(2), 40);
  for (const Index sites : {1, 2, 5, 40}) {
    CAPTURE(sites);
    std::vector<double> seeds;
    for (Index k = 0; k < sites; ++k)
      seeds.insert(seeds.end(), line.col(k).begin(), line.col(k).end());
    const auto owners =
        ccvt::nearest_owners(Metric(2, Domain()), view_points(line), seeds, Arena(1));
    const auto shared = ccvt::share_sites(view_points(line), owners, seeds,
                                          ccvt::equal_capacities(40, sites), 3, Arena(1));
    CHECK(shared.size() == static_cast<std::size_t>(2 * sites));
    const auto all = places(shared, 2);
    const auto wanted = places(line.leftCols(sites));
    CHECK(std::set<Place>(all.begin(), all.end()) == std::set<Place>(wanted.begin(), wanted.end()));
  }
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
