// The program's options for other spaces and for sites that stay.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/io.h"
#include "ccvt/linear_map.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/files.h"
#include "support/process.h"

using namespace std::string_literals;

namespace ccvt::test {

TEST_SUITE_BEGIN("cli");

TEST_CASE("fixed sites, spaces: the program does what the library does") {
  const TemporaryDirectory directory;
  const auto points = sample_uniform<double>(Box::unit(2), 2000, 4, Distribution::white);
  const auto fixed = sample_uniform<double>(Box::unit(2), 5, 6, Distribution::white);
  write_points(directory / "points.npy", points);
  write_points(directory / "fixed.csv", fixed);
  const auto sites_of = [&](const std::string& options) {
    const Ran ran = run(directory, "tessellate points.npy --sites 40 -q -o sites.npy " + options);
    CHECK(ran.status == 0);
    CHECK(ran.errors == "");
    return read_points<double>(directory / "sites.npy");
  };
  Problem<double> problem(points, 40);
  problem.set_fixed_sites(fixed);
  CHECK(sites_of("--fixed-sites fixed.csv") == tessellate(problem).sites);
  problem.set_domain(Domain::periodic(Box::unit(2), {false, true}));
  CHECK(sites_of("--fixed-sites fixed.csv --box 0 0 1 1 --periodic-along 2") ==
        tessellate(problem).sites);

  const auto map = LinearMap::units({1, 3});
  const Points<double> mapped = map(points);
  Problem<double> scaled(mapped, 40);
  scaled.set_fixed_sites(map(fixed));
  const auto sites = sites_of("--fixed-sites fixed.csv --units 1,3");
  CHECK(sites.leftCols(5) == fixed);
  CHECK(sites.rightCols(35) == map.inverse(tessellate(scaled).sites).rightCols(35));
  const auto white = LinearMap::whitening(points);
  const Points<double> whitened = white(points);
  CHECK(sites_of("--whiten") == white.inverse(tessellate(whitened, 40).sites));

  // Of a periodic box the images are meant, in whatever units.
  Points<double> outside(2, 1);
  outside << 0.5, 1.75;
  write_points(directory / "outside.csv", outside);
  const std::string torus = "--fixed-sites outside.csv --box 0 0 1 1 --periodic";
  CHECK(sites_of(torus).col(0) == Eigen::Vector2d(0.5, 0.75));
  CHECK(sites_of(torus + " --units 1,2").col(0) == Eigen::Vector2d(0.5, 0.75));
  // Images of float points on the faces of a box are in the box's image.
  Points<double> faces = points;
  faces.col(0) << 1, 1;
  write_points(directory / "faces.npy", faces);
  const Ran single = run(directory,
                         "tessellate faces.npy --float --sites 40 --box 0 0 1 1 --periodic "
                         "--units 0.1,0.7 -q -o faces_sites.npy");
  CHECK(single.status == 0);
  CHECK(single.errors == "");

  const Ran ran = run(directory,
                      "sample --dim 2 --sites 30 --fixed-sites fixed.csv --double -q "
                      "-o more.npy");
  CHECK(ran.status == 0);
  CHECK(read_points<double>(directory / "more.npy").leftCols(5) == fixed);
}

TEST_CASE("fixed sites, spaces: what cannot be is refused in a line") {
  const TemporaryDirectory directory;
  write_text(directory / "points.csv", "0,0\n1,0\n0,1\n1,1\n");
  write_text(directory / "fixed.csv", "0,0,0\n");
  struct Wrong {
    std::string options;
    std::string message;
  };
  const std::vector<Wrong> all = {
      {"--periodic-along 1", "--periodic-along: needs --box"},
      {"--periodic-along 3 --box 0 0 1 1", "--periodic-along: there is no dimension 3"},
      {"--periodic-along 0 --box 0 0 1 1", "'0' is not a whole number of at least 1"},
      {"--units 1", "--units: there are 1 numbers"},
      {"--units 1,-2", "'-2' is not a finite number above 0"},
      {"--whiten --units 1,2", "--whiten: excludes --units"},
      {"--whiten --box 0 0 1 1", "--whiten: excludes --box"},
      {"--fixed-sites fixed.csv", "fixed sites have 3 coordinates, points have 2"},
      {"--fixed-sites points.csv", "fixed_sites: there are 4 of them"}};
  for (const Wrong& wrong : all) {
    CAPTURE(wrong.options);
    const Ran ran = run(directory, "tessellate points.csv --sites 2 -o sites.csv " + wrong.options);
    CHECK(ran.status == 2);
    CHECK(ran.errors.find(wrong.message) != std::string::npos);
    CHECK(std::count(ran.errors.begin(), ran.errors.end(), '\n') == 1);
  }
  CHECK(directory.entries() == 2);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
