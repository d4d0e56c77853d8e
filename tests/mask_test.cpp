// No point and no sample lies where the density is 0.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "random.h"

using ccvt::DensityGrid;
using ccvt::DensitySampling;
using ccvt::Grid;
using ccvt::Index;
using ccvt::Interpolation;
using ccvt::VolumeSamples;

namespace {

constexpr int kSide = 24;

std::size_t cell_number(int i, int j, int k) {
  return static_cast<std::size_t>(i + kSide * (j + kSide * k));
}

// A hollow ball, one voxel thick.
std::vector<std::uint8_t> shell() {
  std::vector<std::uint8_t> mask(std::size_t{kSide} * kSide * kSide);
  for (int k = 0; k < kSide; ++k) {
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const Eigen::Vector3d middle = Eigen::Vector3d::Constant(0.5 * (kSide - 1));
        const double radius = (Eigen::Vector3d(i, j, k) - middle).norm();
        mask[cell_number(i, j, k)] = std::abs(radius - 9) < 0.5 ? 1 : 0;
      }
    }
  }
  return mask;
}

// How many columns lie in cells whose entry is 0, or outside the grid.
int outside(const Eigen::MatrixXd& points, const Grid& grid,
            const std::vector<std::uint8_t>& mask) {
  const Eigen::Matrix3d to_cells = Eigen::Matrix3d(grid.axes.eigen()).inverse();
  int count = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3d at =
        to_cells * (points.col(p) - grid.origin.eigen()) + Eigen::Vector3d::Constant(0.5);
    const bool inside = (at.array() >= 0).all() && (at.array() < kSide).all() &&
                        mask[cell_number(static_cast<int>(at[0]), static_cast<int>(at[1]),
                                         static_cast<int>(at[2]))] != 0;
    count += inside ? 0 : 1;
  }
  return count;
}

Grid turned_grid(const Eigen::Vector3d& origin) {
  Grid grid = Grid::spaced({kSide, kSide, kSide}, Eigen::Vector3d(0.1, 0.1, 0.2), origin);
  grid.axes = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()) *
              Eigen::Matrix3d(grid.axes.eigen());
  return grid;
}

}  // namespace

TEST_SUITE_BEGIN("mask");

TEST_CASE_TEMPLATE("points and samples lie in a mask one voxel thick, near and far", Scalar, float,
                   double) {
  const std::vector<std::uint8_t> mask = shell();
  const std::vector<float> values(mask.size(), 1.0F);
  for (const Eigen::Vector3d& origin :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5e5, 5.4e6, 1e3)}) {
    const Grid grid = turned_grid(origin);
    DensityGrid density = grid.density(values);
    density.mask = mask;
    const VolumeSamples samples =
        ccvt::sample_volume<Scalar>(density, 400, {.points_per_site = 64, .keep_points = true});
    const Eigen::MatrixXd points = samples.points;
    CHECK(outside(points, grid, mask) == 0);
    CHECK(outside(samples.sites, grid, mask) == 0);
    CHECK(samples.put_back > 3);  // cells on a thin curved shell are bent
    CHECK(samples.farthest_put_back > 0);
    CHECK(samples.farthest_put_back < 0.1);

    // The summary is that of the centroids; only those outside were moved, each to its nearest.
    const auto run =
        ccvt::tessellate(ccvt::Problem<double>(points, 400).set_initial_owners(samples.owners),
                         {.max_iterations = 0});
    CHECK(samples.summary.energy == doctest::Approx(run.summary.energy).epsilon(1e-4));
    Index moved = 0;
    double farthest = 0;
    for (Eigen::Index s = 0; s < 400; ++s) {
      const Eigen::Vector3d centroid = run.sites.col(s);
      const double distance = (samples.sites.col(s) - centroid).norm();
      if (distance < 1e-5) continue;
      ++moved;
      farthest = std::max(farthest, distance);
      CHECK(outside(centroid, grid, mask) == 1);
      double least = 1e9;
      for (Eigen::Index p = 0; p < samples.points.cols(); ++p) {
        if (samples.owners[static_cast<std::size_t>(p)] != s) continue;
        least = std::min(least, (samples.points.col(p) - centroid).norm());
      }
      CHECK(distance == doctest::Approx(least).epsilon(1e-4));
    }
    CHECK(moved == samples.put_back);
    CHECK(farthest == doctest::Approx(samples.farthest_put_back).epsilon(1e-4));
  }
}

TEST_CASE("points and samples lie where a threshold leaves a density") {
  ccvt::Volume volume;
  volume.grid = turned_grid({0, 0, 0});
  volume.type = ccvt::VoxelType::uint8;
  const std::vector<std::uint8_t> mask = shell();
  for (const std::uint8_t inside : mask) volume.data.push_back(std::byte{inside});
  const auto samples =
      ccvt::sample_volume(volume.density({.kind = ccvt::ValueMap::Kind::threshold, .low = 1}), 300,
                          {.points_per_site = 32, .keep_points = true});
  CHECK(outside(samples.points, volume.grid, mask) == 0);
  CHECK(outside(samples.sites, volume.grid, mask) == 0);
  CHECK(samples.put_back > 0);
}

TEST_CASE("without zeros nothing is put back, and points are kept only when asked for") {
  const Grid grid = turned_grid({0, 0, 0});
  const std::vector<float> values(std::size_t{kSide} * kSide * kSide, 1.0F);
  const auto samples = ccvt::sample_volume(grid.density(values), 100, {.points_per_site = 32});
  CHECK(samples.put_back == 0);
  CHECK(samples.farthest_put_back == 0);
  CHECK(samples.points.size() == 0);
  CHECK(samples.owners.empty());
}

namespace {

// What each cell is to get: of the mass of a cell, 3/4 along each axis stays in it and 1/8 falls to
// either side, back into the cell itself beyond the grid and where there is no density.
std::vector<double> expected_masses(const std::vector<double>& values, int nx, int ny) {
  std::vector<double> expected(values.size());
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; ++x) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int u = x + dx < 0 || x + dx >= nx ? x : x + dx;
          const int v = y + dy < 0 || y + dy >= ny ? y : y + dy;
          const auto own = static_cast<std::size_t>(x + nx * y);
          const auto other = static_cast<std::size_t>(u + nx * v);
          const double share = (dx == 0 ? 0.75 : 0.125) * (dy == 0 ? 0.75 : 0.125);
          expected[values[other] > 0 ? other : own] += share * values[own];
        }
      }
    }
  }
  return expected;
}

}  // namespace

TEST_CASE("the mass of every cell stays in it and those of its neighbours that have a density") {
  constexpr int nx = 13;
  constexpr int ny = 9;
  ccvt::Random random(4);
  std::vector<double> values(std::size_t{nx} * ny);
  std::vector<std::uint8_t> mask(values.size());
  std::vector<double> masked(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = std::max(0.0, random.uniform() * 1.2 - 0.2);
    mask[i] = random.uniform() < 0.6 ? 1 : 0;
    masked[i] = mask[i] != 0 ? values[i] : 0;
  }
  DensityGrid grid{values, {nx, ny}, ccvt::Box{Eigen::Vector2d(0, 0), Eigen::Vector2d(nx, ny)}};
  grid.mask = mask;
  grid.interpolation = Interpolation::linear;
  const std::vector<double> expected = expected_masses(masked, nx, ny);
  const double mass = std::accumulate(masked.begin(), masked.end(), 0.0);
  constexpr Index count = 200'000;
  for (const auto sampling : {DensitySampling::white, DensitySampling::stratified}) {
    const auto points = ccvt::sample_density<double>(grid, count, 5, sampling);
    std::vector<double> counts(values.size());
    for (Eigen::Index p = 0; p < count; ++p) {
      ++counts[static_cast<std::size_t>(points(0, p)) +
               nx * static_cast<std::size_t>(points(1, p))];
    }
    double chi_square = 0;
    int cells = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (masked[i] == 0) {
        CHECK(counts[i] == 0);
        continue;
      }
      const double wanted = expected[i] / mass * count;
      chi_square += (counts[i] - wanted) * (counts[i] - wanted) / wanted;
      ++cells;
    }
    const double spread = std::sqrt(2.0 * cells);
    CAPTURE(chi_square / cells);
    CHECK(chi_square < cells + 4.5 * spread);
    if (sampling == DensitySampling::white) CHECK(chi_square > cells - 4.5 * spread);
  }
}

TEST_CASE("an even field is even up to the faces of its mask") {
  // 6 x 4 cells inside 10 x 8, and bins of a quarter of a cell.
  std::vector<std::uint8_t> mask(80);
  for (std::size_t y = 2; y < 6; ++y) {
    for (std::size_t x = 2; x < 8; ++x) mask[x + 10 * y] = 1;
  }
  const std::vector<float> values(80, 3.0F);
  DensityGrid grid{values, {10, 8}, ccvt::Box{Eigen::Vector2d(0, 0), Eigen::Vector2d(10, 8)}};
  grid.mask = mask;
  grid.interpolation = Interpolation::linear;
  constexpr Index count = 100'000;
  const auto points = ccvt::sample_density<double>(grid, count, 2, DensitySampling::white);
  std::vector<double> across(24);
  for (Eigen::Index p = 0; p < count; ++p) {
    ++across.at(static_cast<std::size_t>(4 * (points(0, p) - 2)));
  }
  double chi_square = 0;
  for (const double n : across) chi_square += (n - count / 24.0) * (n - count / 24.0) * 24 / count;
  CHECK(chi_square < 23 + 4.5 * std::sqrt(46.0));
}

TEST_SUITE_END();
