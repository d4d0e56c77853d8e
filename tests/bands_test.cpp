// Bands of pairs of cells and sums of cells, both against going over all points.
#include "relax/bands.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "relax/swap.h"
#include "relax/update.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Arena;
using ccvt::Bands;
using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::KnownPair;
using ccvt::Metric;
using ccvt::Options;
using ccvt::PairSwapper;
using ccvt::Patches;
using ccvt::PointOfAll;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::SwapMethod;
using namespace ccvt::test;

namespace {

/// Cells that are relaxed pair by pair.
template <class Scalar>
struct Relaxed {
  Relaxed(const Metric& its_metric, const ccvt::Points<Scalar>& points,
          const std::vector<Index>& sizes)
      : metric(its_metric),
        cells(metric.dimension(), sizes),
        sites(metric.dimension(), static_cast<Index>(sizes.size())),
        patches(metric.dimension(), sizes),
        bands(sizes.size()) {
    Index p = 0;
    for (const SiteNumber s : cells.sites()) {
      for (Index k = 0; k < cells.size(s); ++k, ++p) {
        cells.put(s, k, PointOfAll(p), points.col(p).data());
      }
      std::copy_n(points.col(p - 1).data(), metric.dimension(), sites.at(s));
      ccvt::update_site(metric, cells, sites, s);
    }
    // So often looked at that they are divided.
    typename Patches<Scalar>::Scratch scratch;
    for (int look = 0; look < 64; ++look) {
      for (const SiteNumber s : cells.sites()) patches.look(cells, s, scratch);
    }
  }

  /// All pairs, or those the other way round. Returns how many points have moved.
  Index pass(PairSwapper<Scalar>& swap, bool with_bands, bool reversed = false) {
    Index moved = 0;
    bands.begin_pass(Arena(1));
    for (const SiteNumber i : cells.sites()) {
      for (const SiteNumber j : cells.sites().after(i)) {
        Bands<Scalar>* const given = with_bands ? &bands : nullptr;
        moved += reversed ? swap(cells, patches, sites, j, i, given)
                          : swap(cells, patches, sites, i, j, given);
      }
    }
    return moved;
  }

  const Metric& metric;
  Cells<Scalar> cells;
  SiteState sites;
  Patches<Scalar> patches;
  Bands<Scalar> bands;
};

template <class Scalar>
bool same_places(const Cells<Scalar>& a, const Cells<Scalar>& b) {
  for (const SiteNumber s : a.sites()) {
    for (Index k = 0; k < a.size(s); ++k) {
      if (a.point(s, k) != b.point(s, k)) return false;
    }
  }
  return true;
}

/// By all bands: how often they have told what to exchange since they were made, and how many pairs
/// are known to be apart.
struct Uses {
  int bands = 0;
  int apart = 0;
};
template <class Scalar>
Uses uses(const Relaxed<Scalar>& relaxed) {
  Uses all;
  for (const SiteNumber i : relaxed.cells.sites()) {
    for (const SiteNumber j : relaxed.cells.sites().after(i)) {
      const KnownPair<Scalar>* const known = relaxed.bands.find(relaxed.cells, i, j);
      if (known == nullptr || known->band == nullptr) continue;
      if (known->band->valid) all.bands += known->band->uses;
      all.apart += known->apart.is_known() ? 1 : 0;
    }
  }
  return all;
}

/// Relaxes both, and requires that the same points change places; returns how often bands served.
template <class Scalar>
Uses relax_both(const Metric& metric, const Options& options, double coordinate_bound,
                const ccvt::Points<Scalar>& points, const std::vector<Index>& sizes) {
  PairSwapper<Scalar> swap(metric, options, coordinate_bound);
  Relaxed<Scalar> with(metric, points, sizes);
  Relaxed<Scalar> without(metric, points, sizes);
  Uses used;
  for (int pass = 0; pass < 40; ++pass) {
    const bool reversed = pass % 16 == 15;
    const Index moved = without.pass(swap, false, reversed);
    REQUIRE(with.pass(swap, true, reversed) == moved);
    REQUIRE(same_places(with.cells, without.cells));
    REQUIRE(with.sites.radius == without.sites.radius);
    for (const SiteNumber s : with.cells.sites()) {
      ccvt::update_site(metric, with.cells, with.sites, s);
      ccvt::update_site(metric, without.cells, without.sites, s);
    }
    const Uses now = uses(with);
    used = {std::max(used.bands, now.bands), std::max(used.apart, now.apart)};
  }
  return used;
}

}  // namespace

TEST_SUITE("bands") {
  TEST_CASE_TEMPLATE("the same points change places with bands as without", Scalar, float, double) {
    struct Case {
      int dimension;
      std::vector<Index> sizes;
      int bands_used = 0;  ///< more often
    };
    for (const Case& c :
         {Case{1, {500, 900, 700}}, Case{2, {4000, 5000, 4500, 300, 40, 3700, 4200, 3600}, 10},
          Case{2, {6000, 300, 3, 100, 40, 500, 16, 200}, 5}, Case{3, {29000, 31000, 200}}}) {
      Index count = 0;
      for (const Index size : c.sizes) count += size;
      for (const bool periodic : {false, true}) {
        for (const Layout layout : all_layouts) {
          for (const SwapMethod method : {SwapMethod::median, SwapMethod::sort}) {
            if (method == SwapMethod::sort && layout != Layout::duplicates) continue;
            CAPTURE(c.dimension);
            CAPTURE(periodic);
            CAPTURE(name_of(layout));
            const Box box = uneven_box(c.dimension);
            const Metric metric(c.dimension, periodic ? Domain::periodic(box) : Domain());
            const auto points = make_points<Scalar>(layout, box, count);
            Options options;
            options.swap = method;
            const Uses used = relax_both(metric, options, 6.0, points, c.sizes);
            const bool ties = layout == Layout::two_places || layout == Layout::one_place;
            if (c.dimension != 2 || periodic || ties) continue;
            CHECK(used.bands > c.bands_used);
            CHECK(used.apart > 0);
          }
        }
      }
    }
  }

  TEST_CASE("of many pairs that meet, few are kept") {
    // Of one size, so that the first site of a pair keeps it.
    const Cells<float> cells(1, std::vector<Index>(200, 500));
    constexpr SiteNumber first(0);
    Bands<float> bands(200);
    const auto look = [&](Index begin, Index end) {
      bands.begin_pass(Arena(1));
      int known = 0;
      for (Index j = begin; j < end; ++j) {
        known += bands.of(cells, first, SiteNumber(j)) != nullptr ? 1 : 0;
      }
      return known;
    };
    const auto kept = [&] {
      int found = 0;
      for (const SiteNumber j : cells.sites().after(first)) {
        found += bands.find(cells, first, j) != nullptr ? 1 : 0;
      }
      return found;
    };
    CHECK(look(1, 200) == 0);  // the first pass
    CHECK(kept() == 0);
    CHECK(look(1, 200) == 64);
    CHECK(kept() == 64);
    CHECK(look(190, 200) == 0);  // no more
    for (int pass = 0; pass < 40; ++pass) look(60, 63);
    CHECK(kept() == 3);  // the others were not looked at for long
    CHECK(look(190, 200) == 10);
    for (int pass = 0; pass < 40; ++pass) look(60, 63);
    CHECK(kept() == 13);  // few
    bands.forget();
    CHECK(kept() == 0);
    CHECK(look(1, 200) == 0);
  }

  // Far from the origin coordinates are coarse, and the kernels' cut is rounded as they are. What
  // rounding can feign is as large as a band is wide: of points with one key the same ones move.
  TEST_CASE_TEMPLATE("bands far from the origin", Scalar, float, double) {
    const double offsets[] = {1e3, 1e5, std::is_same_v<Scalar, float> ? 3e5 : 1e12};
    for (const double offset : offsets) {
      for (const Layout layout : {Layout::random, Layout::duplicates, Layout::grid}) {
        CAPTURE(offset);
        CAPTURE(name_of(layout));
        const Metric metric(2, Domain());
        auto points = make_points<Scalar>(layout, Box::unit(2), 20000);
        for (Index p = 0; p < 20000; ++p) points(0, p) += static_cast<Scalar>(offset);
        relax_both(metric, Options{}, offset + 1, points, std::vector<Index>(5, 4000));
      }
    }
  }

  TEST_CASE_TEMPLATE("sums follow exchanges: site, radius and energy are those of all points",
                     Scalar, float, double) {
    for (const int dimension : {2, 3}) {
      for (const bool periodic : {false, true}) {
        if (dimension == 3 && periodic) continue;  // it would take many cells
        CAPTURE(dimension);
        CAPTURE(periodic);
        const Box box = uneven_box(dimension);
        const Metric metric(dimension, periodic ? Domain::periodic(box) : Domain());
        // On a torus, so many that the cells are small.
        const std::vector<Index> sizes(dimension == 3 ? 3
                                       : periodic     ? 24
                                                      : 5,
                                       dimension == 3 ? 29000 : 4000);
        const auto count = static_cast<Index>(sizes.size()) * sizes.front();
        PairSwapper<Scalar> swap(metric, Options{}, 6.0);
        Relaxed<Scalar> summed(metric, make_points<Scalar>(Layout::random, box, count), sizes);
        int by_sums = 0;
        for (int pass = 0; pass < 60; ++pass) {
          const Index moved = summed.pass(swap, true);
          for (const SiteNumber s : summed.cells.sites()) {
            SiteState all = summed.sites;
            ccvt::update_site(metric, summed.cells, all, s);
            if (!ccvt::update_by_sums(metric, summed.patches, summed.sites, s,
                                      summed.cells.size(s))) {
              summed.sites = all;
              ccvt::begin_sums(summed.patches, summed.sites, s);
              continue;
            }
            by_sums += moved > 0 ? 1 : 0;
            for (int d = 0; d < dimension; ++d) {
              REQUIRE(std::abs(summed.sites.at(s)[d] - all.at(s)[d]) < 1e-14);
            }
            REQUIRE(summed.sites.energy[s] == doctest::Approx(all.energy[s]).epsilon(1e-12));
            REQUIRE(summed.sites.radius[s] >= all.radius[s]);
            REQUIRE(summed.sites.radius[s] < 1.1 * all.radius[s]);
            REQUIRE(summed.sites.compact[s] == all.compact[s]);
          }
        }
        CHECK(by_sums > 20);
      }
    }
  }

  TEST_CASE("sums are made anew after many exchanges, and are not kept where they may be wrong") {
    const Metric metric(2, Domain());
    const auto points = make_points<float>(Layout::random, Box::unit(2), 9000);
    Relaxed<float> relaxed(metric, points, {4000, 4900, 100});  // the last one is not divided
    constexpr SiteNumber first(0);
    const auto kept = [&] {
      return ccvt::update_by_sums(metric, relaxed.patches, relaxed.sites, first, 4000);
    };
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    CHECK(kept());
    ccvt::begin_sums(relaxed.patches, relaxed.sites, SiteNumber(2));
    CHECK_FALSE(ccvt::update_by_sums(metric, relaxed.patches, relaxed.sites, SiteNumber(2), 100));
    const auto replace = [&](int times) {
      const float x[] = {relaxed.cells.block(first)[0], relaxed.cells.block(first)[4000]};
      for (int k = 0; k < times; ++k) relaxed.patches.replace(first, 0, x, x);
    };
    replace(500);
    CHECK(kept());
    replace(1);
    CHECK_FALSE(kept());

    const SiteState as_it_was = relaxed.sites;
    const auto begin = [&] {
      relaxed.sites = as_it_was;
      ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    };
    begin();
    relaxed.sites.compact[first] = 0;
    CHECK_FALSE(kept());
    relaxed.sites.compact[first] = 0;
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    relaxed.sites.compact[first] = 1;
    CHECK_FALSE(kept());

    begin();
    for (int update = 0; update < 32; ++update) CHECK(kept());
    CHECK_FALSE(kept());

    // One in 4000 goes to a place that moves the site by a 100th of the radius, or half of that.
    for (const double share : {0.005, 0.01}) {
      begin();
      const float x[] = {relaxed.cells.block(first)[0], relaxed.cells.block(first)[4000]};
      const auto by = static_cast<float>(share * relaxed.sites.radius[first] * 4000);
      const float to[] = {x[0] + by, x[1]};
      relaxed.patches.replace(first, 0, to, x);
      CHECK(kept() == (share < 0x1p-7));
    }

    // A point far away leaves, which had most of the energy.
    const float near[] = {0.5F, 0.5F};
    const float far[] = {10.0F, 0.5F};
    begin();
    relaxed.sites.radius[first] = 10;
    relaxed.sites.energy[first] = 100;
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    relaxed.patches.replace(first, 0, near, far);
    CHECK_FALSE(kept());

    // To add to a coordinate takes more rounding than is allowed for.
    begin();
    CHECK(kept());
    relaxed.sites.radius[first] = 1e-3;
    CHECK_FALSE(kept());
  }

  TEST_CASE(
      "sums are not kept of a cell that may cross the faces of a torus, or has a fixed site") {
    const Metric torus(2, Domain::periodic(Box::unit(2)));
    auto points = make_points<float>(Layout::random, Box::unit(2), 9000);
    for (Index p = 0; p < 4000; ++p) {
      points(0, p) = 0.45F + 0.1F * points(0, p);
      points(1, p) = 0.45F + 0.1F * points(1, p);
    }
    Relaxed<float> relaxed(torus, points, {4000, 5000});
    constexpr SiteNumber first(0);
    const auto kept = [&] {
      return ccvt::update_by_sums(torus, relaxed.patches, relaxed.sites, first, 4000);
    };
    REQUIRE(relaxed.sites.compact[first] == 1);
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    CHECK(kept());
    for (const double radius : {0.3, 0.6}) {
      relaxed.sites.radius[first] = radius;
      CHECK_FALSE(kept());
    }
    relaxed.sites.radius[first] = 0.1;
    relaxed.sites.at(first)[0] = 0.05;
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    CHECK_FALSE(kept());
    relaxed.sites.at(first)[0] = 0.5;
    relaxed.sites.fixed.assign(2, 1);
    ccvt::begin_sums(relaxed.patches, relaxed.sites, first);
    CHECK_FALSE(kept());
  }
}
