#include "ccvt/surface.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "random.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/message.h"

using ccvt::Columns;
using ccvt::Index;
using ccvt::SurfaceOptions;
using ccvt::SurfaceSamples;
using ccvt::TriangleMesh;
using namespace ccvt::test;

namespace {

Eigen::Vector3d normal_of(const TriangleMesh& mesh, Index triangle) {
  const Eigen::Matrix3d c = corners_of(mesh, triangle);
  const Eigen::Vector3d a = c.col(1) - c.col(0);
  const Eigen::Vector3d b = c.col(2) - c.col(0);
  return Eigen::Vector3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0])
      .normalized();
}

/// What is wrong with samples of any mesh whose triangles agree with their neighbours.
std::string faults(const TriangleMesh& mesh, const SurfaceSamples& samples, Index sites,
                   Index points_per_site) {
  const auto count = static_cast<std::size_t>(sites);
  if (samples.sites.cols() != sites || samples.triangles.size() != count ||
      samples.capacities.size() != count || samples.radii.size() != count) {
    return "sizes";
  }
  double mass = 0;
  Index points = 0;
  const double size = mesh.vertices.eigen().cwiseAbs().maxCoeff();
  for (std::size_t s = 0; s < count; ++s) {
    const auto column = static_cast<Eigen::Index>(s);
    const Eigen::Vector3d shares = samples.barycentric.col(column);
    if (!(shares.minCoeff() >= 0) || std::abs(shares.sum() - 1) > 1e-15) return "shares";
    const Eigen::Vector3d at = corners_of(mesh, samples.triangles[s]) * shares;
    if ((at - samples.sites.col(column)).norm() > 1e-15 * size) return "off the surface";
    const Eigen::Vector3d normal = samples.normals.col(column);
    if ((normal - normal_of(mesh, samples.triangles[s])).norm() > 1e-9) return "normal";
    if (!(samples.radii[s] > 0)) return "radius";
    if (samples.sheets == 1 && samples.capacities[s] != points_per_site) return "capacity";
    mass += samples.weights[s];
    points += samples.capacities[s];
  }
  if (points != sites * points_per_site) return "points";
  if (std::abs(mass / samples.mass - 1) > 1e-12) return "weights";
  return "";
}

/// How many cells hold points of triangles that `far_apart` says do not belong together.
template <class FarApart>
int spanning(const SurfaceSamples& samples, const FarApart& far_apart) {
  std::vector<Index> first(samples.capacities.size(), -1);
  std::set<std::size_t> spans;
  for (std::size_t p = 0; p < samples.owners.size(); ++p) {
    const auto owner = static_cast<std::size_t>(samples.owners[p]);
    const Index triangle = samples.point_triangles[p];
    if (first[owner] < 0) first[owner] = triangle;
    if (far_apart(first[owner], triangle)) spans.insert(owner);
  }
  return static_cast<int>(spans.size());
}

SurfaceOptions options(Index points_per_site, std::uint64_t seed = 1, int threads = 1) {
  SurfaceOptions result;
  result.points_per_site = points_per_site;
  result.tessellation.seed = seed;
  result.tessellation.threads = threads;
  return result;
}

TriangleMesh one_triangle(const std::array<double, 3>& density) {
  TriangleMesh mesh;
  mesh.vertices = Columns<double>(Eigen::Matrix3d{{0, 4, 1}, {0, 0, 3}, {0, 0, 2}});
  mesh.triangles = Columns<Index>(3, 1);
  for (Index i = 0; i < 3; ++i) mesh.triangles(i, 0) = i;
  mesh.density.assign(density.begin(), density.end());
  return mesh;
}

}  // namespace

TEST_SUITE_BEGIN("surface");

TEST_CASE("samples of a sphere lie on it, with full cells, as blue noise") {
  const TriangleMesh mesh = sphere(64, 32);
  const auto samples = ccvt::sample_surface<float>(mesh, 500, options(128));
  CHECK(faults(mesh, samples, 500, 128) == "");
  CHECK(samples.area == doctest::Approx(4 * std::numbers::pi).epsilon(0.01));
  CHECK(samples.sheets == 1);
  CHECK(samples.turned == 0);
  CHECK(samples.farthest_moved < 0.01);
  const double smallest = smallest_distance(samples);
  MESSAGE("smallest distance: " << smallest << " of the hexagonal lattice's");
  CHECK(smallest >= 0.6);
  // The octants have equal areas.
  std::array<int, 8> octants{};
  for (Eigen::Index s = 0; s < 500; ++s) {
    const auto x = samples.sites.col(s);
    ++octants[(x[0] > 0 ? 1U : 0U) + (x[1] > 0 ? 2U : 0U) + (x[2] > 0 ? 4U : 0U)];
  }
  for (const int count : octants) CHECK(count == doctest::Approx(62.5).epsilon(0.1));
}

TEST_CASE("samples of a torus lie on it, with full cells, as blue noise") {
  const TriangleMesh mesh = torus(64, 32, 0.4);
  const auto samples = ccvt::sample_surface<double>(mesh, 500, options(128, 5));
  CHECK(faults(mesh, samples, 500, 128) == "");
  CHECK(samples.area ==
        doctest::Approx(4 * std::numbers::pi * std::numbers::pi * 0.4).epsilon(0.01));
  const double smallest = smallest_distance(samples);
  MESSAGE("smallest distance: " << smallest << " of the hexagonal lattice's");
  CHECK(smallest >= 0.6);
  // The outer half has the share 1/2 + thin / pi of the area [Pappus].
  int outer = 0;
  for (Eigen::Index s = 0; s < 500; ++s) outer += samples.sites.col(s).head(2).norm() > 1 ? 1 : 0;
  CHECK(outer == doctest::Approx(500 * (0.5 + 0.4 / std::numbers::pi)).epsilon(0.03));
}

TEST_CASE("sheets that are near but face apart share no cell") {
  const TriangleMesh mesh = together(square(5, 0), turned(square(5, 0.02)));
  const auto far_apart = [](Index a, Index b) { return (a < 50) != (b < 50); };
  SurfaceOptions chosen = options(128);
  chosen.keep_points = true;
  const auto samples = ccvt::sample_surface<float>(mesh, 301, chosen);
  CHECK(samples.sheets == 2);
  CHECK(spanning(samples, far_apart) == 0);
  const auto side = [&](Eigen::Index s) {
    return samples.triangles[static_cast<std::size_t>(s)] < 50;
  };
  CHECK(smallest_distance(samples, [&](auto a, auto b) { return side(a) == side(b); }) >= 0.6);
  // Capacities of 150 and 151 sites for as many points.
  const auto [least, most] =
      std::minmax_element(samples.capacities.begin(), samples.capacities.end());
  CHECK(*most - *least <= 2);
  chosen.normal_weight = 0;
  CHECK(spanning(ccvt::sample_surface<float>(mesh, 301, chosen), far_apart) > 100);
}

TEST_CASE("the two sides of a thin closed surface share cells at its rim only") {
  TriangleMesh mesh = sphere(64, 32);
  mesh.vertices.eigen().row(2) *= 0.01;
  SurfaceOptions chosen = options(128);
  chosen.keep_points = true;
  const auto far_apart = [&](Index a, Index b) {
    const auto inside = [&](Index t) {
      return corners_of(mesh, t).topRows(2).colwise().norm().maxCoeff() < 0.9;
    };
    return inside(a) && inside(b) && normal_of(mesh, a)[2] * normal_of(mesh, b)[2] < 0;
  };
  CHECK(spanning(ccvt::sample_surface<float>(mesh, 400, chosen), far_apart) == 0);
  chosen.normal_weight = 0;
  CHECK(spanning(ccvt::sample_surface<float>(mesh, 400, chosen), far_apart) > 100);
}

TEST_CASE("every triangle gets its share of the points") {
  // Random triangles of very different size, slivers and such without area among them.
  ccvt::Random random(3);
  TriangleMesh mesh;
  mesh.vertices = Columns<double>(3, 300);
  mesh.triangles = Columns<Index>(3, 400);
  for (Eigen::Index v = 0; v < 300; ++v) {
    for (Eigen::Index d = 0; d < 3; ++d) {
      mesh.vertices(d, v) = std::pow(random.uniform(), 5) * (d == 1 ? 0.01 : 1);
    }
    mesh.density.push_back(v % 7 == 0 ? 0 : random.uniform());
  }
  for (Eigen::Index t = 0; t < 400; ++t) {
    for (Eigen::Index i = 0; i < 3; ++i) mesh.triangles(i, t) = random.index_below(300);
    if (t % 50 == 0) mesh.triangles(2, t) = mesh.triangles(0, t);
  }
  SurfaceOptions chosen = options(64, 11);
  chosen.keep_points = true;
  chosen.tessellation.max_iterations = 0;
  const auto samples = ccvt::sample_surface<double>(mesh, 300, chosen);
  std::vector<double> masses;
  for (Index t = 0; t < 400; ++t) {
    double density = 0;
    for (Eigen::Index i = 0; i < 3; ++i) {
      density += mesh.density[static_cast<std::size_t>(mesh.triangles(i, t))] / 3;
    }
    masses.push_back(area_of(mesh, t) * density);
  }
  const double mass = std::accumulate(masses.begin(), masses.end(), 0.0);
  CHECK(samples.mass == doctest::Approx(mass).epsilon(1e-12));
  std::vector<int> counts(400, 0);
  for (const Index t : samples.point_triangles) ++counts[static_cast<std::size_t>(t)];
  for (std::size_t t = 0; t < 400; ++t) {
    // A triangle is a stretch of the line of parts with one point each.
    const double expected = masses[t] / mass * 300 * 64;
    CHECK(std::abs(counts[t] - expected) < 2);
    if (masses[t] == 0) CHECK(counts[t] == 0);
  }
  CHECK(faults(mesh, samples, 300, 64) != "shares");
  CHECK(faults(mesh, samples, 300, 64) != "off the surface");
}

TEST_CASE("points follow a density that is linear over a triangle") {
  const TriangleMesh mesh = one_triangle({0, 1, 3});
  SurfaceOptions chosen = options(64, 2);
  chosen.keep_points = true;
  chosen.tessellation.max_iterations = 0;
  const auto samples = ccvt::sample_surface<double>(mesh, 200, chosen);
  CHECK(samples.mass == doctest::Approx(samples.area * 4 / 3));
  // 64 triangles of equal area. In the one with the centroid c the density is that at c times that.
  constexpr int kCuts = 8;
  const Eigen::Matrix3d corners = corners_of(mesh, 0);
  const Eigen::Matrix<double, 3, 2> sides = corners.rightCols(2).colwise() - corners.col(0);
  const Eigen::Matrix2d square = sides.transpose() * sides;
  const double determinant = square(0, 0) * square(1, 1) - square(0, 1) * square(1, 0);
  const Eigen::Matrix2d inverse =
      Eigen::Matrix2d{{square(1, 1), -square(0, 1)}, {-square(1, 0), square(0, 0)}} / determinant;
  std::vector<double> counts(2 * kCuts * kCuts, 0);
  for (Eigen::Index p = 0; p < samples.points.cols(); ++p) {
    const Eigen::Vector2d uv =
        inverse * (sides.transpose() * (samples.points.col(p) - corners.col(0)));
    CHECK(uv.minCoeff() > -1e-12);
    CHECK(uv.sum() < 1 + 1e-12);
    const double u = std::max(uv[0], 0.0) * kCuts;
    const double v = std::max(uv[1], 0.0) * kCuts;
    const double upper = u - std::floor(u) + v - std::floor(v) > 1 ? 1 : 0;
    counts[static_cast<std::size_t>(2 * (kCuts * std::floor(v) + std::floor(u)) + upper)] += 1;
  }
  double chi = 0;
  for (int v = 0; v < kCuts; ++v) {
    for (int u = 0; u + v < kCuts; ++u) {
      for (const int upper : {0, 1}) {
        if (upper == 1 && u + v + 1 == kCuts) continue;
        const double shift = upper == 1 ? 2.0 / 3 : 1.0 / 3;
        const double density = (u + shift + 3 * (v + shift)) / kCuts;
        const double expected = 200 * 64 / 64.0 * density / (4.0 / 3);
        const auto cell = static_cast<std::size_t>(2 * (kCuts * v + u) + upper);
        chi += (counts[cell] - expected) * (counts[cell] - expected) / expected;
      }
    }
  }
  MESSAGE("chi-square with 63 degrees of freedom: " << chi);
  CHECK(chi < 40);  // far less than for independent points, of which one set in a hundred is below
}

TEST_CASE("samples are as dense as the vertices say") {
  TriangleMesh mesh = square(10);
  for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
    mesh.density.push_back(mesh.vertices(0, v));
  }
  const auto samples = ccvt::sample_surface<float>(mesh, 800, options(64));
  CHECK(faults(mesh, samples, 800, 64) == "");
  CHECK(samples.mass == doctest::Approx(0.5));
  for (const double x : {0.3, 0.5, 0.8}) {
    const auto below = (samples.sites.eigen().row(0).array() < x).count();
    CHECK(static_cast<double>(below) == doctest::Approx(800 * x * x).epsilon(0.05));
  }
}

TEST_CASE("weights are finite where the integral is") {
  TriangleMesh mesh = square(2);
  mesh.density.assign(static_cast<std::size_t>(mesh.vertices.cols()), 1e306);
  const auto samples = ccvt::sample_surface<float>(mesh, 4, options(20000));
  for (const double weight : samples.weights) CHECK(weight == doctest::Approx(2.5e305));
}

TEST_CASE("one seed gives the same samples for any number of threads") {
  const TriangleMesh mesh = torus(40, 20);
  const auto run = [&](int threads, std::uint64_t seed) {
    SurfaceOptions chosen = options(64, seed, threads);
    chosen.keep_points = true;
    return ccvt::sample_surface<float>(mesh, 300, chosen);
  };
  const auto one = run(1, 4);
  for (const int threads : {2, 3}) {
    const auto other = run(threads, 4);
    CHECK(other.sites == one.sites);
    CHECK(other.points == one.points);
    CHECK(other.owners == one.owners);
    CHECK(other.radii == one.radii);
    CHECK(other.triangles == one.triangles);
  }
  CHECK_FALSE(run(1, 5).sites == one.sites);
}

TEST_CASE("samples move with the surface, and grow with it") {
  TriangleMesh mesh = torus(40, 20);
  mesh.vertices = (mesh.vertices.eigen() * 0x1p16).array().round() / 0x1p16;  // exact when moved
  const auto near = ccvt::sample_surface<float>(mesh, 200, options(64));
  TriangleMesh moved = mesh;
  const Eigen::Vector3d far(5e5, 5.4e6, 1e3);
  moved.vertices.eigen().colwise() += far;
  const auto there = ccvt::sample_surface<float>(moved, 200, options(64));
  CHECK(((there.sites.eigen().colwise() - far) - near.sites.eigen()).cwiseAbs().maxCoeff() < 1e-8);
  TriangleMesh scaled = mesh;
  scaled.vertices.eigen() *= 0x1p40;
  const auto large = ccvt::sample_surface<float>(scaled, 200, options(64));
  CHECK(large.sites == (near.sites.eigen() * 0x1p40).eval());
  scaled.vertices.eigen() = mesh.vertices.eigen() * 0x1p-70;
  const auto small = ccvt::sample_surface<float>(scaled, 200, options(64));
  CHECK(faults(scaled, small, 200, 64) == "");
  CHECK(smallest_distance(small) > 0.55);
}

TEST_CASE("one triangle with nearly all of the area, slivers, and a surface of pieces") {
  TriangleMesh mesh = square(20);
  mesh.vertices.eigen().col(0) << -300, -400, 0;  // a corner of two triangles
  const auto large = ccvt::sample_surface<float>(mesh, 200, options(128));
  CHECK(faults(mesh, large, 200, 128) == "");
  mesh = square(30);
  mesh.vertices.eigen().row(1) *= 1e-7;
  const auto thin = ccvt::sample_surface<double>(mesh, 50, options(64));
  CHECK(faults(mesh, thin, 50, 64) == "");
  // Triangles that share no vertex hang together where these are at the same place.
  mesh = sphere(24, 12);
  TriangleMesh soup;
  soup.vertices = Columns<double>(3, 3 * mesh.triangles.cols());
  soup.triangles = mesh.triangles;
  for (Index t = 0; t < mesh.triangles.cols(); ++t) {
    for (Index i = 0; i < 3; ++i) {
      soup.vertices.eigen().col(3 * t + i) = mesh.vertices.col(mesh.triangles(i, t));
      soup.triangles(i, t) = 3 * t + i;
    }
  }
  const auto whole = ccvt::sample_surface<float>(mesh, 100, options(64));
  const auto pieces = ccvt::sample_surface<float>(soup, 100, options(64));
  CHECK(pieces.sheets == 1);
  CHECK(pieces.sites == whole.sites);
  // Pieces that do not, each smaller than a cell.
  ccvt::Random random(1);
  for (Eigen::Index v = 0; v < soup.vertices.cols(); ++v) {
    soup.vertices(2, v) += 1e-6 * random.uniform();
  }
  const auto loose = ccvt::sample_surface<float>(soup, 60, options(64));
  CHECK(loose.sheets > 500);
  CHECK(std::all_of(loose.capacities.begin(), loose.capacities.end(),
                    [](Index c) { return c == 64; }));
  CHECK(smallest_distance(loose) > 0.55);
}

TEST_CASE("triangles that face the other way than their sheet are turned") {
  TriangleMesh mesh = sphere(32, 16);
  Index flipped = 0;
  for (Index t = 0; t < mesh.triangles.cols(); ++t) {
    if (t % 3 != 0 || area_of(mesh, t) < 1e-9) continue;
    std::swap(mesh.triangles(1, t), mesh.triangles(2, t));
    ++flipped;
  }
  const auto samples = ccvt::sample_surface<float>(mesh, 200, options(64));
  CHECK(samples.turned == flipped);
  CHECK(
      (samples.normals.eigen().array() * samples.sites.eigen().array()).colwise().sum().minCoeff() >
      0.9);
  CHECK(smallest_distance(samples) >= 0.55);
  // One side only.
  const TriangleMesh strip = patch(60, 6, false, false, [](double u, double v) {
    const double a = 2 * std::numbers::pi * u;
    const double r = 1 + (v - 0.5) * std::cos(a / 2);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), (v - 0.5) * std::sin(a / 2));
  });
  const auto around = ccvt::sample_surface<float>(strip, 100, options(64));
  CHECK(std::isfinite(around.radii[0]));
}

TEST_CASE("any number of triangles may share an edge") {
  // A book of five pages.
  TriangleMesh mesh = square(4);
  for (const double angle : {0.7, 1.4, 2.1, 2.8}) {
    TriangleMesh page = square(4);
    const Eigen::ArrayXd x = page.vertices.eigen().row(0).transpose();
    page.vertices.eigen().row(0) = (x * std::cos(angle)).transpose().matrix();
    page.vertices.eigen().row(2) = (x * std::sin(angle)).transpose().matrix();
    mesh = together(mesh, page);
  }
  const auto samples = ccvt::sample_surface<float>(mesh, 150, options(64));
  CHECK(samples.sheets == 5);
  CHECK(faults(mesh, samples, 150, 64) == "");
  std::array<int, 5> pages{};
  for (const Index t : samples.triangles) ++pages[static_cast<std::size_t>(t / 32)];
  // At the spine cells may reach from page to page.
  for (const int count : pages) CHECK(std::abs(count - 30) <= 2);
}

TEST_CASE("bad meshes and options are refused") {
  const auto refusal = [](const TriangleMesh& mesh, Index sites = 4) {
    return message_of([&] { ccvt::sample_surface<float>(mesh, sites, options(8)); });
  };
  TriangleMesh mesh = square(2);
  CHECK(refusal({}) == "mesh: vertices are 0 x 0; needs 3 rows, and a column for each");
  CHECK(refusal(mesh, 0) == "sites: is 0; must be at least 1");
  mesh.triangles(1, 3) = 9;
  CHECK(refusal(mesh) ==
        "mesh: corner 1 of triangle 3 is vertex 9; vertices have the numbers 0 to 8");
  mesh.triangles(1, 3) = -1;
  CHECK(refusal(mesh) ==
        "mesh: corner 1 of triangle 3 is vertex -1; vertices have the numbers 0 to 8");
  mesh = square(2);
  mesh.vertices(2, 4) = NAN;
  CHECK(refusal(mesh) == "mesh: coordinate 2 of vertex 4 is nan; must be finite");
  mesh = square(2);
  mesh.density = {1, 2};
  CHECK(refusal(mesh) == "mesh: has 2 densities for 9 vertices; needs one for each, or none");
  mesh.density.assign(9, 1);
  mesh.density[5] = -1;
  CHECK(refusal(mesh) == "mesh: the density of vertex 5 is -1; must be finite and not negative");
  mesh.density.assign(9, 0);
  CHECK(refusal(mesh) ==
        "mesh: the integral of the density over the surface is 0; must be positive and finite");
  mesh = square(2);
  mesh.vertices.eigen().row(1).setZero();
  CHECK(refusal(mesh) == "mesh: none of its 8 triangles has an area; needs one");
  mesh.vertices.eigen() *= 1e17;
  CHECK(refusal(mesh).substr(0, 40) == "mesh: its triangles extend over 1e+17; m");
  SurfaceOptions chosen;
  chosen.normal_weight = -1;
  CHECK(message_of([&] { chosen.validate(); }) == "normal_weight: is -1; must be from 0 to 100");
  chosen = options(0);
  CHECK(message_of([&] { chosen.validate(); }) == "points_per_site: is 0; must be at least 1");
}

TEST_CASE("sampling a surface can be cancelled") {
  SurfaceOptions chosen = options(64);
  chosen.tessellation.cancelled = [] { return true; };
  CHECK_THROWS_AS(ccvt::sample_surface<float>(sphere(20, 10), 100, chosen), ccvt::Cancelled);
  // Later: all sites are on the surface still.
  const TriangleMesh mesh = torus(20, 10);
  int calls = 0;
  chosen.tessellation.on_iteration = [&](const ccvt::IterationRecord&) {
    ++calls;
    return false;
  };
  chosen.tessellation.cancelled = {};
  const auto samples = ccvt::sample_surface<float>(mesh, 100, chosen);
  CHECK(samples.summary.termination == ccvt::Termination::cancelled);
  CHECK(faults(mesh, samples, 100, 64) == "");
  CHECK(calls == 1);
}

TEST_CASE("progress and seconds never fall, whatever the parts of a run") {
  SurfaceOptions chosen = options(64);
  double progress = 0;
  double seconds = 0;
  bool falls = false;
  chosen.tessellation.on_iteration = [&](const ccvt::IterationRecord& record) {
    falls = falls || record.progress < progress || record.seconds < seconds;
    progress = record.progress;
    seconds = record.seconds;
    return true;
  };
  ccvt::sample_surface<float>(torus(20, 10), 100, chosen);
  CHECK_FALSE(falls);
  CHECK(progress == 1);
}

TEST_CASE("samples of a surface in files are the samples") {
  const TemporaryDirectory directory;
  const auto samples = ccvt::sample_surface<float>(torus(12, 8), 9, options(32));
  ccvt::write_samples(directory / "s.ply", samples);
  const std::string ply = get(directory / "s.ply");
  CHECK(ply.find("property float nx\nproperty float ny\nproperty float nz\nproperty float radius\n"
                 "property int capacity\nproperty float weight\nproperty int triangle\n"
                 "property float u\nproperty float v\nend_header\n") != std::string::npos);
  for (const char* const name : {"s.csv", "s.ply"}) {
    ccvt::write_samples(directory / name, samples);
    const auto read = ccvt::read_points<double>(
        directory / name, {.columns = {"x", "y", "z", "nx", "ny", "nz", "radius", "capacity",
                                       "weight", "triangle", "u", "v"}});
    REQUIRE(read.cols() == 9);
    CHECK((read.topRows(3) - samples.sites.eigen()).cwiseAbs().maxCoeff() < 1e-6);
    CHECK((read.middleRows(3, 3) - samples.normals.eigen()).cwiseAbs().maxCoeff() < 1e-6);
    CHECK((read.bottomRows(2) - samples.barycentric.eigen().bottomRows(2)).cwiseAbs().maxCoeff() <
          1e-6);
    for (Eigen::Index s = 0; s < 9; ++s) {
      const auto k = static_cast<std::size_t>(s);
      CHECK(read(6, s) == doctest::Approx(samples.radii[k]));
      CHECK(read(7, s) == samples.capacities[k]);
      CHECK(read(8, s) == doctest::Approx(samples.weights[k]));
      CHECK(read(9, s) == samples.triangles[k]);
    }
  }
  for (const char* const name : {"s.vtp", "s.vtk", "s.txt"}) {
    ccvt::write_samples(directory / name, samples);
  }
  CHECK(get(directory / "s.vtk").find("SCALARS normal float 3\n") != std::string::npos);
  CHECK(get(directory / "s.vtp").find("Name=\"normal\" NumberOfComponents=\"3\"") !=
        std::string::npos);
  ccvt::write_samples(directory / "s.npy", samples);
  CHECK(samples.sites == ccvt::read_points<double>(directory / "s.npy"));
  // What float32 cannot hold is written as float64.
  SurfaceSamples heavy = samples;
  for (const double weight : {1e300, 1e-60}) {
    heavy.weights.assign(9, weight);
    for (const char* const name : {"h.csv", "h.ply"}) {
      ccvt::write_samples(directory / name, heavy);
      const auto read = ccvt::read_points<double>(directory / name, {.columns = {"weight"}});
      CHECK(read(0, 4) == weight);
    }
  }
  SurfaceSamples wrong = samples;
  wrong.radii.pop_back();
  CHECK(message_of([&] { ccvt::write_samples(directory / "w.csv", wrong); }) ==
        "samples: 9 sites have 8 numbers in the column radius; needs 9");
  CHECK(message_of([&] { ccvt::write_samples(directory / "w.csv", SurfaceSamples{}); }) ==
        "samples: there are none");
}

TEST_CASE("the preview shows the samples that can be seen") {
  const TriangleMesh mesh = sphere(48, 24);
  SurfaceSamples samples;
  samples.area = 4 * std::numbers::pi;
  samples.radii = {1};
  const auto ink_of = [&](const Eigen::Vector3d& at) {
    samples.sites = at.normalized();
    samples.normals = at.normalized();
    const auto image = ccvt::preview(mesh, samples, 100);
    CHECK(image.width == 100);
    CHECK(image.height == 100);
    CHECK(image.rgb[0] == 255);  // a corner
    int ink = 0;
    for (std::size_t p = 0; p < image.rgb.size(); p += 3) {
      ink += image.rgb[p] > image.rgb[p + 2] + 60 ? 1 : 0;
    }
    return ink;
  };
  CHECK(ink_of({0.5, -0.75, 0.5}) > 20);
  CHECK(ink_of({-0.5, 0.75, -0.5}) == 0);
  // Axes turned together with what points up: the same picture, but for rounding.
  TriangleMesh turned = mesh;
  SurfaceSamples with = samples;
  for (auto* const columns : {&turned.vertices, &with.sites, &with.normals}) {
    const Eigen::MatrixXd before = columns->eigen();
    columns->eigen() << before.row(1), before.row(2), before.row(0);
  }
  const auto differing = [&](int up) {
    const auto a = ccvt::preview(turned, with, 100, up).rgb;
    const auto b = ccvt::preview(mesh, samples, 100).rgb;
    REQUIRE(a.size() == b.size());
    return std::inner_product(a.begin(), a.end(), b.begin(), 0, std::plus<>(),
                              std::not_equal_to<>());
  };
  CHECK(differing(1) < 100);
  CHECK(differing(2) > 1000);
  CHECK(message_of([&] { (void)ccvt::preview(mesh, samples, 100, 3); }) ==
        "up: is 3; must be from 0 to 2");
  CHECK(message_of([&] { (void)ccvt::preview(mesh, samples, 15); }) ==
        "size: is 15; must be from 16 to 4096");
}

TEST_SUITE_END();
