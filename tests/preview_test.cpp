#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <vector>

#include "ccvt/sampling.h"
#include "ccvt/volume.h"

using ccvt::Grid;

namespace {

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
  std::size_t dots = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    dots += image.rgb[i] > image.rgb[i + 2] + 50 ? 1 : 0;
  }
  return static_cast<double>(dots) / (3 * 200 * 200);
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

TEST_SUITE_END();
