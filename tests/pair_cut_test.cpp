// The cut between two cells, against the energies of their points at both sites.
#include "relax/pair_cut.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "random.h"
#include "relax/update.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::PairCut;
using ccvt::PointOfAll;
using ccvt::Points;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::SiteState;
using namespace ccvt::test;

namespace {

constexpr Index kPoints = 37;

/// Two balls of points in a domain, their centres a step apart.
template <class Scalar>
struct Pair {
  Pair(const Metric& metric, const Box& box, Random& random, double radius)
      : cells(metric.dimension(), std::vector<Index>{kPoints, kPoints}),
        sites(metric.dimension(), 2) {
    const int dimension = metric.dimension();
    std::vector<double> centre;
    for (int d = 0; d < dimension; ++d) {
      centre.push_back(box.lower[d] + random.uniform() * box.extent()[d]);
    }
    std::vector<Scalar> x(static_cast<std::size_t>(dimension));
    for (const SiteNumber cell : ccvt::sites_below(2)) {
      for (Index k = 0; k < kPoints; ++k) {
        for (int d = 0; d < dimension; ++d) {
          const auto e = static_cast<std::size_t>(d);
          const double offset = radius * (2 * random.uniform() - 1) * box.extent()[d];
          x[e] = metric.as<Scalar>(metric.into_box(centre[e] + offset, d), d);
        }
        cells.put(cell, k, PointOfAll(cell.index() * kPoints + k), x.data());
      }
      for (int d = 0; d < dimension; ++d) {
        sites.at(cell)[d] = metric.into_box(centre[static_cast<std::size_t>(d)], d);
        centre[static_cast<std::size_t>(d)] += radius * random.uniform() * box.extent()[d];
      }
      update_site(metric, cells, sites, cell);
    }
  }

  Cells<Scalar> cells;
  SiteState sites;
};

/// The least and the greatest error of keys. What all share does not matter: where both cells see
/// the same cut, that is the rounding of its place.
struct Errors {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;

  void add(double error) {
    least = std::min(least, error);
    greatest = std::max(greatest, error);
  }
};

struct Checked {
  Errors in_double;
  Errors in_kernels;
  bool same_one_by_one = true;
};

template <class Scalar, class AnyCut>
void check_keys(const Domain& domain, const Pair<Scalar>& pair, const PairCut<Scalar>& cut,
                typename PairCut<Scalar>::Side side, const AnyCut& seen, Checked& checked) {
  const auto dimension = static_cast<int>(pair.cells.dimension());
  const SiteNumber cell(side == PairCut<Scalar>::Side::i ? 0 : 1);
  const Scalar* block = pair.cells.block(cell);
  std::vector<double> added(kPoints, 0.0);
  cut.add_keys(side, block, kPoints, added.data());
  std::vector<Scalar> keys(kPoints);
  ccvt::kernels::keys(block, kPoints, dimension, seen, keys.data());
  const auto extremes =
      ccvt::kernels::key_extremes(block, kPoints, seen, block, kPoints, seen, dimension);
  auto lowest = std::numeric_limits<Real>::infinity();
  auto highest = -lowest;
  std::vector<Scalar> x(static_cast<std::size_t>(dimension));
  for (Index k = 0; k < kPoints; ++k) {
    pair.cells.get(cell, k, x.data());
    const auto squared = [&](Index site) {
      return squared_distance(domain, dimension, x.data(), pair.sites.at(SiteNumber(site)));
    };
    const Real exact = (squared(0) - squared(1)) / 2;
    const double key = cut.key(side, block, kPoints, k);
    checked.same_one_by_one &= key == added[static_cast<std::size_t>(k)];
    checked.in_double.add(static_cast<double>(key - exact));
    checked.in_kernels.add(static_cast<double>(keys[static_cast<std::size_t>(k)] - exact));
    lowest = std::min(lowest, exact);
    highest = std::max(highest, exact);
  }
  checked.in_kernels.add(static_cast<double>(extremes.lowest_j - lowest));
  checked.in_kernels.add(static_cast<double>(extremes.highest_i - highest));
}

/// By how much bounds on the kernels' keys of points, each a box, are loose: at least and at most.
template <class Scalar, class AnyCut>
Errors looseness(const Pair<Scalar>& pair, const PairCut<Scalar>& cut,
                 typename PairCut<Scalar>::Side side, const AnyCut& seen) {
  const bool above = side == PairCut<Scalar>::Side::i;
  const auto dimension = static_cast<int>(pair.cells.dimension());
  const Scalar* block = pair.cells.block(SiteNumber(above ? 0 : 1));
  std::vector<Scalar> low;
  std::vector<Scalar> high;
  for (int d = 0; d < dimension; ++d, block += kPoints) {
    low.insert(low.end(), block, block + kPoints);
    high.insert(high.end(), block, block + kPoints);
    low.push_back(*std::min_element(block, block + kPoints));
    high.push_back(*std::max_element(block, block + kPoints));
  }
  std::vector<double> bounds;
  cut.bound_keys(side, low, high, bounds);
  REQUIRE(bounds.size() == kPoints);
  block = pair.cells.block(SiteNumber(above ? 0 : 1));
  Errors errors;
  for (Index k = 0; k < kPoints; ++k) {
    const double key = ccvt::kernels::extreme_key(block + k, kPoints, 1, dimension, seen,
                                                  ccvt::kernels::Beyond::above);
    const double bound = bounds[static_cast<std::size_t>(k)];
    errors.add(above ? bound - key : key - bound);
  }
  return errors;
}

/// A cut kept for one side, with a box that is first around half of the cell's points.
template <class Scalar>
struct KeptCut {
  using Cut = PairCut<Scalar>;

  KeptCut(const Pair<Scalar>& pair, const Cut& cut, typename Cut::Side its_side)
      : side(its_side), cell(side == Cut::Side::i ? 0 : 1), block(pair.cells.block(cell)) {
    std::vector<Scalar> low;
    std::vector<Scalar> high;
    std::vector<Scalar> ends;
    for (std::size_t d = 0; d < pair.cells.dimension(); ++d) {
      const Scalar* const stream = block + static_cast<Index>(d) * kPoints;
      const auto half = std::minmax_element(stream, stream + kPoints / 2);
      const auto rest = std::minmax_element(stream + kPoints / 2, stream + kPoints);
      low.push_back(*half.first);
      high.push_back(*half.second);
      ends.insert(ends.end(), {*rest.first, *rest.second});
    }
    cut.keep(side, low, high, kept);
    kept.extend(ends);
    limit = extreme(cut);
  }

  /// Of the kernels' keys of all points, the one farthest on the other side.
  [[nodiscard]] double extreme(const Cut& cut) const {
    return ccvt::kernels::extreme_key(
        block, kPoints, kPoints, static_cast<int>(kept.dimension()), cut.straight_cut(side),
        side == Cut::Side::i ? ccvt::kernels::Beyond::above : ccvt::kernels::Beyond::below);
  }
  [[nodiscard]] double exact_extreme(const Cut& cut) const {
    std::vector<double> keys(kPoints, 0.0);
    cut.add_keys(side, block, kPoints, keys.data());
    return side == Cut::Side::i ? *std::max_element(keys.begin(), keys.end())
                                : *std::min_element(keys.begin(), keys.end());
  }

  typename Cut::Side side;
  SiteNumber cell;
  const Scalar* block;
  typename Cut::Kept kept;
  double limit = 0;
};

/// Both sites along each dimension, by no more than that; returns the sum of what they have moved.
template <class Scalar>
double move_sites(Pair<Scalar>& pair, double most, Random& random) {
  double moved = 0;
  for (const SiteNumber s : ccvt::sites_below(2)) {
    for (std::size_t d = 0; d < pair.sites.dimension; ++d) {
      const double by = most * (2 * random.uniform() - 1);
      pair.sites.at(s)[d] += by;
      moved += std::abs(by);
    }
    pair.sites.radius[s] += moved;
  }
  return moved;
}

/// That the kept cut bounds what keys are now, loose by no more than that and rounding.
template <class Scalar>
void check_bounds(const KeptCut<Scalar>& kept, const PairCut<Scalar>& cut, double loose) {
  const double sign = kept.side == PairCut<Scalar>::Side::i ? 1 : -1;
  const double extreme = kept.extreme(cut);
  const double exact = kept.exact_extreme(cut);
  const auto bounds = cut.bounds_since(kept.side, kept.kept, kept.limit);
  REQUIRE(sign * (bounds.of_kernels - extreme) >= 0);
  REQUIRE(sign * (bounds.exact - exact) >= 0);
  REQUIRE(sign * (bounds.of_kernels - extreme) <= loose + 8 * cut.tolerance());
  REQUIRE(std::abs(extreme - exact - cut.kernels_differ(kept.side)) <= 2 * cut.tolerance());
}

}  // namespace

TEST_SUITE_BEGIN("swap");

TEST_CASE_TEMPLATE("keys are half the difference of the energies at both sites", Scalar, float,
                   double) {
  using Side = typename PairCut<Scalar>::Side;
  int plain = 0;
  int face = 0;
  int wrapped = 0;
  int torus = 0;
  for (const int dimension : {1, 2, 3, 5}) {
    for (const bool periodic : {false, true}) {
      const Box box = uneven_box(dimension);
      const Domain domain = periodic ? Domain::periodic(box) : Domain();
      const Metric metric(dimension, domain);
      const double bound = std::max(box.lower.eigen().array().abs().maxCoeff(),
                                    box.upper.eigen().array().abs().maxCoeff());
      PairCut<Scalar> cut(metric, bound + 1);
      for (const double radius : {1e-3, 0.05, 0.15, 0.4}) {
        Random random(1, static_cast<std::uint64_t>(dimension));
        for (int trial = 0; trial < 100; ++trial) {
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(radius);
          CAPTURE(trial);
          const Pair<Scalar> pair(metric, box, random, radius);
          cut.place(pair.sites, SiteNumber(0), SiteNumber(1));
          Checked checked;
          cut.with_kernels([&](const auto& cut_i, const auto& cut_j) {
            using AnyCut = std::decay_t<decltype(cut_i)>;
            plain += std::is_same_v<AnyCut, ccvt::kernels::Cut<Scalar>> ? 1 : 0;
            face += std::is_same_v<AnyCut, ccvt::kernels::FaceCut<Scalar>> ? 1 : 0;
            wrapped += std::is_same_v<AnyCut, ccvt::kernels::WrappedCut<Scalar>> ? 1 : 0;
            torus += std::is_same_v<AnyCut, ccvt::kernels::TorusCut<Scalar>> ? 1 : 0;
            check_keys(domain, pair, cut, Side::i, cut_i, checked);
            check_keys(domain, pair, cut, Side::j, cut_j, checked);
          });
          if (cut.straight()) {
            cut.with_kernels([&](const auto& cut_i, const auto& cut_j) {
              for (const Errors& errors :
                   {looseness(pair, cut, Side::i, cut_i), looseness(pair, cut, Side::j, cut_j)}) {
                REQUIRE(errors.least >= 0);
                REQUIRE(errors.greatest <= 3 * cut.tolerance());
              }
            });
          }
          REQUIRE(checked.same_one_by_one);
          REQUIRE(checked.in_double.greatest - checked.in_double.least <= 2 * cut.rounding());
          REQUIRE(checked.in_kernels.greatest - checked.in_kernels.least <= 2 * cut.tolerance());
        }
      }
    }
  }
  // Every kind of cut was there.
  CHECK(plain > 100);
  CHECK(face > 100);
  CHECK(wrapped > 100);
  CHECK(torus > 100);
}

TEST_CASE_TEMPLATE("a cut that was kept bounds the keys by a later one", Scalar, float, double) {
  using Side = typename PairCut<Scalar>::Side;
  int bounded = 0;
  for (const int dimension : {1, 2, 3, 5}) {
    for (const bool periodic : {false, true}) {
      for (const double offset : {0.0, 1e4}) {
        if (periodic && offset > 0) continue;
        Box box = uneven_box(dimension);
        for (int d = 0; d < dimension; ++d) {
          box.lower[d] += offset;
          box.upper[d] += offset;
        }
        const Metric metric(dimension, periodic ? Domain::periodic(box) : Domain());
        PairCut<Scalar> cut(metric, box.upper.eigen().array().abs().maxCoeff() + 5);
        Random random(2, static_cast<std::uint64_t>(dimension));
        for (int trial = 0; trial < 200; ++trial) {
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(offset);
          CAPTURE(trial);
          const double radius = trial % 2 == 0 ? 0.05 : 0.15;
          Pair<Scalar> pair(metric, box, random, radius);
          cut.place(pair.sites, SiteNumber(0), SiteNumber(1));
          if (!cut.straight()) continue;
          const KeptCut<Scalar> kept[] = {{pair, cut, Side::i}, {pair, cut, Side::j}};
          const double moved = move_sites(pair, radius * 0.01 * (trial % 10), random);
          cut.place(pair.sites, SiteNumber(0), SiteNumber(1));
          if (!cut.straight()) continue;
          for (const KeptCut<Scalar>& side : kept) {
            check_bounds(side, cut, moved * 32 * radius * dimension);
            ++bounded;
          }
        }
      }
    }
  }
  CHECK(bounded > 1000);
}

TEST_SUITE_END();
