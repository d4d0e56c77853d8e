// Runs the program itself, on points with masses.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/weighted.h"
#include "number_text.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/masses.h"
#include "support/message.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

/// points.npy, masses.txt and all of it in table.csv: 600 points.
void write_inputs(const TemporaryDirectory& directory) {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 600);
  const auto masses = make_masses(Masses::even, 600);
  write_points(directory / "points.npy", points);
  Points<double> column(1, 600);
  for (Index p = 0; p < 600; ++p) column(0, p) = masses[at(p)];
  write_points(directory / "masses.txt", column);
  std::string table = "x,y,m\n";
  for (Index p = 0; p < 600; ++p) {
    char line[200];
    std::snprintf(line, sizeof line, "%.17g,%.17g,%.17g\n", points(0, p), points(1, p),
                  masses[at(p)]);
    table += line;
  }
  put(directory / "table.csv", table);
}

}  // namespace

TEST_SUITE_BEGIN("weighted cli");

TEST_CASE("tessellate: masses from a file or a column, and how far cells miss their capacity") {
  const TemporaryDirectory directory;
  write_inputs(directory);
  const Ran ran = run(directory,
                      "tessellate points.npy --masses masses.txt --sites 20 --seed 3 --threads 2 "
                      "-o sites.npy --owners-out owners.npy --summary summary.json");
  CHECK(ran.status == 0);
  CHECK(ran.errors == "");
  CHECK(ran.output.find("; largest mass error ") != std::string::npos);
  CHECK(ran.output.find(" % of its cell's capacity, bound ") != std::string::npos);

  const auto points = read_points<double>(directory / "points.npy");
  const auto masses = read_numbers(directory / "masses.txt");
  const auto expected = tessellate_masses(points, masses, 20, {.relaxation = {.seed = 3}});
  CHECK(read_indices(directory / "owners.npy") == expected.owners);
  CHECK(expected.sites == read_points<double>(directory / "sites.npy"));
  const auto json = nlohmann::json::parse(get(directory / "summary.json"));
  CHECK(json["points"] == 600);
  CHECK(json["energy"] == expected.summary.energy);
  CHECK(json["masses"]["method"] == "whole");
  CHECK(json["masses"]["total"] == expected.total_mass);
  CHECK(json["masses"]["largest_error"] == expected.largest_mass_error);
  CHECK(json["masses"]["worst_site"] == expected.worst_site);
  CHECK(json["masses"]["error_bound"] == expected.mass_error_bound);
  CHECK(json["masses"]["relative_error"] == expected.relative_mass_error);

  const Ran column = run(directory,
                         "tessellate table.csv --mass-column m --sites 20 --seed 3 --threads 1 -q "
                         "-o column.npy");
  CHECK(column.status == 0);
  CHECK(column.errors == "");
  CHECK(get(directory / "column.npy") == get(directory / "sites.npy"));
}

TEST_CASE("tessellate: the column of masses is no coordinate") {
  const TemporaryDirectory directory;
  put(directory / "sky.csv", "ra,dec,m\n0,0,1\n1,0,2\n0,1,2\n1,1,1\n5,5,3\n5,6,3\n");
  const auto sites = [&](const std::string& arguments) {
    const Ran ran = run(directory, "tessellate " + arguments + " --sites 2 -q -o sites.csv");
    CHECK(ran.errors == "");
    return get(directory / "sites.csv");
  };
  const std::string chosen = sites("sky.csv --columns ra,dec --mass-column m");
  CHECK(sites("sky.csv --mass-column m") == chosen);
  CHECK(sites("sky.csv --mass-column 3") == chosen);
  put(directory / "bare.csv", "0 0 1\n1 0 2\n0 1 2\n1 1 1\n5 5 3\n5 6 3\n");
  CHECK(sites("bare.csv --mass-column 3") == chosen);
  put(directory / "named.csv", "m,x,y,id\n1,0,0,9\n2,1,0,8\n2,0,1,7\n1,1,1,6\n3,5,5,5\n3,5,6,4\n");
  const Ran ran = run(directory, "tessellate named.csv --mass-column m --sites 2 -o sites.csv");
  CHECK(get(directory / "sites.csv") == chosen);
  CHECK(ran.errors.find("left out: id;") != std::string::npos);
  const Ran by_number =
      run(directory, "tessellate named.csv --mass-column 1 --sites 2 -o sites.csv");
  CHECK(get(directory / "sites.csv") == chosen);
  CHECK(by_number.errors == ran.errors);
  CHECK(sites("bare.csv --mass-column 03") == chosen);
}

TEST_CASE("tessellate: a coordinate is no column of masses, by its number either") {
  const TemporaryDirectory directory;
  put(directory / "named.csv", "m,x,y\n1,0,0\n2,1,0\n2,0,1\n1,1,1\n");
  put(directory / "cloud.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float m\nproperty float x\n"
      "property float y\nend_header\n1 0 0\n2 1 0\n2 0 1\n1 1 1\n");
  CHECK(run(directory, "sample --dim 3 --sites 27 --points-per-site 8 --periodic -o load.gadget")
            .status == 0);
  for (const char* const arguments :
       {"named.csv --mass-column 2", "named.csv --mass-column x", "cloud.ply --mass-column 3",
        "cloud.ply --mass-column y", "load.gadget --mass-column 2"}) {
    CAPTURE(arguments);
    const Ran ran =
        run(directory, "tessellate " + std::string(arguments) + " --sites 2 -o sites.csv");
    CHECK(ran.status == 2);
    CHECK(ran.errors.find("is among the coordinates of") != std::string::npos);
  }
  for (const char* const column : {"m", "1"}) {
    CAPTURE(column);
    const std::string line = "tessellate cloud.ply --sites 2 -o sites.csv --mass-column ";
    CHECK(run(directory, line + column).status == 0);
  }
}

TEST_CASE("tessellate: a time limit that comes too soon is no interruption") {
  const TemporaryDirectory directory;
  write_inputs(directory);
  const Ran ran = run(directory,
                      "tessellate points.npy --masses masses.txt --sites 20 --time-limit 1e-9 "
                      "-o sites.npy");
  CHECK(ran.status == 1);
  CHECK(ran.errors == "ccvt: error: the time limit came before there was anything to write\n");
}

TEST_CASE("tessellate: resampled, with capacities in mass") {
  const TemporaryDirectory directory;
  write_inputs(directory);
  double total = 0;
  for (const double mass : read_numbers(directory / "masses.txt")) total += mass;
  std::string capacities;
  for (int s = 0; s < 10; ++s) {
    capacities += std::to_string(total * (s < 5 ? 0.05 : 0.15)) + "\n";
  }
  put(directory / "capacities.txt", capacities);
  const Ran ran = run(directory,
                      "tessellate points.npy --masses masses.txt --mass-method resampled "
                      "--points-per-site 64 --capacities capacities.txt --periodic "
                      "--box 0 0 1 1 -o sites.csv --summary summary.json");
  CHECK(ran.errors == "");
  CHECK(ran.status == 0);
  CHECK(ran.output.find("bound") == std::string::npos);
  const auto json = nlohmann::json::parse(get(directory / "summary.json"));
  CHECK(json["masses"]["method"] == "resampled");
  CHECK(json["masses"]["error_bound"].is_null());
  CHECK(json["masses"]["relative_error"] < 0.1);
}

TEST_CASE("tessellate: shares add up to masses, and what owners alone would miss is told") {
  const TemporaryDirectory directory;
  put(directory / "five.csv", "x,m\n1,2\n2,2\n3,5\n4,6\n5,5\n");
  const Ran ran = run(directory,
                      "tessellate five.csv --mass-column m --sites 4 --mass-method resampled "
                      "--points-per-site 50 -o sites.csv --owners-out owners.csv "
                      "--shares-out shares.csv");
  CHECK(ran.status == 0);
  const Points<double> shares = read_points<double>(directory / "shares.csv");
  const std::vector<double> masses = {2, 2, 5, 6, 5};
  std::vector<double> points(5, 0.0);
  std::vector<double> sites(4, 0.0);
  for (Eigen::Index k = 0; k < shares.cols(); ++k) {
    points.at(static_cast<std::size_t>(shares(0, k))) += shares(2, k);
    sites.at(static_cast<std::size_t>(shares(1, k))) += shares(2, k);
  }
  for (std::size_t p = 0; p < 5; ++p) CHECK(points[p] == doctest::Approx(masses[p]));
  for (const double mass : sites) CHECK(mass == doctest::Approx(5).epsilon(0.05));
  std::vector<double> owned(4, 0.0);
  const std::vector<Index> owners = read_indices(directory / "owners.csv");
  for (std::size_t p = 0; p < 5; ++p) owned.at(static_cast<std::size_t>(owners[p])) += masses[p];
  double largest = 0;
  for (const double mass : owned) largest = std::max(largest, std::abs(mass / 5 - 1));
  CHECK(largest > 0.1);  // or nothing would be told
  CHECK(ran.output.find("miss capacities by up to " + text(100 * largest, 3) + " %\n") !=
        std::string::npos);
}

TEST_CASE("tessellate: what is wrong with masses is said in a line") {
  const TemporaryDirectory directory;
  write_inputs(directory);
  const auto said = [&](const std::string& arguments) {
    const Ran ran = run(directory, "tessellate " + arguments + " -o sites.npy");
    CHECK(ran.status == 2);
    CHECK(!std::filesystem::exists(directory / "sites.npy"));
    return ran.errors;
  };
  CHECK(said("points.npy --mass-method whole --sites 3") ==
        "ccvt: error: --mass-method: needs --masses or --mass-column\n");
  CHECK(said("points.npy --points-per-site 9 --sites 3") ==
        "ccvt: error: --points-per-site: needs --masses or --mass-column\n");
  CHECK(said("points.npy --masses masses.txt --initial-sites points.npy") ==
        "ccvt: error: --initial-sites: is for points without masses; --sites says how many\n");
  CHECK(said("points.npy --masses points.npy --sites 3") ==
        "ccvt: error: points.npy: has 2 numbers a row; there must be one\n");
  CHECK(said("points.npy --columns 2,1 --mass-column 2 --sites 3") ==
        "ccvt: error: --mass-column: '2' is among the coordinates of points.npy; --columns says "
        "which columns these are\n");
  CHECK(said("masses.txt --mass-column 1 --sites 3") ==
        "ccvt: error: --mass-column: masses.txt has no column but '1', and so no coordinates\n");
  CHECK(said("table.csv --mass-column x --sites 3")
            .find("--mass-column: 'x' is among the coordinates") != std::string::npos);
  CHECK(said("table.csv --mass-column w --sites 3").find("'w'") != std::string::npos);
  CHECK(said("points.npy --masses masses.txt --mass-method half --sites 3")
            .find("'half' is not one of whole, resampled") != std::string::npos);
  put(directory / "few.txt", "1\n2\n");
  CHECK(said("points.npy --masses few.txt --sites 3") ==
        "ccvt: error: few.txt: masses: there are 2 for 600 points: there must be one per point\n");
  CHECK(said("points.npy --masses masses.txt --capacities few.txt --sites 3") ==
        "ccvt: error: few.txt: capacities: there are 2 for 3 sites: there must be one per site\n");
  put(directory / "five.csv", "x,m\n1,2\n2,2\n3,5\n4,6\n5,5\n");
  CHECK(said("five.csv --mass-column m --sites 4 --mass-method whole") ==
        "ccvt: error: five.csv: masses[3] is 6, more than the capacity of site 0, 5 (too heavy: 1 "
        "point): whole points must fit, as they do with at most 3 sites; the method resampled "
        "shares heavy points among sites\n");
  CHECK(said("five.csv --mass-column m --sites 2 --shares-out s.csv")
            .find("--shares-out: needs --mass-method resampled") != std::string::npos);
  std::string masses = "-1\n";
  for (int p = 1; p < 600; ++p) masses += "1\n";
  put(directory / "negative.txt", masses);
  CHECK(said("points.npy --masses negative.txt --sites 3").find("negative.txt: masses[0] is -1") !=
        std::string::npos);
}

TEST_CASE("numbers are read from tables of one column and arrays of one extent") {
  const TemporaryDirectory directory;
  put(directory / "a.csv", "mass\n1.5\n2e3\n");
  CHECK(read_numbers(directory / "a.csv") == std::vector<double>{1.5, 2000});
  write_owners(directory / "b.npy", std::vector<Index>{3, 1, 2});
  CHECK(read_numbers(directory / "b.npy") == std::vector<double>{3, 1, 2});
  write_points(directory / "c.npy", Points<float>(Points<float>::Constant(1, 2, 0.5F)));
  CHECK(read_numbers(directory / "c.npy") == std::vector<double>{0.5, 0.5});
  write_points(directory / "d.npy", Points<float>(Points<float>::Constant(2, 2, 0.5F)));
  CHECK(message_of([&] { read_numbers(directory / "d.npy"); }).find("has 2 numbers a row") !=
        std::string::npos);
  put(directory / "e.csv", "1\nx\n");
  // Names of coordinates say nothing here.
  put(directory / "f.csv", "x\n4\n5\n");
  CHECK(read_numbers(directory / "f.csv") == std::vector<double>{4, 5});
  put(directory / "g.csv", "x,mass\n9,1\n9,1000\n");
  CHECK(message_of([&] {
          read_numbers(directory / "g.csv");
        }).ends_with("g.csv: has 2 numbers a row (x, mass); there must be one"));
  CHECK(message_of([&] { read_numbers(directory / "e.csv"); }).find("e.csv") != std::string::npos);
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
