// Every method at the ends of the range of scales that it promises, and just beyond.

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/ccvt.h"
#include "scales.h"
#include "support/generate.h"
#include "support/message.h"

namespace ccvt::test {
namespace {

TEST_SUITE_BEGIN("scale");

/// Points that extend over 1 in their widest dimension.
template <class Scalar>
Points<Scalar> unit_points(int dimension, Index count, Layout layout = Layout::clusters) {
  Points<Scalar> points = make_points<Scalar>(layout, Box::unit(dimension), count);
  points.col(0).setZero();
  points.col(1).setOnes();
  return points;
}

/// The least and largest power of two by which points that extend over 1 may be multiplied.
template <class Scalar>
std::vector<double> ends() {
  return {std::exp2(std::ceil(std::log2(kSmallestExtent<Scalar>))),
          std::exp2(std::floor(std::log2(largest_coordinate<Scalar>(2))))};
}

template <class Scalar>
Points<Scalar> times(const Points<Scalar>& points, double factor) {
  return (points.template cast<double>() * factor).template cast<Scalar>();
}

TEST_CASE_TEMPLATE("codebooks of scaled vectors are scaled codebooks", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 10}) {
    for (const auto method :
         {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
      CAPTURE(dimension);
      CAPTURE(static_cast<int>(method));
      const auto vectors = unit_points<Scalar>(dimension, 500, Layout::clusters);
      const auto whole = train_codebook(vectors, 20, {.method = method, .restarts = 2});
      for (const double factor : ends<Scalar>()) {
        CAPTURE(factor);
        const auto scaled = times(vectors, factor);
        const auto training = train_codebook(scaled, 20, {.method = method, .restarts = 2});
        CHECK(training.summary.termination == Termination::stable);
        if (method != CodebookMethod::lloyd) CHECK(training.summary.usage.smallest == 25);
        CHECK(training.summary.gap < 1e-9);
        const double share = training.summary.energy / factor / factor / whole.summary.energy;
        CHECK(share == doctest::Approx(1).epsilon(1e-9));
        for (const Coding coding : {Coding::nearest, Coding::weighted}) {
          const auto codes = training.codebook.encode(scaled, coding);
          if (coding == Coding::nearest && method == CodebookMethod::lloyd) {
            CHECK(training.codebook.distortion(scaled, codes) ==
                  doctest::Approx(training.summary.distortion));
          }
          CHECK(training.codebook.distortion(scaled, codes) <=
                training.summary.distortion * (coding == Coding::nearest ? 1 + 1e-9 : 2));
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("every start and method of tessellation at both ends", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 10}) {
    const auto points = unit_points<Scalar>(dimension, 600, Layout::random);
    std::vector<Options> all = {Options::balzer2009(), Options::section4(), Options::fast_ccvt()};
    for (const auto start :
         {Initialization::balanced, Initialization::coherent, Initialization::random}) {
      all.push_back({.initialization = start, .level_points = 4});
    }
    for (const double factor : ends<Scalar>()) {
      for (const bool periodic : {false, true}) {
        CAPTURE(dimension);
        CAPTURE(factor);
        CAPTURE(periodic);
        const auto scaled = times(points, factor);
        Problem<Scalar> problem(scaled, 20);
        Box box = Box::unit(dimension);
        box.upper.eigen() *= factor;
        if (periodic) problem.set_domain(Domain::periodic(box));
        Problem<Scalar> unscaled(points, 20);
        if (periodic) unscaled.set_domain(Domain::periodic(Box::unit(dimension)));
        for (const Options& options : all) {
          const auto result = tessellate(problem, options);
          CHECK(result.summary.termination == Termination::stable);
          CHECK(capacity_error(result.owners, 20) == 0);
          const double energy = tessellate(unscaled, options).summary.energy;
          CHECK(result.summary.energy / factor / factor == doctest::Approx(energy).epsilon(0.2));
        }
        const auto relaxed = lloyd(problem);
        CHECK(relaxed.summary.termination == Termination::stable);
        CHECK(relaxed.summary.energy / factor / factor ==
              doctest::Approx(lloyd(unscaled).summary.energy));
      }
    }
  }
}

TEST_CASE("tiny clusters far apart: what squares cannot tell is left as it is") {
  for (const double tiny : {1e-120, 1e-150, 1e-154, 1e-160, 1e-170, 1e-300, 1e-320}) {
    for (const int dimension : {2, 9}) {
      CAPTURE(tiny);
      CAPTURE(dimension);
      auto points = unit_points<double>(dimension, 400);
      points.rightCols(300) *= tiny;
      for (const auto method :
           {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
        const auto training = train_codebook(points, 40, {.method = method, .restarts = 2});
        CHECK(training.summary.termination == Termination::stable);
        if (method != CodebookMethod::lloyd) CHECK(training.summary.usage.largest == 10);
        CHECK(training.codebook.encode(points, Coding::weighted).size() == 400);
      }
      CHECK(capacity_error(tessellate(points, 40).owners, 40) == 0);
      CHECK(lloyd(points, 40).summary.termination == Termination::stable);
    }
  }
}

TEST_CASE_TEMPLATE("all equal points at any place", Scalar, float, double) {
  for (const double place : {0.0, 1e-30, 0.1, 1e17}) {
    const Points<Scalar> points = Points<Scalar>::Constant(3, 60, static_cast<Scalar>(place));
    for (const auto method :
         {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
      const auto training = train_codebook(points, 6, {.method = method});
      CHECK(training.summary.energy <= 1e-20 * place * place);
    }
    CHECK(tessellate(points, 6).summary.energy == 0);
    CHECK(lloyd(points, 6).summary.energy == 0);
  }
}

/// Whether `work` is refused as bad input; it must either work or be refused.
template <class Work>
bool refused(Work&& work) {
  try {
    work();
  } catch (const InvalidInput&) {
    return true;
  }
  return false;
}

TEST_CASE("each scale works or is refused, from the least number to the largest") {
  const auto points = unit_points<double>(4, 100);
  for (int exponent = -1074; exponent <= 1023; exponent += exponent % 7 == 0 ? 1 : 13) {
    CAPTURE(exponent);
    const auto scaled = times(points, std::exp2(exponent));
    const double widest = std::exp2(exponent);
    const bool good = widest >= kSmallestExtent<double> && widest <= largest_coordinate<double>(4);
    for (const auto method :
         {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
      CHECK(refused([&] { train_codebook(scaled, 10, {.method = method}); }) != good);
    }
    CHECK(refused([&] { tessellate(scaled, 10); }) != good);
    CHECK(refused([&] { lloyd(scaled, 10); }) != good);
    CHECK(refused([&] {
            Box box = Box::unit(4);
            box.upper.eigen() *= widest;
            nearest_distances(PointSet(scaled, Domain::euclidean(box)));
          }) != good);
  }
}

TEST_CASE("a box that only bounds may be as wide as it likes") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 2000);
  const double energy = tessellate(points, 40).summary.energy;
  for (const double half : {1e3, 1e14, 1e30}) {
    Problem<double> problem(points, 40);
    problem.set_domain(Domain::euclidean({{-half, -half}, {half, half}}));
    const auto wide = tessellate(problem);
    CHECK(wide.summary.termination == Termination::stable);
    CHECK(wide.summary.energy == doctest::Approx(energy).epsilon(0.01));
    problem.set_initial_sites(wide.sites);
    CHECK(lloyd(problem).summary.energy < wide.summary.energy);
  }
}

TEST_CASE("what is refused says what to do") {
  const Points<double> tiny = unit_points<double>(2, 50) * 1e-155;
  CHECK(message_of([&] { Problem<double>(tiny, 5); }) ==
        "points: their coordinates differ by at most 1e-155: they must be all equal or differ by "
        "1e-140 or more somewhere; multiply them by a power of two");
  const Points<double> words = unit_points<double>(2, 5) * 1e-160;
  CHECK(message_of([&] { static_cast<void>(Codebook(words).encode(tiny)); }) ==
        "vectors: they and the codewords differ by at most 1e-155: they must be all equal or "
        "differ by 1e-150 or more somewhere; multiply both by a power of two");
  CHECK_THROWS_AS(Codebook(Points<double>::Constant(2, 1, 1e200)), InvalidInput);
  CHECK_THROWS_AS(Codebook(words, Eigen::VectorXd::Constant(5, 1e301)), InvalidInput);
  const Points<double> unit = unit_points<double>(2, 50);
  const Points<double> huge = Points<double>::Constant(2, 3, -1e150);
  CHECK_THROWS_AS(static_cast<void>(Codebook(unit).encode(huge)), InvalidInput);
  Box thin = Box::unit(2);
  thin.upper[1] = 1e-141;
  Points<double> flat = unit;
  flat.row(1).setZero();
  Problem<double> problem(flat, 5);
  CHECK_NOTHROW(problem.set_domain(Domain::euclidean(thin)));
  CHECK_THROWS_AS(problem.set_domain(Domain::periodic(thin)), InvalidInput);
  CHECK_THROWS_AS(PointSet(flat, Domain::euclidean(thin)), InvalidInput);
  const Points<float> many = Points<float>::Constant(40000, 2, 6e16F);
  CHECK_THROWS_AS(Problem<float>(many, 1), InvalidInput);  // fewer dimensions may be this large
  const Points<float> fewer = many.topRows(8192);
  CHECK_NOTHROW(Problem<float>(fewer, 1));
}

TEST_CASE("metrics do not depend on the scale of the box") {
  const auto points = unit_points<double>(2, 200);
  const PointSet set(points, Domain::periodic(Box::unit(2)));
  const auto near = nearest_distances(set);
  const auto order = bond_order(set);
  for (const double factor : ends<double>()) {
    CAPTURE(factor);
    Box box = Box::unit(2);
    box.upper.eigen() *= factor;
    const PointSet scaled(times(points, factor), Domain::periodic(box));
    CHECK(nearest_distances(scaled).mean == doctest::Approx(near.mean));
    CHECK(bond_order(scaled).psi6_local == doctest::Approx(order.psi6_local));
    CHECK(star_discrepancy(scaled) == doctest::Approx(star_discrepancy(set)));
    CHECK(power_spectrum({&scaled, 1}).peak == doctest::Approx(power_spectrum({&set, 1}).peak));
    CHECK(pair_correlation({&scaled, 1}).value == pair_correlation({&set, 1}).value);
    CHECK(normalized_energy(factor * factor, 10, 2, box) ==
          doctest::Approx(normalized_energy(1, 10, 2, Box::unit(2))));
  }
}

TEST_SUITE_END();

}  // namespace
}  // namespace ccvt::test
