#include "ccvt/volume.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "support/files.h"
#include "support/oracle.h"

using ccvt::DensityGrid;
using ccvt::Grid;
using ccvt::Index;
using ccvt::InvalidInput;
using ccvt::ValueMap;
using ccvt::Volume;
using ccvt::VolumeOptions;
using ccvt::VolumeSamples;
using namespace ccvt::test;

namespace {

template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A smooth bump in a box of 30 x 24 x 27 mm, sampled at voxels of 1 x 1 x 3 mm, in a turned world.
struct Bump {
  Grid grid;
  std::vector<float> values;

  static double density(const Eigen::Vector3d& x) {  // in millimetres from the first centre
    return 0.08 + std::exp(-(x - Eigen::Vector3d(13, 12, 14)).squaredNorm() / 120);
  }
  Eigen::Vector3d local(const Eigen::Vector3d& world) const {
    return grid.spacing().cwiseProduct(grid.axes.eigen().inverse() * (world - grid.origin.eigen()));
  }

  Bump() : grid(Grid::spaced({30, 24, 9}, Eigen::Vector3d(1, 1, 3), Eigen::Vector3d(50, 0, -7))) {
    for (int k = 0; k < 9; ++k) {
      for (int j = 0; j < 24; ++j) {
        for (int i = 0; i < 30; ++i) {
          values.push_back(static_cast<float>(density(Eigen::Vector3d(i, j, 3 * k))));
        }
      }
    }
    grid.axes = Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 3).normalized()) *
                Eigen::Matrix3d(grid.axes.eigen());
  }
};

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n;
  const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return ab / std::sqrt(aa * bb);
}

VolumeSamples small_samples() {
  const Grid grid = Grid::spaced({4, 4, 4}, Eigen::Vector3d(1, 2, 1), Eigen::Vector3d(0, 0, 0));
  const std::vector<float> values(64, 1.0F);
  return ccvt::sample_volume<float>(grid.density(values), 7, {.points_per_site = 20});
}

}  // namespace

TEST_SUITE_BEGIN("volume");

TEST_CASE("the density of the samples follows the field, with voxels of 1 x 1 x 3 mm") {
  const Bump bump;
  const auto samples =
      ccvt::sample_volume<float>(bump.grid.density(bump.values), 2000, {.points_per_site = 128});
  CHECK(samples.summary.termination == ccvt::Termination::stable);
  std::vector<double> densities;
  std::vector<double> fields;
  for (Eigen::Index s = 0; s < samples.sites.cols(); ++s) {
    const double radius = samples.radii[static_cast<std::size_t>(s)];
    densities.push_back(1 / (radius * radius * radius));
    fields.push_back(Bump::density(bump.local(samples.sites.col(s))));
  }
  const double r = correlation(densities, fields);
  MESSAGE("correlation of 1 / radius^3 with the field: " << r);
  CHECK(r > 0.98);
}

TEST_CASE("cells of a uniform field are as wide along long voxels as across them") {
  const Grid grid = Grid::spaced({30, 30, 10}, Eigen::Vector3d(1, 1, 3), Eigen::Vector3d::Zero());
  const std::vector<std::uint8_t> values(9000, 200);
  const auto points = ccvt::sample_density<float>(grid.density(values), 64 * 1000, 3);
  const auto result = ccvt::tessellate(points, 1000);
  const auto samples = ccvt::sample_volume<float>(
      grid.density(values), 1000, {.points_per_site = 64, .tessellation = {.seed = 3}});
  Eigen::Vector3d squared = Eigen::Vector3d::Zero();
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    squared += (points.col(p) - result.sites.col(result.owners[static_cast<std::size_t>(p)]))
                   .cast<double>()
                   .cwiseAbs2();
  }
  CHECK(squared[2] / squared[0] == doctest::Approx(1).epsilon(0.03));
  CHECK(squared[1] / squared[0] == doctest::Approx(1).epsilon(0.03));
  // Of all cells of 27 mm^3 a ball has the least radius of this kind, and theirs are nearly balls.
  const double ball = std::cbrt(27 * 0.75 / M_PI);
  double mean_square = 0;
  for (const double radius : samples.radii) mean_square += radius * radius / 1000;
  CHECK(mean_square > ball * ball);
  CHECK(mean_square < 1.15 * ball * ball);
}

TEST_CASE("capacities, weights and radii are those of the cells") {
  const Bump bump;
  const DensityGrid density = bump.grid.density(bump.values);
  const VolumeOptions options{
      .points_per_site = 50, .keep_points = true, .tessellation = {.seed = 4}};
  const auto samples = ccvt::sample_volume<double>(density, 150, options);
  const Eigen::MatrixXd points = samples.points;
  CHECK((points - ccvt::sample_density<double>(density, 7500, 4)).cwiseAbs().maxCoeff() < 1e-12);
  const ccvt::Problem<double> problem(points, 150);
  const ccvt::Result<double> result{samples.sites, samples.owners, samples.summary};
  CHECK(faults(problem, result) == "");

  std::vector<double> squared(150);
  for (Eigen::Index p = 0; p < 7500; ++p) {
    const Index owner = result.owners[static_cast<std::size_t>(p)];
    squared[static_cast<std::size_t>(owner)] +=
        (points.col(p) - result.sites.col(owner)).squaredNorm();
  }
  double mass = 0;
  for (const float value : bump.values) mass += 3 * static_cast<double>(value);
  for (std::size_t s = 0; s < 150; ++s) {
    CHECK(samples.capacities[s] == 50);
    CHECK(samples.weights[s] == doctest::Approx(mass / 150));
    CHECK(samples.radii[s] == doctest::Approx(std::sqrt(5.0 / 3 * squared[s] / 50)));
  }
}

TEST_CASE("weights are finite where the integral is") {
  const std::vector<double> values(8, 1e304);
  const Eigen::Vector3d one(1, 1, 1);
  const DensityGrid density = Grid::spaced({2, 2, 2}, one, one).density(values);
  const auto samples = ccvt::sample_volume<float>(density, 4, {.points_per_site = 20000});
  for (const double weight : samples.weights) CHECK(weight == doctest::Approx(2e304));
}

TEST_CASE("one seed gives the same samples for any number of threads") {
  const Bump bump;
  const auto run = [&](int threads) {
    return ccvt::sample_volume<float>(
        bump.grid.density(bump.values), 200,
        {.points_per_site = 64, .tessellation = {.threads = threads, .seed = 9}});
  };
  const auto one = run(1);
  const auto two = run(2);
  CHECK(one.sites == two.sites);
  CHECK(one.radii == two.radii);
  CHECK(one.weights == two.weights);
}

TEST_CASE("volumes in two and four dimensions") {
  for (const int dimension : {2, 4}) {
    const auto d = static_cast<std::size_t>(dimension);
    const Grid grid =
        Grid::spaced(std::vector<std::int64_t>(d, 6), Eigen::VectorXd::Constant(dimension, 2),
                     Eigen::VectorXd::Zero(dimension));
    const std::vector<double> values(static_cast<std::size_t>(std::pow(6, dimension)), 3.0);
    const auto samples = ccvt::sample_volume<double>(grid.density(values), 40, {});
    CHECK(samples.sites.rows() == dimension);
    CHECK(samples.sites.eigen().minCoeff() > -1);
    CHECK(samples.sites.eigen().maxCoeff() < 11);
    CHECK(std::accumulate(samples.weights.begin(), samples.weights.end(), 0.0) ==
          doctest::Approx(3 * std::pow(12, dimension)));
  }
}

TEST_CASE("values become densities by their map") {
  const double most = 8;
  const auto at = [&](ValueMap map, double value) { return map(value, most); };
  using Kind = ValueMap::Kind;
  CHECK(at({}, 3) == 3);
  CHECK(at({.invert = true}, 3) == 5);
  const ValueMap window{.kind = Kind::window, .low = -2, .high = 6};
  CHECK(at(window, -3) == 0);
  CHECK(at(window, 0) == 0.25);
  CHECK(at(window, 7) == 1);
  CHECK(at({.kind = Kind::window, .low = -2, .high = 6, .invert = true}, 0) == 0.75);
  CHECK(at({.kind = Kind::threshold, .low = 3}, 3) == 1);
  CHECK(at({.kind = Kind::threshold, .low = 3}, 2.9) == 0);
  CHECK(at({.kind = Kind::threshold, .low = 3, .invert = true}, 3) == 0);
  CHECK(at({.kind = Kind::gamma, .gamma = 2}, 4) == 0.25);
  CHECK(at({.kind = Kind::gamma, .gamma = 2, .invert = true}, 6) == 0.0625);
  // Refused as a density, where a square would be taken for one.
  CHECK(at({.kind = Kind::gamma, .gamma = 2}, -4) == -4);
  CHECK(std::isnan(at(window, NAN)));
  CHECK(std::isnan(at({.kind = Kind::threshold}, NAN)));
  CHECK(mentions(refusal([] { ValueMap{.kind = Kind::window, .low = 2, .high = 2}.validate(); }),
                 "low: is 2 and high is 2"));
  CHECK(mentions(refusal([] { ValueMap{.gamma = 0}.validate(); }), "gamma: is 0"));
  CHECK(mentions(refusal([] { ValueMap{.low = NAN}.validate(); }), "low: is nan"));
}

TEST_CASE("a volume is sampled where its scaled values and its mask say so") {
  Volume volume;
  volume.grid = Grid::spaced({4, 4, 4}, Eigen::Vector3d(1, 1, 1), Eigen::Vector3d::Zero());
  volume.type = ccvt::VoxelType::int16;
  volume.data.resize(volume.bytes());
  std::vector<std::int16_t> values(64, -1000);  // air, in a CT scan stored from 0 up
  for (std::size_t i = 32; i < 64; ++i) values[i] = 1000;
  values[63] = 3000;
  std::memcpy(volume.data.data(), values.data(), volume.data.size());
  volume.slope = 2;
  volume.intercept = 1000;
  CHECK(volume.greatest() == 7000);
  std::vector<std::uint8_t> mask(64, 1);
  mask[63] = 0;
  CHECK(volume.greatest(mask) == 3000);
  const auto lowest = [&](const DensityGrid& density) {
    return ccvt::sample_density<double>(density, 2000).row(2).minCoeff();
  };
  CHECK(mentions(refusal([&] { lowest(volume.density()); }), "is -1000, and its density -1000"));
  // Values of 0 in the layers 0 and 1; linear up to layer 2.
  CHECK(lowest(volume.density({.kind = ValueMap::Kind::threshold, .low = 0})) > 1);
  CHECK(lowest(volume.density({.kind = ValueMap::Kind::threshold, .low = 0, .invert = true})) < 0);
  const std::vector<std::uint8_t> short_mask(9);
  CHECK(mentions(refusal([&] { (void)volume.density({}, short_mask); }),
                 "mask: has 9 entries for 64 cells"));
}

TEST_CASE("samples in PLY, VTK and text are the samples") {
  const TemporaryDirectory directory;
  const auto samples = small_samples();
  const Eigen::MatrixXf single = samples.sites.eigen().cast<float>();
  const auto number = [](const std::string& bytes, std::size_t at, bool big) {
    std::string raw = bytes.substr(at, 4);
    if (big) std::reverse(raw.begin(), raw.end());
    float value = 0;
    std::memcpy(&value, raw.data(), 4);
    return value;
  };

  ccvt::write_samples(directory / "s.ply", samples);
  const std::string ply = get(directory / "s.ply");
  const std::string end = "property float weight\nend_header\n";
  CHECK(
      mentions(ply, "ply\nformat binary_little_endian 1.0\nelement vertex 7\nproperty float x\n"));
  CHECK(mentions(ply, "property float radius\nproperty int capacity\n" + end));
  const std::size_t body = ply.find(end) + end.size();
  CHECK(ply.size() == body + 7 * 24);
  for (std::size_t s = 0; s < 7; ++s) {
    for (std::size_t d = 0; d < 3; ++d) {
      CHECK(number(ply, body + 24 * s + 4 * d, false) ==
            single(static_cast<Eigen::Index>(d), static_cast<Eigen::Index>(s)));
    }
    CHECK(number(ply, body + 24 * s + 12, false) == static_cast<float>(samples.radii[s]));
    CHECK(ply.substr(body + 24 * s + 16, 4) == std::string("\x14\0\0\0", 4));
  }

  ccvt::write_samples(directory / "s.vtk", samples);
  const std::string vtk = get(directory / "s.vtk");
  const std::size_t points = vtk.find("POINTS 7 float\n") + 15;
  CHECK(number(vtk, points, true) == single(0, 0));
  CHECK(number(vtk, points + 4 * 20, true) == single(2, 6));
  CHECK(vtk.substr(points + 84, 15) == "\nVERTICES 7 14\n");
  const std::size_t radii = vtk.find("SCALARS radius float 1\nLOOKUP_TABLE default\n") + 44;
  CHECK(number(vtk, radii + 4, true) == static_cast<float>(samples.radii[1]));

  ccvt::write_samples(directory / "s.vtp", samples);
  const std::string vtp = get(directory / "s.vtp");
  // Seven Int32 of 20: their length, 28 as UInt64, and they, in base64.
  CHECK(mentions(vtp,
                 "Name=\"capacity\" NumberOfComponents=\"1\" format=\"binary\">"
                 "HAAAAAAAAAAUAAAAFAAAABQAAAAUAAAAFAAAABQAAAAUAAAA</DataArray>"));

  for (const char* const name : {"s.csv", "s.txt"}) {
    ccvt::write_samples(directory / name, samples);
    CHECK(ccvt::read_points<float>(directory / name) == single);
    const ccvt::ReadOptions all{.columns = {"x", "y", "z", "radius", "capacity", "weight"}};
    const auto read = ccvt::read_points<float>(directory / name, all);
    CHECK(read.topRows(3) == single);
    CHECK(read(3, 6) == static_cast<float>(samples.radii[6]));
    CHECK(read(4, 6) == 20);
  }
  CHECK(get(directory / "s.csv").substr(0, 29) == "x,y,z,radius,capacity,weight\n");
  ccvt::write_samples(directory / "s.npy", samples);
  CHECK(samples.sites == ccvt::read_points<double>(directory / "s.npy"));
  CHECK(mentions(refusal([&] { ccvt::write_samples(directory / "s.obj", samples); }),
                 "unknown extension '.obj'"));
  CHECK(directory.entries() == 6);
}

TEST_CASE("the preview shows field and samples where they are") {
  // One bright voxel at (3, 1, 0) of 4 x 2 x 3, and one sample in it, in a mirrored world.
  Grid grid = Grid::spaced({4, 2, 3}, Eigen::Vector3d(1, 2, 1), Eigen::Vector3d(10, 0, 0));
  grid.axes(0, 0) = -1;
  std::vector<float> values(24, 0.0F);
  values[3 + 4 * 1] = 1;
  Eigen::MatrixXf site(3, 1);
  site << 7, 2, 0;
  const auto image = ccvt::preview(grid.density(values), site, 64);
  CHECK(image.height == 64);
  CHECK(image.width == 3 * 64 + 16);
  const auto colour = [&](int x, int y) {
    const auto at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                         static_cast<std::size_t>(x));
    return std::array<int, 3>{image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
  };
  const auto is_dot = [&](int x, int y) { return colour(x, y)[0] > colour(x, y)[2] + 50; };
  int dots = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) dots += is_dot(x, y) ? 1 : 0;
  }
  CHECK(dots == 3 * 24);  // pixels that a disc of radius 2.5 around a corner covers by a third
  // x and y: pixels of 4 mm make 64; the voxel is at the right, in the upper half.
  CHECK(is_dot(56, 16));
  CHECK(colour(60, 4)[1] > 100);
  CHECK(colour(8, 60)[1] == 0);
  CHECK(
      mentions(refusal([&] { (void)ccvt::preview(grid.density(values), site, 1); }), "size: is 1"));
}

TEST_SUITE_END();
