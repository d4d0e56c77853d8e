#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <vector>

#include "ccvt/sampling.h"
#include "ccvt/surface.h"
#include "ccvt/volume.h"
#include "support/meshes.h"

using ccvt::Grid;
using ccvt::Index;

namespace {

/// How many pixels are orange.
double orange(const ccvt::ColourImage& image) {
  double dots = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    dots += image.rgb[i] > image.rgb[i + 2] + 50 ? 1 : 0;
  }
  return dots;
}

// Which share of a preview's pixels is orange, of `count` samples in an even cube.
double orange(int count) {
  const Grid grid =
      Grid::spaced({20, 20, 20}, Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1000, 0, 0));
  const std::vector<float> values(8000, 1.0F);
  const ccvt::Points<double> sites =
      (20 * ccvt::sample_uniform<double>(ccvt::Box::unit(3), count).array() - 0.5)
          .matrix()
          .colwise() +
      Eigen::Vector3d(1000, 0, 0);
  const auto image = ccvt::preview(grid.density(values), sites, 200);
  return orange(image) / (3 * 200 * 200);
}

/// Squares of side 1, the first facing up and the others facing down, one below the other.
ccvt::TriangleMesh sheets(const std::vector<double>& heights) {
  ccvt::TriangleMesh mesh;
  const auto n = static_cast<Index>(heights.size());
  mesh.vertices = ccvt::Columns<double>(3, Index{4} * n);
  mesh.triangles = ccvt::Columns<Index>(3, Index{2} * n);
  for (Index k = 0; k < n; ++k) {
    ccvt::TriangleMesh one = ccvt::test::square(1, heights[static_cast<std::size_t>(k)]);
    if (k > 0) one.triangles = ccvt::Columns<Index>(one.triangles.eigen().colwise().reverse());
    mesh.vertices.eigen().middleCols(Index{4} * k, 4) = one.vertices.eigen();
    mesh.triangles.eigen().middleCols(Index{2} * k, 2) = one.triangles.eigen().array() + 4 * k;
  }
  return mesh;
}

/// Of a preview with some samples in the middle of a sheet at `height`, which faces `up` or down.
double orange(const ccvt::TriangleMesh& mesh, double height, double up) {
  ccvt::SurfaceSamples samples;
  samples.sites = ccvt::Columns<double>(3, 9);
  samples.normals = ccvt::Columns<double>(3, 9);
  samples.radii.assign(9, 0.1);
  samples.area = 1;
  for (Index k = 0; k < 9; ++k) {
    samples.sites.eigen().col(k) << 0.3 + 0.2 * (k % 3), 0.3 + 0.2 * (k / 3), height;
    samples.normals.eigen().col(k) << 0, 0, up;
  }
  return orange(ccvt::preview(mesh, samples, 300));
}

}  // namespace

TEST_SUITE_BEGIN("volume");

TEST_CASE("a preview refuses sites that are nowhere") {
  const Grid grid = Grid::spaced({4, 4, 4}, Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0, 0, 0));
  const std::vector<float> values(64, 1.0F);
  ccvt::Points<double> sites = ccvt::Points<double>::Ones(3, 3);
  sites(2, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(ccvt::preview(grid.density(values), sites, 50),
                       "sites: site 1 has a coordinate that is not finite", ccvt::InvalidInput);
}

TEST_CASE("a preview stays readable with any number of samples") {
  for (const int count : {100, 500, 5'000, 20'000, 200'000}) {
    CAPTURE(count);
    const double share = orange(count);
    MESSAGE(count << " samples: " << share);
    CHECK(share > 0.01);
    CHECK(share < 0.15);
  }
}

TEST_CASE("what a sheet hides does not show, however near it is") {
  for (const double gap : {0.003, 0.01, 0.03}) {
    CAPTURE(gap);
    const ccvt::TriangleMesh two = sheets({gap, 0});
    CHECK(orange(two, gap, 1) > 500);
    CHECK(orange(two, 0, -1) == 0);
  }
  // From behind.
  ccvt::TriangleMesh one = sheets({0});
  one.triangles = ccvt::Columns<Index>(one.triangles.eigen().colwise().reverse());
  CHECK(orange(one, 0, -1) > 500);
}

TEST_SUITE_END();
