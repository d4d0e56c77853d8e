// tessellate_masses() against what weighted.h says, see support/masses.h.
#include "ccvt/weighted.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "ccvt/solver.h"
#include "number_text.h"
#include "random.h"
#include "support/catch_in_time.h"
#include "support/generate.h"
#include "support/masses.h"
#include "support/message.h"
#include "support/oracle.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::MassMethod;
using ccvt::MassOptions;
using ccvt::MassResult;
using ccvt::Points;
using ccvt::Termination;
using ccvt::tessellate;
using ccvt::tessellate_masses;
using namespace ccvt::test;

TEST_SUITE_BEGIN("weighted");

TEST_CASE("whole points: masses within the bound, sites at the centres, nothing left to do") {
  for (const int dimension : {1, 2, 3, 5, 8}) {
    for (const bool periodic : {false, true}) {
      const Box box = uneven_box(dimension);
      for (const Layout layout :
           {Layout::random, Layout::grid, Layout::clusters, Layout::duplicates}) {
        for (const Masses kind : {Masses::even, Masses::heavy_tailed, Masses::whole_numbers}) {
          const auto points = make_points<double>(layout, box, 500);
          const auto masses = make_masses(kind, 500, 20);
          MassOptions options;
          options.points_per_site = 32;
          options.relaxation.threads = 1;
          if (periodic) options.domain = Domain::periodic(box);
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(name_of(layout));
          CAPTURE(static_cast<int>(kind));
          const auto result = tessellate_masses(points, masses, 18, options);
          CHECK(result.summary.termination == Termination::stable);
          CHECK(whole_faults(points, masses, options, result) == "");
          CHECK(stability_faults(points, masses, options.domain, result) == "");
          CHECK(result.shares.empty());
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("errors stay below the heaviest point, whatever the masses", Scalar, float,
                   double) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    ccvt::Random random(seed, 9);
    const int dimension = 1 + random.index_below(8);
    const Index sites = 2 + random.index_below(20);
    const Index count = sites + random.index_below(8 * sites);
    const Box box = uneven_box(dimension);
    const auto points = make_points<Scalar>(all_layouts[seed % 6], box, count, seed);
    std::vector<double> masses = make_masses(Masses::heavy_tailed, count, 1e9, seed);
    // As heavy as whole points may be: up to the mean capacity.
    for (int turn = 0; turn < 200; ++turn) {
      const double capacity = static_cast<double>(sum_of(masses)) / sites;
      for (double& mass : masses) mass = std::min(mass, capacity * (1 - 1e-12));
    }
    if (*std::max_element(masses.begin(), masses.end()) * sites > sum_of(masses)) continue;
    MassOptions options;
    options.points_per_site = 16;
    options.relaxation.threads = 1;
    options.relaxation.seed = seed;
    if (seed % 2 == 0) options.domain = Domain::periodic(box);
    CAPTURE(seed);
    const auto result = tessellate_masses(points, masses, sites, options);
    CHECK(whole_faults(points, masses, options, result) == "");
    for (const double mass : result.masses) CHECK(mass > 0);
  }
}

TEST_CASE("equal masses: exact where they divide, and what the unit tessellation calls stable") {
  for (const int dimension : {2, 3}) {
    const auto points = make_points<double>(Layout::random, Box::unit(dimension), 1200);
    const std::vector<double> masses = make_masses(Masses::equal, 1200);
    for (const Index sites : {40, 37}) {
      MassOptions options;
      options.points_per_site = 24;
      const auto result = tessellate_masses(points, masses, sites, options);
      CAPTURE(sites);
      CHECK(result.summary.termination == Termination::stable);
      if (sites == 40) CHECK(result.largest_mass_error < 1e-12);
      CHECK(result.largest_mass_error < 0.1);
      // As a problem of units whose capacities are what cells have.
      ccvt::Problem<double> problem(points, sites);
      std::vector<Index> sizes(at(sites), 0);
      for (const Index owner : result.owners) ++sizes[at(owner)];
      problem.set_capacities(sizes);
      CHECK(stability_faults(problem, Points<double>(result.sites), result.owners) == "");
      const auto units = tessellate(points, sites);
      CHECK(result.summary.energy ==
            doctest::Approx(0.1 * units.summary.energy).epsilon(sites == 40 ? 0.02 : 0.05));
    }
  }
}

TEST_CASE("small whole masses cost about what as many points each do") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 6000);
  const std::vector<double> masses = make_masses(Masses::whole_numbers, 6000);
  std::vector<Index> repeated;
  for (Index p = 0; p < 6000; ++p) repeated.insert(repeated.end(), at(Index(masses[at(p)])), p);
  const Points<double> units = points(Eigen::all, repeated);
  const auto by_units = tessellate(units, 100);
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    MassOptions options;
    options.method = method;
    const auto result = tessellate_masses(points, masses, 100, options);
    CAPTURE(to_string(method));
    CHECK(result.summary.energy == doctest::Approx(by_units.summary.energy).epsilon(0.01));
    CHECK(result.total_mass == static_cast<double>(repeated.size()));
  }
}

TEST_CASE("unequal capacities, and their scaling") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 3000);
  const std::vector<double> masses = make_masses(Masses::even, 3000);
  const double total = static_cast<double>(sum_of(masses));
  MassOptions options;
  for (const Index c : unequal_capacities(30)) options.capacities.push_back(c + 20);
  const double sum = static_cast<double>(sum_of(options.capacities));
  for (double& c : options.capacities) c *= total / sum * (1 + 5e-7);
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    options.method = method;
    const auto result = tessellate_masses(points, masses, 30, options);
    CHECK(static_cast<double>(sum_of(result.capacities)) == doctest::Approx(total).epsilon(1e-14));
    CHECK(result.relative_mass_error < 0.1);
    if (method == MassMethod::whole) CHECK(whole_faults(points, masses, options, result) == "");
  }
}

TEST_CASE("what is said of errors is of the cell that misses most of its own capacity") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 6000);
  const std::vector<double> masses = make_masses(Masses::even, 6000);
  MassOptions options;
  for (int s = 0; s < 40; ++s) options.capacities.push_back(s % 2 == 0 ? 1 : 7);
  for (double& c : options.capacities) c *= static_cast<double>(sum_of(masses)) / 160;
  int others = 0;  // than the one that misses most mass
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    options.method = method;
    const auto result = tessellate_masses(points, masses, 40, options);
    std::size_t worst = 0;
    const auto missed = [&](std::size_t s) {
      return std::abs(result.masses[s] / result.capacities[s] - 1);
    };
    for (std::size_t s = 1; s < result.masses.size(); ++s) {
      if (missed(s) > missed(worst)) worst = s;
    }
    if (worst != at(result.worst_site)) ++others;
    std::string brief =
        "largest mass error " + ccvt::text(100 * missed(worst), 3) + " % of its cell's capacity";
    if (method == MassMethod::whole) {
      brief += ", bound " +
               ccvt::text(100 * result.mass_error_bound / result.capacities[worst], 3) + " %";
    }
    CHECK(result.brief_error() == brief);
  }
  CHECK(others > 0);
}

TEST_CASE_TEMPLATE("no number of threads changes a bit", Scalar, float, double) {
  for (const int dimension : {2, 3}) {
    const Box box = uneven_box(dimension);
    const auto points = make_points<Scalar>(Layout::random, box, 9000);
    const auto masses = make_masses(Masses::heavy_tailed, 9000, 50);
    for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
      MassOptions options;
      options.method = method;
      options.points_per_site = 64;
      options.domain = Domain::periodic(box);
      options.relaxation.threads = 1;
      const auto one = tessellate_masses(points, masses, 150, options);
      for (const int threads : {2, 3}) {
        options.relaxation.threads = threads;
        CHECK(mass_differences(one, tessellate_masses(points, masses, 150, options)) == "");
      }
      options.relaxation.seed = 2;
      CHECK(mass_differences(one, tessellate_masses(points, masses, 150, options)) != "");
    }
  }
}

TEST_CASE("the unit of mass does not matter, from the smallest to the largest") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 2000);
  const auto masses = make_masses(Masses::even, 2000);
  const auto one = tessellate_masses(points, masses, 40);
  for (const int power : {-900, -30, 300}) {
    std::vector<double> scaled = masses;
    for (double& mass : scaled) mass = std::ldexp(mass, power);
    const auto other = tessellate_masses(points, scaled, 40);
    CHECK(other.owners == one.owners);
    CHECK(other.sites == one.sites);
    CHECK(other.summary.energy == std::ldexp(one.summary.energy, power));
    CHECK(other.largest_mass_error == std::ldexp(one.largest_mass_error, power));
  }
}

TEST_CASE("points without mass count for nothing and go to the nearest site") {
  const Box box = Box::unit(2);
  const auto all = make_points<double>(Layout::random, box, 3000);
  auto masses = make_masses(Masses::even, 3000);
  std::vector<Index> heavy;
  std::vector<double> positive;
  for (Index p = 0; p < 3000; ++p) {
    if (p % 3 == 1) {
      masses[at(p)] = 0;
    } else {
      heavy.push_back(p);
      positive.push_back(masses[at(p)]);
    }
  }
  const Points<double> some = all(Eigen::all, heavy);
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    MassOptions options;
    options.method = method;
    options.domain = Domain::periodic(box);
    const auto with = tessellate_masses(all, masses, 40, options);
    const auto without = tessellate_masses(some, positive, 40, options);
    CHECK(with.sites == without.sites);
    CHECK(with.masses == without.masses);
    for (std::size_t k = 0; k < heavy.size(); ++k) {
      REQUIRE(with.owners[at(heavy[k])] == without.owners[k]);
    }
    for (Index p = 1; p < 3000; p += 3) {
      Index nearest = 0;
      const auto squared = [&](Index s) {
        return squared_distance(options.domain, 2, all.col(p).data(), with.sites.col(s).data());
      };
      for (Index s = 1; s < 40; ++s) nearest = squared(s) < squared(nearest) ? s : nearest;
      REQUIRE(static_cast<double>(squared(with.owners[at(p)])) ==
              doctest::Approx(static_cast<double>(squared(nearest))));
    }
  }
}

TEST_CASE("resampled: heavy points are shared, capacities are exact in units") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 400);
  auto masses = make_masses(Masses::even, 400);
  masses[7] = 150;  // of about 550 in 20 cells
  MassOptions options;
  options.method = MassMethod::resampled;
  options.points_per_site = 200;
  const auto result = tessellate_masses(points, masses, 20, options);
  CHECK(result.shared_points >= 1);
  CHECK(std::isinf(result.mass_error_bound));
  std::vector<Real> of_point(400, 0);
  std::vector<Real> of_site(20, 0);
  Index sites_of_heavy = 0;
  for (std::size_t k = 0; k < result.shares.size(); ++k) {
    const ccvt::MassShare& share = result.shares[k];
    of_point[at(share.point)] += share.mass;
    of_site[at(share.site)] += share.mass;
    if (share.point == 7) ++sites_of_heavy;
    if (k == 0) continue;
    const ccvt::MassShare& last = result.shares[k - 1];
    CHECK((last.point < share.point || (last.point == share.point && last.site < share.site)));
  }
  CHECK(sites_of_heavy >= 5);
  for (std::size_t p = 0; p < masses.size(); ++p) {
    CHECK(static_cast<double>(of_point[p]) == doctest::Approx(masses[p]).epsilon(1e-12));
  }
  const double capacity = result.total_mass / 20;
  for (std::size_t s = 0; s < of_site.size(); ++s) {
    CHECK(result.masses[s] == doctest::Approx(static_cast<double>(of_site[s])).epsilon(1e-12));
    // Points are no fewer units than their mass less one, and there are about 20 in a cell.
    CHECK(std::abs(result.masses[s] - capacity) < 0.1 * capacity);
  }
  CHECK(message_of([&] { tessellate_masses(points, masses, 20); }).find("masses[7] is 150") == 0);
}

TEST_CASE("it ends when told to, with all masses within the bound") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 20000);
  const auto masses = make_masses(Masses::even, 20000);
  MassOptions options;
  options.points_per_site = 64;
  for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
    options.method = method;
    const auto faults = [&](const MassResult<double>& result) {
      return method == MassMethod::whole ? whole_faults(points, masses, options, result) : "";
    };
    int last = 0;
    double progress = 0;
    bool consecutive = true;
    options.relaxation = {};
    options.relaxation.on_iteration = [&](const ccvt::IterationRecord& record) {
      consecutive = consecutive && record.iteration == ++last && record.progress >= progress &&
                    record.level < record.levels;
      progress = record.progress;
      return true;
    };
    const auto whole_run = tessellate_masses(points, masses, 200, options);
    CHECK(consecutive);
    CHECK(progress == doctest::Approx(1));
    CHECK(whole_run.summary.iterations == last);
    CHECK(whole_run.summary.iterations_log.size() == at(last));

    for (const int stop_at : {2, last - 1}) {
      options.relaxation.on_iteration = [&](const ccvt::IterationRecord& record) {
        return record.iteration < stop_at;
      };
      const auto told = tessellate_masses(points, masses, 200, options);
      CHECK(told.summary.termination == Termination::cancelled);
      CHECK(told.summary.iterations == stop_at);
      CHECK(faults(told) == "");
    }
    options.relaxation.on_iteration = {};
    options.relaxation.max_iterations = last - 1;
    const auto limited = tessellate_masses(points, masses, 200, options);
    CHECK(limited.summary.termination == Termination::iteration_limit);
    CHECK(limited.summary.iterations == last - 1);
    CHECK(faults(limited) == "");
    options.relaxation.max_iterations = 1000;
    options.relaxation.energy_tolerance = 0.01;
    CHECK(tessellate_masses(points, masses, 200, options).summary.termination ==
          Termination::energy_tolerance);
  }
}

TEST_CASE("cancelled while unit points move, a run ends with what has been reached") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 20000);
  const auto masses = make_masses(Masses::even, 20000);
  for (const int stop_at : {1, 4, 16}) {
    MassOptions options;
    int seen = 0;
    options.relaxation.on_iteration = [&](const ccvt::IterationRecord&) { return ++seen > 0; };
    options.relaxation.cancelled = [&] { return seen >= stop_at; };
    const auto result = tessellate_masses(points, masses, 200, options);
    CHECK(result.summary.termination == Termination::cancelled);
    CHECK(result.summary.iterations <= stop_at + 1);
    CHECK(whole_faults(points, masses, options, result) == "");
  }
}

TEST_CASE("a cancelled run ends soon, at whatever time") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 60000);
  const auto masses = make_masses(Masses::even, 60000);
  using Clock = std::chrono::steady_clock;
  double seconds = 0;  // of a run to its end
  for (int after = 0;; after = after * 2 + 1) {
    int asked = 0;
    Clock::time_point said;
    MassOptions options;
    options.relaxation.cancelled = [&] {
      if (asked++ == after) said = Clock::now();
      return asked > after;
    };
    bool cancelled = false;
    try {
      const auto result = tessellate_masses(points, masses, 300, options);
      cancelled = result.summary.termination == Termination::cancelled;
      seconds = result.summary.seconds_total;
      CHECK(whole_faults(points, masses, options, result) == "");
      if (!cancelled) CHECK(result.summary.termination == Termination::stable);
    } catch (const ccvt::Cancelled&) {
      cancelled = true;
    }
    if (!cancelled) break;
    CHECK(std::chrono::duration<double>(Clock::now() - said).count() < 2);
  }
  MassOptions options;
  CHECK(catch_in_time(std::chrono::duration<double>(seconds / 2), [&](const auto& limit) {
    options.relaxation.time_limit = limit.count();
    try {
      const auto result = tessellate_masses(points, masses, 300, options);
      CHECK(whole_faults(points, masses, options, result) == "");
      const bool limited = result.summary.termination == Termination::time_limit;
      return limited ? Caught::in_time : Caught::too_late;
    } catch (const ccvt::Cancelled&) {
      return Caught::too_early;
    }
  }));
}

TEST_CASE("bad input is refused in one line") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 10);
  const std::vector<double> masses(10, 2.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto said = [&](std::vector<double> wrong, Index sites, const MassOptions& options = {}) {
    return message_of([&] { tessellate_masses(points, wrong, sites, options); });
  };
  const auto with = [&](std::size_t p, double mass) {
    std::vector<double> wrong = masses;
    wrong[p] = mass;
    return said(wrong, 3);
  };
  CHECK(said(masses, 3) == "nothing thrown");
  CHECK(said({1, 2}, 3) == "masses: there are 2 for 10 points: there must be one per point");
  CHECK(with(3, -1) == "masses[3] is -1: it must be finite, not negative and at most 1e+100");
  CHECK(with(4, nan) == "masses[4] is nan: it must be finite, not negative and at most 1e+100");
  CHECK(with(4, 1e101) ==
        "masses[4] is 1e+101: it must be finite, not negative and at most 1e+100");
  CHECK(said(std::vector<double>(10, 0.0), 3) == "masses: all are 0: some must be positive");
  for (const double tiny : {5e-324, 1e-310, 1e-290}) {
    for (const MassMethod method : {MassMethod::whole, MassMethod::resampled}) {
      const std::string sum = said(std::vector<double>(10, tiny), 3, {.method = method});
      CHECK(sum.find("masses: they sum to ") == 0);
      CHECK(sum.find(": it must be at least 1e-280 and at most 1e+100") != std::string::npos);
    }
  }
  CHECK(said(std::vector<double>(10, 0x1p330), 3).find("masses: they sum to 2.1") == 0);
  CHECK(with(5, 30) ==
        "masses[5] is 30, more than the capacity of site 0, 16 (too heavy: 1 point): whole points "
        "must fit, as they do with at most 1 site; the method resampled shares heavy points among "
        "sites");
  CHECK(said(masses, 11) ==
        "masses[0] is 2, more than the capacity of site 0, 1.81818 (too heavy: 10 points): whole "
        "points must fit, as they do with at most 10 sites; the method resampled shares heavy "
        "points among sites");
  CHECK(said(masses, 0) == "sites: is 0; must be at least 1");
  MassOptions options;
  options.points_per_site = 0;
  CHECK(said(masses, 3, options) == "MassOptions::points_per_site is 0: it must be 1 or more");
  options = {};
  options.capacities = {1, 2};
  CHECK(said(masses, 3, options) ==
        "capacities: there are 2 for 3 sites: there must be one per site");
  options.capacities = {10, 0, 10};
  CHECK(said(masses, 3, options) == "capacities[1] is 0: it must be a positive finite mass");
  options.capacities = {10, 5, 6};
  CHECK(said(masses, 3, options) ==
        "capacities: they sum to 21, the masses to 20: the two must be equal");
  options = {};
  options.relaxation.threads = -1;
  CHECK(said(masses, 3, options).find("Options::threads is -1") == 0);
  options = {};
  options.domain = Domain::euclidean(Box{{0, 0}, {0.5, 0.5}});
  CHECK(said(masses, 3, options).find("points: coordinate") == 0);
  CHECK(message_of([&] { tessellate_masses(Points<double>(2, 0), {}, 3); }) ==
        "points: there are none");
}

TEST_SUITE_END();
