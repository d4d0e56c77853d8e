// What every function asks of enumerators and of views: see src/checks.h.
#include <doctest/doctest.h>

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/density.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "ccvt/metrics.h"
#include "ccvt/particles.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/stipple.h"
#include "ccvt/surface.h"
#include "ccvt/thin.h"
#include "ccvt/volume.h"
#include "ccvt/weighted.h"
#include "support/files.h"
#include "support/message.h"

using ccvt::Box;
using ccvt::Index;
using ccvt::Points;
using ccvt::PointsView;
using namespace ccvt::test;

namespace {

constexpr int kNone = 77;
const std::string kRule = " is 77: it must be one of the enumerators";

template <class Enum>
Enum no_enumerator() {
  return static_cast<Enum>(kNone);
}

const Points<double>& some_points() {
  static const Points<double> points =
      ccvt::sample_uniform<double>(Box::unit(3), 50, 1, ccvt::Distribution::white);
  return points;
}

/// Of 50 points that are nowhere.
PointsView<double> nowhere(int dimension = 3) { return {nullptr, dimension, 50, dimension}; }

template <class Call>
void check_no_data(const std::string& name, const Call& call) {
  CHECK(message_of([&] { call(nowhere()); }) == name + ": the view has no data");
  PointsView<double> narrow = ccvt::view_points(some_points());
  narrow.stride = 2;
  CHECK(message_of([&] { call(narrow); }) ==
        name + ": the stride is 2: it must be at least the dimension, 3");
}

}  // namespace

TEST_SUITE_BEGIN("checks");

TEST_CASE("a number that is no enumerator is refused by name") {
  const Points<double>& points = some_points();
  ccvt::CodebookOptions codebook;
  codebook.method = no_enumerator<ccvt::CodebookMethod>();
  CHECK(message_of([&] { ccvt::train_codebook(points, 5, codebook); }) ==
        "CodebookOptions::method" + kRule);
  codebook = {};
  codebook.seeding = no_enumerator<ccvt::Seeding>();
  CHECK(message_of([&] { ccvt::train_codebook(points, 5, codebook); }) ==
        "CodebookOptions::seeding" + kRule);
  const auto trained = ccvt::train_codebook(points, 5);
  CHECK(message_of([&] {
          static_cast<void>(trained.codebook.encode(points, no_enumerator<ccvt::Coding>()));
        }) == "coding" + kRule);

  CHECK(message_of([&] {
          ccvt::sample_uniform<float>(Box::unit(2), 9, 1, no_enumerator<ccvt::Distribution>());
        }) == "distribution" + kRule);
  const std::vector<float> values(8, 1);
  ccvt::DensityGrid grid{values, {2, 2, 2}, Box::unit(3)};
  const auto sampling = no_enumerator<ccvt::DensitySampling>();
  CHECK(message_of([&] { ccvt::sample_density<float>(grid, 9, 1, sampling); }) ==
        "sampling" + kRule);
  const auto even = [](std::span<const double>) { return 1.0; };
  CHECK(message_of([&] {
          ccvt::sample_function<float>(even, 1.0, Box::unit(2), 9, 1, sampling);
        }) == "sampling" + kRule);
  grid.interpolation = no_enumerator<ccvt::Interpolation>();
  CHECK(message_of([&] { ccvt::sample_density<float>(grid, 9, 1); }) ==
        "grid: interpolation" + kRule);

  ccvt::MassOptions masses;
  masses.method = no_enumerator<ccvt::MassMethod>();
  const std::vector<double> one(50, 1.0);
  CHECK(message_of([&] { ccvt::tessellate_masses(points, one, 5, masses); }) == "method" + kRule);
  const TemporaryDirectory directory;
  ccvt::ParticleOptions particles;
  particles.type = no_enumerator<ccvt::ParticleType>();
  CHECK(message_of([&] { ccvt::write_particles(directory / "p.gadget", points, particles); }) ==
        "type" + kRule);
  CHECK(directory.entries() == 0);

  ccvt::ValueMap map;
  map.kind = no_enumerator<ccvt::ValueMap::Kind>();
  CHECK(message_of([&] { map.validate(); }) == "kind" + kRule);
  CHECK(message_of([&] { static_cast<void>(map(1, 2)); }) == "kind" + kRule);
  ccvt::Volume volume;
  volume.type = no_enumerator<ccvt::VoxelType>();
  CHECK(message_of([&] { static_cast<void>(volume.stored()); }) == "Volume::type" + kRule);
  CHECK(message_of([&] { static_cast<void>(ccvt::bytes_of(volume.type)); }) == "type" + kRule);
  CHECK(message_of([&] { static_cast<void>(ccvt::to_string(volume.type)); }) == "type" + kRule);
}

TEST_CASE("a box with corners of different sizes, and a solver that was moved from, are refused") {
  Box box = Box::unit(3);
  box.upper = ccvt::Box::unit(2).upper;
  const std::string rule =
      "box: lower has 3 dimensions and upper has 2, but both must have the same number";
  CHECK(message_of([&] { ccvt::normalized_energy(1, 10, 2, box); }) == rule);
  CHECK(message_of([&] { ccvt::sample_uniform<float>(box, 9, 1); }) == rule);

  ccvt::Solver<double> solver(ccvt::Problem<double>(some_points(), 5));
  const ccvt::Solver<double> other = std::move(solver);
  CHECK(other.owners().size() == 50);
  // NOLINTBEGIN(bugprone-use-after-move): that is what is tested.
  const std::string moved = "solver: was moved from";
  CHECK(message_of([&] { solver.step(); }) == moved);
  CHECK(message_of([&] { solver.run(); }) == moved);
  CHECK(message_of([&] { solver.cancel(); }) == moved);
  CHECK(message_of([&] { static_cast<void>(solver.owners()); }) == moved);
  CHECK(message_of([&] { static_cast<void>(solver.summary()); }) == moved);
  // NOLINTEND(bugprone-use-after-move)
}

TEST_CASE("codebooks and mapped points that were moved from are refused") {
  const TemporaryDirectory directory;
  const Points<double>& points = some_points();
  ccvt::write_points(directory / "p.npy", points);
  const std::vector<Index> codes(50, 0);
  ccvt::Codebook codebook(Points<double>(points.leftCols(4)));
  const ccvt::Codebook other = std::move(codebook);
  CHECK(other.encode(points).size() == 50);
  ccvt::MappedPoints<double> mapped(directory / "p.npy");
  const ccvt::MappedPoints<double> others = std::move(mapped);
  CHECK(others.view().count == 50);
  // NOLINTBEGIN(bugprone-use-after-move): that is what is tested.
  std::string moved = "codebook: was moved from";
  CHECK(message_of([&] { static_cast<void>(codebook.encode(points)); }) == moved);
  CHECK(message_of([&] { static_cast<void>(codebook.decode(codes)); }) == moved);
  CHECK(message_of([&] { static_cast<void>(codebook.distortion(points, codes)); }) == moved);
  CHECK(message_of([&] { codebook.save(directory / "c.npy"); }) == moved);
  moved = "points: was moved from";
  CHECK(message_of([&] { static_cast<void>(mapped.view()); }) == moved);
  CHECK(message_of([&] { static_cast<void>(mapped.mapped()); }) == moved);
  CHECK(message_of([&] { mapped.check_unchanged(); }) == moved);
  // NOLINTEND(bugprone-use-after-move)
  CHECK(directory.entries() == 1);
}

TEST_CASE("sets that were moved from, and samples that do not fit, are refused") {
  ccvt::PointSet set(some_points().topRows(2), ccvt::Domain::periodic(Box::unit(2)));
  const ccvt::PointSet other = std::move(set);
  CHECK(other.count() == 50);
  // NOLINTBEGIN(bugprone-use-after-move): that is what is tested.
  const std::string moved = "set: was moved from";
  CHECK(message_of([&] { ccvt::nearest_distances(set); }) == moved);
  CHECK(message_of([&] { ccvt::pair_correlation({&set, 1}); }) == moved);
  CHECK(message_of([&] { ccvt::bond_order(set); }) == moved);
  CHECK(message_of([&] { ccvt::power_spectrum({&set, 1}); }) == moved);
  CHECK(message_of([&] { ccvt::star_discrepancy(set); }) == moved);
  CHECK(message_of([&] { ccvt::integration_variance(set); }) == moved);
  CHECK(message_of([&] { ccvt::analyze({&set, 1}); }) == moved);
  // NOLINTEND(bugprone-use-after-move)

  ccvt::TriangleMesh mesh;
  mesh.vertices = Eigen::Matrix3d::Identity();
  mesh.triangles = Eigen::Vector3i(0, 1, 2);
  const auto good = ccvt::sample_surface<float>(mesh, 5);
  const TemporaryDirectory directory;
  auto bad = good;
  bad.barycentric = {2, 5};
  CHECK(message_of([&] { ccvt::write_samples(directory / "s.csv", bad); }) ==
        "samples: barycentric has 2 rows; needs 3");
  const auto refusal = [&] { return message_of([&] { ccvt::preview(mesh, bad); }); };
  bad.radii.pop_back();
  CHECK(refusal() ==
        "samples: there are 5 sites, 5 normals and 4 radii; needs one for each, and one site");
  bad = good;
  bad.sites(0, 3) = NAN;
  CHECK(refusal() == "samples: sites and normals must be finite");
  bad = good;
  bad.normals = {2, 5};
  CHECK(refusal() == "samples: sites have 3 rows and normals 2; both need 3");
  CHECK(directory.entries() == 0);
}

TEST_CASE("numbers of threads and dimensions that cannot be are refused") {
  const std::string rule = "threads: is -1; must be from 0 (one per processor) to 4096";
  const ccvt::PointSet set(some_points(), ccvt::Domain::periodic(Box::unit(3)));
  const ccvt::PointSet flat(some_points().topRows(2), ccvt::Domain::periodic(Box::unit(2)));
  CHECK(message_of([&] { ccvt::nearest_distances(set, -1); }) == rule);
  CHECK(message_of([&] { ccvt::pair_correlation({&set, 1}, -1); }) == rule);
  CHECK(message_of([&] { ccvt::bond_order(flat, -1); }) == rule);
  CHECK(message_of([&] { ccvt::power_spectrum({&set, 1}, {.threads = -1}); }) == rule);
  CHECK(message_of([&] { ccvt::star_discrepancy(flat, -1); }) == rule);
  CHECK(message_of([&] { ccvt::integration_variance(set, 0, -1); }) == rule);

  CHECK(message_of([] { Box::unit(-1); }) == "dimension: is -1; must be at least 0");
  const ccvt::Problem<double> problem(some_points(), 5);
  CHECK(message_of([&] { ccvt::tessellate<2>(problem); }) ==
        "problem: has points of 3 dimensions, but sites of 2 are asked for");
  CHECK(ccvt::tessellate<3>(problem).sites == ccvt::tessellate(problem).sites);
}

TEST_CASE("a view without data, or with rows that overlap, is refused by name") {
  const Points<double>& points = some_points();
  const auto view = ccvt::view_points(points);
  const std::vector<Index> owners(50, 0);
  const TemporaryDirectory directory;
  const auto trained = ccvt::train_codebook(points, 5);
  const std::vector<float> values(8, 1);
  const ccvt::DensityGrid grid{values, {2, 2, 2}, Box::unit(3)};

  check_no_data("points", [](auto v) { ccvt::Problem<double>(v, 5); });
  check_no_data("points", [&](auto v) { ccvt::energy(v, view, owners); });
  check_no_data("sites", [&](auto v) { ccvt::energy(view, v, owners); });
  check_no_data("points", [&](auto v) { ccvt::write_points(directory / "p.npy", v); });
  check_no_data("points", [&](auto v) { ccvt::write_points(directory / "p.csv", v); });
  check_no_data("sites", [&](auto v) {
    ccvt::write_particles(directory / "p.gadget", v, ccvt::ParticleOptions());
  });
  check_no_data("vectors", [&](auto v) {
    static_cast<void>(trained.codebook.encode(v, ccvt::Coding::nearest, 1, nullptr));
  });
  check_no_data("normals", [&](auto v) { ccvt::thin(view, 5, ccvt::ThinOptions(), v); });
  check_no_data("sites", [&](auto v) { static_cast<void>(ccvt::preview(grid, v, 64)); });
  CHECK(message_of([] { static_cast<void>(ccvt::dot_radius_for(nowhere(2), 9, 9, 3.0)); }) ==
        "dots: the view has no data");
  CHECK(directory.entries() == 0);
}

TEST_SUITE_END();
