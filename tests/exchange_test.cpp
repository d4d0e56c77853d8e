// What an exchange graph finds hangs on the points, the sites and the weights alone: neither on
// bounds, nor on which rank has which points.
#include "exact/exchange.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <vector>

#include "ccvt/capacity.h"
#include "cell_sizes.h"
#include "exact/assignment.h"
#include "exact/cell_bounds.h"
#include "exact/move_costs.h"
#include "exact/pricing.h"
#include "random.h"
#include "support/generate.h"
#include "support/thread_ranks.h"

namespace ccvt::test {
namespace {

struct Exchanged {
  std::vector<Index> owners;
  std::vector<double> weights;
  std::vector<Index> capacities;
  std::int64_t paths = 0;
  bool operator==(const Exchanged&) const = default;
};

/// Squared distances, but with bounds that are lower by chance.
template <class Scalar>
class LooseCosts final : public MoveCosts {
 public:
  LooseCosts(SquaredDistances<Scalar>& costs, double most, std::uint64_t seed)
      : costs_(costs), most_(most), random_(seed, 1) {}
  void squared(std::span<const PointNumber> points, SiteNumber site,
               std::vector<double>& out) const override {
    costs_.squared(points, site, out);
  }
  void squared_at_least(std::span<const PointNumber> points, std::span<const SiteNumber> sites,
                        std::vector<double>& out, std::vector<double>& slack) const override {
    costs_.squared_at_least(points, sites, out, slack);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] -= most_ * random_.uniform();
    for (double& of_site : slack) of_site = (of_site + most_) * (1 + 1e-12);
  }
  [[nodiscard]] std::size_t sites_at_once() const override { return 3; }
  void squared_to(PointNumber point, std::span<const SiteNumber> sites, std::vector<double>& out,
                  Scratch& scratch) const override {
    costs_.squared_to(point, sites, out, scratch);
  }
  std::span<const double> squared_at_least_to_all(PointNumber point,
                                                  Scratch& scratch) const override {
    costs_.squared_at_least_to_all(point, scratch);
    // By the same on all ranks.
    for (double& squared : scratch.squared) squared -= most_ * std::abs(std::sin(1e3 * squared));
    return scratch.squared;
  }
  [[nodiscard]] double rounding(double sum) const override { return costs_.rounding(sum); }
  std::vector<PointNumber> bring(std::span<const Index> points, const RankPart& part) override {
    return costs_.bring(points, part);
  }
  std::span<const double> bounds(SiteNumber site, std::span<const PointNumber> members,
                                 Scratch& scratch) const override {
    costs_.bounds(site, members, scratch);
    for (double& bound : scratch.bounds) bound -= most_ * random_.uniform();
    return scratch.bounds;
  }
  [[nodiscard]] std::size_t weighings() const override { return 3; }

 private:
  SquaredDistances<Scalar>& costs_;
  double most_;
  mutable Random random_;
};

/// Points and sites; where they lie on a grid, most distances are equal to others.
struct Scene {
  Points<float> points;
  std::vector<double> sites;
};

Scene make_scene(int dimension, Index points, Index sites, bool grid, std::uint64_t seed = 3) {
  Random random(seed, 17);
  Scene made{Points<float>(dimension, points), {}};
  const auto coordinate = [&] {
    const double x = random.uniform() * random.uniform();
    return grid ? std::floor(8 * x) : x;
  };
  for (Index p = 0; p < points; ++p) {
    for (int d = 0; d < dimension; ++d) made.points(d, p) = static_cast<float>(coordinate());
  }
  for (Index k = 0; k < sites * dimension; ++k) made.sites.push_back(coordinate());
  return made;
}

std::vector<Index> capacities_for(bool floating, Index points, Index sites) {
  std::vector<Index> capacities = equal_capacities(points, sites);
  if (floating) return capacities;
  for (std::size_t s = 0; s + 1 < capacities.size(); s += 2) {
    const Index some = capacities[s] / 2;
    capacities[s] -= some;
    capacities[s + 1] += some;
  }
  return capacities;
}

/// From the cheapest sites without weights.
Exchanged exchange(const Scene& scene, bool floating, MoveCosts& costs, CellBounds* kept) {
  const auto dimension = static_cast<int>(scene.points.rows());
  const auto m = static_cast<Index>(scene.points.cols());
  const auto n = static_cast<Index>(scene.sites.size()) / dimension;
  const Metric metric(dimension, Domain());
  const Arena arena(1);
  Exchanged result;
  result.weights.assign(static_cast<std::size_t>(n), 0.0);
  result.capacities = capacities_for(floating, m, n);
  const Pricer<float> pricer(metric, view_points(scene.points), arena);
  result.owners = pricer.cheapest({scene.sites, result.weights});
  if (kept != nullptr) pricer.price({scene.sites, result.weights}, result.owners, kept);
  ExchangeGraph graph(result.capacities, floating, result.owners, result.weights, costs, kept);
  graph.settle(arena);
  result.paths = graph.augmentations();
  CHECK(cell_sizes(result.owners, static_cast<std::size_t>(n)) == result.capacities);
  return result;
}

void check_all_bounds_alike(int dimension, Index points, Index sites, bool floating, bool grid,
                            std::uint64_t seed = 3) {
  CAPTURE(dimension);
  CAPTURE(sites);
  CAPTURE(floating);
  CAPTURE(grid);
  const Scene made = make_scene(dimension, points, sites, grid, seed);
  const Metric metric(dimension, Domain());
  const auto costs = [&] {
    return SquaredDistances<float>(metric, view_points(made.points), made.sites);
  };
  auto plain = costs();
  const Exchanged expected = exchange(made, floating, plain, nullptr);
  CHECK(expected.paths > points / 20);
  const Points<double> wide = made.points.cast<double>();  // no distances in float
  SquaredDistances<double> of_doubles(metric, view_points(wide), made.sites);
  CHECK(exchange(made, floating, of_doubles, nullptr) == expected);
  auto other = costs();
  CellBounds kept(static_cast<std::size_t>(points), static_cast<std::size_t>(sites));
  CHECK(exchange(made, floating, other, &kept) == expected);
  const double scale = grid ? 64 : 1;
  for (const double most : {1e-3, 0.3, 30.0}) {
    CAPTURE(most);
    LooseCosts<float> loose(other, most * scale, 5);
    CHECK(exchange(made, floating, loose, nullptr) == expected);
    CellBounds anew(static_cast<std::size_t>(points), static_cast<std::size_t>(sites));
    CHECK(exchange(made, floating, loose, &anew) == expected);
  }
}

}  // namespace

TEST_SUITE_BEGIN("exchange");

TEST_CASE("exchange: sites whose rounding says little of distances are compared in double") {
  const Metric metric(20, Domain());
  for (const double offset : {0.0, 1e5}) {
    Scene made = make_scene(20, 500, 40, false);
    made.points.array() += static_cast<float>(offset);
    for (double& x : made.sites) x += offset;
    const SquaredDistances<float> costs(metric, view_points(made.points), made.sites);
    const bool rounded = costs.sites_at_once() > 1;
    CHECK(rounded == (offset == 0.0));
  }
}

TEST_CASE("exchange: the same whatever bounds say, and whatever is as short") {
  for (const bool floating : {false, true}) {
    for (const bool grid : {false, true}) {
      check_all_bounds_alike(2, 1203, 40, floating, grid);
      check_all_bounds_alike(3, 2005, 300, floating, grid);
      check_all_bounds_alike(9, 4001, 90, floating, grid);
      check_all_bounds_alike(5, 4001, 1000, floating, grid);  // many more sites than slots
    }
    check_all_bounds_alike(17, 2003, 60, floating, false);  // distances in float
    check_all_bounds_alike(8, 6003, 600, floating, false);  // edges whose known moves are all gone
  }
}

TEST_CASE("exchange: a point may come to an edge whose known moves are all gone") {
  check_all_bounds_alike(3, 4624, 289, false, false, 3);
  check_all_bounds_alike(3, 4624, 289, true, false, 3);
  check_all_bounds_alike(19, 7896, 376, true, false, 5);
  check_all_bounds_alike(11, 4056, 338, false, true, 110);
  check_all_bounds_alike(11, 4056, 338, true, true, 110);
}

TEST_SUITE_END();

TEST_SUITE_BEGIN("ranks");

TEST_CASE("ranks: an exact assignment is that of one process") {
  for (const bool torus : {false, true}) {
    for (const bool floating : {false, true}) {
      for (const bool grid : {false, true}) {
        CAPTURE(torus);
        CAPTURE(floating);
        CAPTURE(grid);
        // On a torus no bounds are kept.
        const Scene made = make_scene(3, 1007, 400, grid);
        Box box = Box::unit(3);
        box.upper = Coordinates::constant(3, 8);
        const Metric metric(3, torus ? Domain::periodic(box) : Domain());
        const std::vector<Index> capacities =
            floating ? std::vector<Index>() : capacities_for(false, 1007, 400);
        const auto solve = [&](PointsView<float> points, const RankPart& part, Exchanged& result) {
          const Arena arena(1);
          ExactAssignment<float> assignment(metric, points, 400, capacities, arena, 0, part);
          result.weights.assign(400, 0.0);
          result.owners.assign(static_cast<std::size_t>(points.count), 0);
          result.paths = assignment.solve(made.sites, result.weights, result.owners).augmentations;
        };
        Exchanged expected;
        solve(view_points(made.points), {}, expected);
        const std::vector<std::vector<Index>> all_cuts = {
            {0, 1007}, {0, 301, 1007}, {0, 400, 400, 900, 1007}};
        for (const std::vector<Index>& cuts : all_cuts) {
          CAPTURE(cuts.size());
          std::vector<Index> owners(1007, -1);
          bool same = true;
          std::mutex mutex;
          ThreadRanks(static_cast<int>(cuts.size()) - 1).run([&](Ranks& ranks) {
            const auto rank = static_cast<std::size_t>(ranks.rank());
            const Index first = cuts[rank];
            Exchanged own;
            solve({made.points.data() + first * 3, 3, cuts[rank + 1] - first, 3}, {&ranks, first},
                  own);
            const std::lock_guard lock(mutex);
            std::copy(own.owners.begin(), own.owners.end(), owners.begin() + first);
            same = same && own.weights == expected.weights && own.paths == expected.paths;
          });
          CHECK(owners == expected.owners);
          CHECK(same);
        }
      }
    }
  }
}

TEST_CASE("ranks: an exchange is that of one process, though each has bounds of its own") {
  for (const bool floating : {false, true}) {
    for (const bool grid : {false, true}) {
      CAPTURE(floating);
      CAPTURE(grid);
      const Scene made = make_scene(4, 1503, 300, grid);
      const Metric metric(4, Domain());
      SquaredDistances<float> plain(metric, view_points(made.points), made.sites);
      const Exchanged expected = exchange(made, floating, plain, nullptr);
      const std::vector<Index> cuts = {0, 333, 1000, 1503};
      const std::vector<Index> begin = Pricer<float>(metric, view_points(made.points), Arena(1))
                                           .cheapest({made.sites, std::vector<double>(300, 0.0)});
      for (const double most : {0.0, 1e-2, 10.0}) {
        CAPTURE(most);
        std::vector<Index> owners(1503, -1);
        bool same = true;
        std::mutex mutex;
        ThreadRanks(3).run([&](Ranks& ranks) {
          const auto rank = static_cast<std::size_t>(ranks.rank());
          const Index first = cuts[rank];
          const PointsView<float> points{made.points.data() + first * 4, 4, cuts[rank + 1] - first,
                                         4};
          SquaredDistances<float> of_rank(metric, points, made.sites);
          LooseCosts<float> loose(of_rank, most, 11 + rank);
          Exchanged own;
          own.owners.assign(begin.begin() + first, begin.begin() + cuts[rank + 1]);
          own.weights.assign(300, 0.0);
          own.capacities = capacities_for(floating, 1503, 300);
          ExchangeGraph graph(own.capacities, floating, own.owners, own.weights, loose, nullptr,
                              {&ranks, first});
          graph.settle(Arena(1));
          const std::lock_guard lock(mutex);
          std::copy(own.owners.begin(), own.owners.end(), owners.begin() + first);
          same = same && own.weights == expected.weights && graph.augmentations() == expected.paths;
        });
        CHECK(owners == expected.owners);
        CHECK(same);
      }
    }
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
