// Surfaces beside vertices that are far away, and pictures of samples that are anywhere.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "ccvt/surface.h"
#include "support/meshes.h"
#include "support/message.h"

using ccvt::Columns;
using ccvt::Index;
using ccvt::SurfaceOptions;
using ccvt::SurfaceSamples;
using ccvt::TriangleMesh;
using namespace ccvt::test;

namespace {

/// With a vertex far away that no triangle uses, and a triangle that is a point there.
TriangleMesh with_strays(const TriangleMesh& mesh, double far_away) {
  TriangleMesh result;
  const auto vertices = static_cast<Index>(mesh.vertices.cols());
  const auto triangles = static_cast<Index>(mesh.triangles.cols());
  result.vertices = Columns<double>(3, vertices + 2);
  result.vertices.eigen() << mesh.vertices.eigen(), Eigen::Matrix<double, 3, 2>::Constant(far_away);
  result.vertices(1, vertices + 1) = -far_away;
  result.triangles = Columns<Index>(3, triangles + 1);
  result.triangles.eigen() << mesh.triangles.eigen(),
      Eigen::Matrix<Index, 3, 1>::Constant(vertices);
  return result;
}

SurfaceSamples samples_of(const TriangleMesh& mesh) {
  SurfaceOptions options;
  options.points_per_site = 32;
  options.tessellation.threads = 1;
  return ccvt::sample_surface<float>(mesh, 40, options);
}

}  // namespace

TEST_SUITE_BEGIN("surface");

TEST_CASE("vertices of no triangle with an area change nothing") {
  const TriangleMesh mesh = square(4);
  const SurfaceSamples samples = samples_of(mesh);
  const auto picture = ccvt::preview(mesh, samples, 100).rgb;
  for (const double far_away : {1e7, 1e300}) {
    CAPTURE(far_away);
    const TriangleMesh strays = with_strays(mesh, far_away);
    const SurfaceSamples others = samples_of(strays);
    CHECK(others.sites.eigen() == samples.sites.eigen());
    CHECK(others.radii == samples.radii);
    CHECK(ccvt::preview(strays, others, 100).rgb == picture);
  }
}

TEST_CASE("a line far away has no area, though its ends are rounded where they are looked at") {
  TriangleMesh mesh = square(4);
  mesh.vertices.eigen().colwise() += Eigen::Vector3d(0.1, 0.2, 0.3);
  const auto vertices = static_cast<Index>(mesh.vertices.cols());
  const auto triangles = static_cast<Index>(mesh.triangles.cols());
  TriangleMesh with_line;
  with_line.vertices = Columns<double>(3, vertices + 3);
  with_line.vertices.eigen() << mesh.vertices.eigen(),
      1e10 * Eigen::Vector3d::Ones() * Eigen::RowVector3d(1, 2, 4);
  with_line.triangles = Columns<Index>(3, triangles + 1);
  with_line.triangles.eigen() << mesh.triangles.eigen(),
      Eigen::Vector3i(vertices, vertices + 1, vertices + 2);
  CHECK(samples_of(with_line).sites.eigen() == samples_of(mesh).sites.eigen());
}

TEST_CASE("a preview refuses samples of no size, and draws none that is far away") {
  const TriangleMesh mesh = square(4);
  const SurfaceSamples samples = samples_of(mesh);
  SurfaceSamples bad = samples;
  const auto refusal = [&] { return message_of([&] { (void)ccvt::preview(mesh, bad, 64); }); };
  bad.radii[1] = NAN;
  CHECK(refusal() == "samples: radius 1 is nan; must be finite and not negative");
  bad.radii[1] = -1;
  CHECK(refusal() == "samples: radius 1 is -1; must be finite and not negative");
  bad = samples;
  bad.area = INFINITY;
  CHECK(refusal() == "samples: area is inf; must be finite and not negative");
  const auto without = [&](double x, double y, double z) {
    SurfaceSamples moved = samples;
    moved.sites.eigen().col(3) << x, y, z;
    return ccvt::preview(mesh, moved, 64).rgb;
  };
  const auto beside = without(0, 9, 0);
  CHECK(beside != ccvt::preview(mesh, samples, 64).rgb);
  for (const double far_away : {1e12, -1e12, 1e300, -1e300, 1e308}) {
    CAPTURE(far_away);
    CHECK(without(far_away, 0, 0) == beside);
    CHECK(without(0, far_away, -far_away) == beside);
  }
}

TEST_SUITE_END();
