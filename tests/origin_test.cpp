// What is far from the origin comes out as well as what is near it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "exact/weighted_sites.h"
#include "support/files.h"
#include "support/oracle.h"

using ccvt::Box;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Distribution;
using ccvt::Grid;
using ccvt::Index;
using ccvt::Points;
using ccvt::sample_uniform;
using ccvt::train_codebook;
using ccvt::VolumeSamples;
using namespace ccvt::test;

namespace {

const Eigen::Vector3d kFar(5e5, 5.4e6, 1e3);

VolumeSamples samples_at(const Eigen::Vector3d& origin, const std::vector<float>& values) {
  const Grid grid = Grid::spaced({16, 16, 16}, Eigen::Vector3d::Constant(0.1), origin);
  return ccvt::sample_volume(grid.density(values), 500, {.points_per_site = 32});
}

std::vector<float> slope() {
  std::vector<float> values(4096);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 1 + static_cast<float>(i % 16);
  return values;
}

std::size_t distinct(const Eigen::MatrixXd& sites, Eigen::Index d) {
  std::set<double> values;
  for (Eigen::Index s = 0; s < sites.cols(); ++s) values.insert(sites(d, s));
  return values.size();
}

}  // namespace

TEST_SUITE_BEGIN("origin");

TEST_CASE("samples of a volume move with its origin") {
  const std::vector<float> values = slope();
  const VolumeSamples near = samples_at(Eigen::Vector3d::Zero(), values);
  const VolumeSamples far = samples_at(kFar, values);
  const Eigen::MatrixXd moved = far.sites.eigen().colwise() - kFar;
  CHECK((moved - near.sites.eigen()).cwiseAbs().maxCoeff() < 1e-3 * 0.1);
  CHECK(far.radii == near.radii);
  CHECK(far.summary.energy == near.summary.energy);
  for (Eigen::Index d = 0; d < 3; ++d) CHECK(distinct(far.sites, d) > 450);
}

TEST_CASE("a density in a box of its own moves with it") {
  const std::vector<float> values = slope();
  const Eigen::Vector3d side = Eigen::Vector3d::Constant(1.6);
  const auto samples = [&](const Eigen::Vector3d& corner) {
    return ccvt::sample_volume({values, {16, 16, 16}, Box{corner, corner + side}}, 400,
                               {.points_per_site = 32});
  };
  // Powers of two: the far box has the same sides, to the last bit.
  const Eigen::Vector3d corner(524288, 4194304, -1024);
  const auto near = samples(Eigen::Vector3d::Zero());
  const auto far = samples(corner);
  CHECK(far.summary.energy == doctest::Approx(near.summary.energy).epsilon(0.02));
  CHECK(distinct(far.sites, 1) > 360);
  CHECK(((far.sites.eigen().colwise() - corner).array() > 0).all());
  CHECK(((far.sites.eigen().colwise() - corner).array() < 1.6).all());
}

TEST_CASE("files hold as many digits as far samples need, and no more") {
  const TemporaryDirectory directory;
  const std::vector<float> values = slope();
  const VolumeSamples near = samples_at(Eigen::Vector3d::Zero(), values);
  const VolumeSamples far = samples_at(kFar, values);
  for (const bool is_far : {false, true}) {
    const VolumeSamples& samples = is_far ? far : near;
    const double error = is_far ? 0 : 1e-6;
    for (const char* const name : {"s.ply", "s.csv", "s.txt", "s.npy"}) {
      ccvt::write_samples(directory / name, samples);
      const auto read = ccvt::read_points<double>(directory / name);
      CAPTURE(name);
      REQUIRE(read.rows() >= 3);
      CHECK((read.topRows(3) - samples.sites.eigen()).cwiseAbs().maxCoeff() <= error);
    }
    const std::string ply = get(directory / "s.ply");
    const std::string real = is_far ? "property double " : "property float ";
    CHECK(ply.find(real + "x\n") != std::string::npos);
    CHECK(ply.find(real + "weight\n") != std::string::npos);
    ccvt::write_samples(directory / "s.vtk", samples);
    CHECK(get(directory / "s.vtk").find(is_far ? "POINTS 500 double" : "POINTS 500 float") !=
          std::string::npos);
    ccvt::write_samples(directory / "s.vtp", samples);
    const std::string type = is_far ? "Float64" : "Float32";
    CHECK(get(directory / "s.vtp").find("type=\"" + type + "\" Name=\"Points\"") !=
          std::string::npos);
  }
  VolumeSamples wide = near;
  wide.scalar = ccvt::ScalarType::float64;
  ccvt::write_samples(directory / "s.ply", wide);
  CHECK(get(directory / "s.ply").find("property double x\n") != std::string::npos);
}

TEST_CASE("double points 10 million sides of their box away are tessellated as well as near ones") {
  const auto near = ccvt::sample_uniform<double>(Box::unit(2), 200 * 64, 3);
  const Eigen::MatrixXd far = near.array() + 1e7;
  for (const bool periodic : {false, true}) {
    const auto energy_of = [&](const Eigen::MatrixXd& points, double corner) {
      Box box = Box::unit(2);
      box.lower.eigen().array() += corner;
      box.upper.eigen().array() += corner;
      ccvt::Problem<double> problem(points, 200);
      problem.set_domain(periodic ? ccvt::Domain::periodic(box) : ccvt::Domain::euclidean(box));
      const auto result = ccvt::tessellate(problem, {.seed = 2});
      CHECK(result.summary.termination == ccvt::Termination::stable);
      CHECK(result.summary.warnings.empty());
      return result.summary.energy;
    };
    CHECK(energy_of(far, 1e7) == doctest::Approx(energy_of(near, 0)).epsilon(0.01));
  }
}

TEST_CASE("codebooks of double vectors far away are as good as near ones") {
  for (const int dimension : {2, 16}) {
    const auto near = ccvt::sample_uniform<double>(Box::unit(dimension), 4000, 3);
    const Eigen::MatrixXd far = near.array() + 1e7;
    for (const auto method : {ccvt::CodebookMethod::exact, ccvt::CodebookMethod::pairwise,
                              ccvt::CodebookMethod::lloyd}) {
      const ccvt::CodebookOptions options{.method = method, .restarts = 1};
      const auto a = ccvt::train_codebook(near, 40, options);
      const auto b = ccvt::train_codebook(far, 40, options);
      CAPTURE(dimension);
      CAPTURE(ccvt::to_string(method));
      CHECK(b.summary.distortion == doctest::Approx(a.summary.distortion).epsilon(0.02));
      CHECK(a.summary.warnings.empty());
      CHECK(b.summary.warnings.empty());
      const auto codes = b.codebook.encode(far);
      CHECK(b.codebook.distortion(far, codes) <= b.summary.distortion * (1 + 1e-9));
    }
  }
}

TEST_CASE("float points that are coarse where they are get a warning, others none") {
  const auto near = ccvt::sample_uniform<float>(Box::unit(2), 200 * 64, 3);
  const auto warnings_at = [&](float x, float y) {
    const Eigen::MatrixXf points = near.colwise() + Eigen::Vector2f(x, y);
    return ccvt::tessellate(points, 200, {.max_iterations = 2}).summary.warnings;
  };
  CHECK(warnings_at(0, 0).empty());
  CHECK(warnings_at(-1e3F, 1e3F).empty());  // steps of 6e-5 among points .009 apart
  const auto warnings = warnings_at(-3, 5e5F);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("points: coordinate 1 is about 5e+05, where float32 has steps of 0.031") ==
        0);
  const auto collapsed = warnings_at(1e9F, 1e9F);
  REQUIRE(collapsed.size() == 1);
  CHECK(collapsed[0] == "points: all are in one place, as far as float32 can tell");

  const Eigen::MatrixXf far = near.array() + 5e5F;
  const auto training = ccvt::train_codebook(far, 200, {.max_iterations = 2});
  REQUIRE(training.summary.warnings.size() == 1);
  CHECK(training.summary.warnings[0].find("vectors: coordinate 0 is about") == 0);
}

TEST_CASE("no warning of thin, clustered or whole-numbered points, or for a few far away") {
  const auto warnings_of = [](const Eigen::MatrixXf& points) {
    return ccvt::tessellate(points, 20, {.max_iterations = 2}).summary.warnings;
  };
  const Eigen::MatrixXf even = ccvt::sample_uniform<float>(Box::unit(2), 2000, 3);
  Eigen::MatrixXf thin = even;
  thin.row(1) *= 1e-9F;
  CHECK(warnings_of(thin).empty());
  Eigen::MatrixXf outlier = even;
  outlier.col(7).setConstant(1e9F);
  CHECK(warnings_of(outlier).empty());
  CHECK(warnings_of((even * 1000).array().floor().matrix()).empty());
}

TEST_CASE("one point far away keeps no others from being exchanged") {
  Eigen::MatrixXd points = ccvt::sample_uniform<double>(Box::unit(2), 3000, 5);
  for (const double away : {1e9, 1e14}) {
    CAPTURE(away);
    points.col(77).setConstant(away);
    const auto result = ccvt::tessellate(points, 20);
    CHECK(result.summary.termination == ccvt::Termination::stable);
    // Without the cell of that point, which comes last.
    const Index strays = result.owners[77];
    Eigen::MatrixXd sites = result.sites;
    sites.col(strays).swap(sites.col(19));
    std::vector<Index> others;
    std::vector<Index> owners;
    for (Index p = 0; p < points.cols(); ++p) {
      const Index owner = result.owners[static_cast<std::size_t>(p)];
      if (owner == strays) continue;
      others.push_back(p);
      owners.push_back(owner == 19 ? strays : owner);
    }
    const Eigen::MatrixXd near = points(Eigen::all, others);
    CHECK(stability_faults(ccvt::Problem<double>(near, 19),
                           ccvt::Points<double>(sites.leftCols(19)), owners) == "");
  }
}

TEST_CASE("one weight far from all others costs these no digits") {
  for (const double far : {1e12, -1e12}) {
    std::vector<double> weights = {0.1, 0.25, far, 0.5, 0.75};
    ccvt::bring_near_zero(weights);
    CHECK(weights[1] - weights[0] == doctest::Approx(0.15).epsilon(1e-15));
    CHECK(weights[4] - weights[3] == 0.25);
    CHECK(weights[2] == far - (far > 0 ? 0.5 : 0.25));
  }
}

TEST_CASE("a vector so far away that it hides the others is named") {
  Points<float> points = sample_uniform<float>(Box::unit(8), 3000, 5, Distribution::white);
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    CAPTURE(to_string(method));
    const CodebookOptions options{.method = method, .effort = 0};
    for (const float far : {1.0F, 1e4F}) {
      points(2, 5) = far;
      CHECK(train_codebook(points, 20, options).summary.warnings.empty());
    }
    points(2, 5) = 1e12F;
    points(3, 5) = -1e12F;
    points(1, 77) = 1e12F;
    const std::vector<std::string> warnings = train_codebook(points, 20, options).summary.warnings;
    // Lloyd's gives them a codeword of their own.
    REQUIRE(warnings.size() == (method == CodebookMethod::lloyd ? 0 : 1));
    if (warnings.empty()) continue;
    CHECK(warnings[0] ==
          "vectors: vectors[5], and perhaps others, lie so far away that the cost of most cells is "
          "lost beside theirs, and codewords are not in place: leave them out");
    points(3, 5) = points(1, 77) = 0.5F;
  }
}

TEST_SUITE_END();
