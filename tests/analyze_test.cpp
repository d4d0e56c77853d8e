// Runs `ccvt analyze` itself.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/metrics.h"
#include "support/files.h"
#include "support/lattices.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

nlohmann::json json_of(const fs::path& path) { return nlohmann::json::parse(get(path)); }

}  // namespace

TEST_SUITE_BEGIN("analyze");

TEST_CASE("analyze: files, figures and tables are those of the library") {
  const TemporaryDirectory directory;
  const std::vector<PointSet> runs = {darts(2, 150, 0.05, 1), darts(2, 150, 0.05, 2)};
  const PointSet other = white(2, 90, 1);
  write_points(directory / "a.npy", runs[0].points());
  write_points(directory / "b.csv", runs[1].points());
  write_points(directory / "w.txt", other.points());
  const Ran ran =
      run(directory, "analyze a.npy b.csv --periodic --compare white=w.txt -o out --threads 2");
  CHECK(ran.errors == "");
  CHECK(ran.status == 0);
  CHECK(ran.output.find("low-frequency power") != std::string::npos);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory / "out")) {
    names.push_back(entry.path().filename().string());
    CHECK(entry.file_size() > 100);
  }
  std::sort(names.begin(), names.end());
  CHECK(names ==
        std::vector<std::string>{"anisotropy.svg", "low_frequency.csv", "low_frequency_2.csv",
                                 "metrics.json", "pair_correlation.svg", "points.svg",
                                 "points_2.svg", "power_law.svg", "radial.csv", "radial.svg",
                                 "radial_2.csv", "report.html", "spectrum.png", "spectrum_2.png"});
  const Analysis expected = analyze(runs);
  const auto json = json_of(directory / "out/metrics.json");
  CHECK(json["points"] == 150);
  CHECK(json["dimension"] == 2);
  CHECK(json["runs"] == 2);
  CHECK(json["periodic"] == true);
  CHECK(json["min_distance"] == expected.distances.smallest);
  CHECK(json["mean_distance"] == expected.distances.mean);
  CHECK(json["low_frequency_power"] == expected.spectrum.low_frequency_power);
  CHECK(json["low_frequency_slope"] == expected.spectrum.low_frequency_slope);
  CHECK(json["low_frequency_slope_error"] == expected.spectrum.low_frequency_slope_error);
  const auto& shells = expected.spectrum.low_shells;
  REQUIRE(json["low_frequency_shells"]["power"].size() == shells.size());
  CHECK(json["low_frequency_shells"]["power"][1] == shells[1].power);
  const auto low = read_points<double>(directory / "out/low_frequency.csv");
  REQUIRE(low.cols() == static_cast<Eigen::Index>(shells.size()));
  CHECK(low(0, 1) == shells[1].frequency);
  CHECK(low(3, 1) ==
        doctest::Approx(expected.spectrum.low_frequency_scale *
                        std::pow(shells[1].frequency, expected.spectrum.low_frequency_slope)));
  CHECK(json["spectral_peak"] == expected.spectrum.peak);
  CHECK(json["effective_nyquist"] == expected.spectrum.effective_nyquist);
  CHECK(json["oscillation"] == expected.spectrum.oscillation);
  CHECK(json["psi6_local"] == expected.order.psi6_local);
  CHECK(json["psi6_global"] == expected.order.psi6_global);
  CHECK(json["six_sided"] == expected.order.six_sided);
  CHECK(json["star_discrepancy"] == expected.star_discrepancy);
  CHECK(json["variance_step"] == expected.integration.step);
  REQUIRE(json["radial"]["power"].size() == expected.spectrum.rings.size());
  for (std::size_t r = 0; r < expected.spectrum.rings.size(); ++r) {
    CHECK(json["radial"]["frequency"][r] == expected.spectrum.rings[r].middle());
    CHECK(json["radial"]["power"][r] == expected.spectrum.rings[r].power);
    CHECK(json["radial"]["anisotropy_db"][r] == expected.spectrum.rings[r].anisotropy_db);
  }
  CHECK(json["pair_correlation"]["value"] == expected.pairs.value);
  CHECK(json["compare"]["white"]["points"] == 90);
  CHECK(json["compare"]["white"]["min_distance"] == nearest_distances(other).smallest);
  const auto radial = read_points<double>(directory / "out/radial.csv");
  CHECK(radial.rows() == 3);
  CHECK(radial.cols() == static_cast<Eigen::Index>(expected.spectrum.rings.size()));
  const Image image = read_image(directory / "out/spectrum.png");
  CHECK(image(image.width / 2, image.height / 2) == 0);  // frequency 0 is left out
  const std::string page = get(directory / "out/report.html");
  CHECK(page.find("data:image/png;base64,") != std::string::npos);
  CHECK(page.find("http://www.w3.org/2000/svg") != std::string::npos);
  CHECK(page.find("https:") == std::string::npos);

  // The same bytes for another number of threads, over files that are there.
  const std::string before = get(directory / "out/report.html");
  CHECK(run(directory, "analyze a.npy b.csv --periodic --compare white=w.txt -o out --threads 1 -q")
            .output == "");
  CHECK(get(directory / "out/report.html") == before);
}

TEST_CASE("analyze: figures that do not exist are left out") {
  const TemporaryDirectory directory;
  Points<double> points(2, 2);
  points << 0.5, 0.25, 0.5, 0.75;
  write_points(directory / "p.npy", points);
  const auto told = run(directory, "analyze p.npy --periodic --max-frequency 0.75 -o out");
  CHECK(told.status == 0);
  CHECK(told.output.find("low-frequency power     n/a\n") != std::string::npos);
  CHECK(told.output.find("\nn/a: the points have nothing") != std::string::npos);
  CHECK(get(directory / "out/radial.csv").find(",1,\n") != std::string::npos);
  const auto json = json_of(directory / "out/metrics.json");
  CHECK(json["low_frequency_power"].is_null());
  CHECK(json["radial"]["anisotropy_db"][0].is_null());
  for (const auto& entry : fs::directory_iterator(directory / "out")) {
    if (entry.path().extension() == ".png") continue;
    CAPTURE(entry.path().string());
    const std::string content = get(entry.path());
    for (const char* const word : {">nan<", ">inf<", ">-inf<", ",nan", ",-nan", ",inf", ",-inf"}) {
      CHECK(content.find(word) == std::string::npos);
    }
  }
}

TEST_CASE("analyze: any dimension, any box") {
  const TemporaryDirectory directory;
  for (const int dimension : {1, 2, 3, 4, 9}) {
    CAPTURE(dimension);
    const PointSet set = white(dimension, 60, 1);
    const Points<double> scaled = (set.points().array() * 6 - 3).matrix();
    write_points(directory / "p.npy", scaled);
    std::string box = " --box";
    for (int d = 0; d < 2 * dimension; ++d) box += d < dimension ? " -3" : " 3";
    const Ran ran = run(directory, "analyze p.npy -q -o out" + box);
    CHECK(ran.errors == "");
    CHECK(ran.status == 0);
    const auto json = json_of(directory / "out/metrics.json");
    CHECK(json["dimension"] == dimension);
    CHECK(json.contains("psi6_local") == (dimension == 2));
    CHECK(json["mean_distance"] ==
          doctest::Approx(
              nearest_distances(PointSet(set.points(), Domain::euclidean(Box::unit(dimension))))
                  .mean));
    CHECK(read_image(directory / "out/spectrum.png").width > 0);
    CHECK(get(directory / "out/points.svg").find("<circle") != std::string::npos);
    fs::remove_all(directory / "out");
  }
  // The first of the compared sets stands in for POINTS.
  write_points(directory / "p.npy", white(2, 60, 1).points());
  CHECK(run(directory, "analyze -q -o out --max-frequency 1 --compare a=p.npy b=p.npy").status ==
        0);
  const auto json = json_of(directory / "out/metrics.json");
  CHECK(json["name"] == "a");
  CHECK(json["compare"].size() == 1);
  CHECK(json["radial"]["frequency"].back() < 1);
}

TEST_CASE("analyze: of many points a window is drawn where they are") {
  const TemporaryDirectory directory;
  const auto circles = [&](const Points<double>& points) {
    write_points(directory / "p.npy", points);
    REQUIRE(run(directory, "analyze p.npy -q --max-frequency 0.05 -o out").status == 0);
    const std::string picture = get(directory / "out/points.svg");
    CHECK(picture.find("% as wide as the box") != std::string::npos);
    std::size_t count = 0;
    for (auto at = picture.find("<circle"); at != std::string::npos;
         at = picture.find("<circle", at + 1)) {
      ++count;
    }
    fs::remove_all(directory / "out");
    return count;
  };
  // In the upper corner.
  const Points<double> points = sample_uniform<double>(Box::unit(2), 30'000);
  CHECK(circles((0.8 + 0.2 * points.array()).matrix()) > 5000);
}

TEST_CASE("analyze: bad input: one line, status 2, nothing written") {
  const TemporaryDirectory directory;
  write_points(directory / "p.csv", white(2, 9, 1).points());
  write_points(directory / "ten.csv", white(2, 10, 1).points());
  write_points(directory / "solid.csv", white(3, 9, 1).points());
  write_points(directory / "radial.csv", white(2, 9, 1).points());
  put(directory / "one.csv", "0.5 0.5\n");
  put(directory / "equal.csv", "0.5 0.5\n0.5 0.5\n");
  put(directory / "out.csv", "0.5 0.5\n0.5 1.5\n");
  put(directory / "nan.csv", "0.5 0.5\n0.5 nan\n");
  put(directory / "empty.csv", "");
  struct Case {
    std::string line;
    std::vector<std::string> expected;
  };
  const Case cases[] = {
      {"analyze -o dir", {"POINTS", "--compare"}},
      {"analyze p.csv", {"--output"}},
      {"analyze p.csv -o p.csv", {"p.csv", "no directory"}},
      {"analyze radial.csv -o .", {"radial.csv", "written over", "another directory"}},
      {"analyze p.csv -o none/dir", {"none/dir", "cannot be written", "No such file"}},
      {"analyze p.csv -o /proc/dir", {"/proc/dir", "cannot be written"}},
      {"analyze none.csv -o dir", {"none.csv", "no such file"}},
      {"analyze empty.csv -o dir", {"empty.csv", "is empty"}},
      {"analyze one.csv -o dir", {"one.csv", "is one", "at least two"}},
      {"analyze equal.csv -o dir", {"equal.csv", "all 2 of them are equal"}},
      {"analyze nan.csv -o dir", {"nan.csv", "line 2", "finite"}},
      {"analyze out.csv -o dir", {"out.csv", "coordinate 1 of point 1 is 1.5", "--box"}},
      {"analyze out.csv --box 0 0 1 1 -o dir", {"out.csv", "point 1 is 1.5", "outside the box"}},
      {"analyze p.csv --box 0 0 1 -o dir", {"--box", "3 numbers", "4 are needed"}},
      {"analyze p.csv ten.csv -o dir", {"ten.csv", "10 points", "p.csv", "9"}},
      {"analyze p.csv solid.csv -o dir", {"solid.csv", "3 coordinates", "p.csv"}},
      {"analyze p.csv --compare s=solid.csv -o dir", {"solid.csv", "3 coordinates"}},
      {"analyze p.csv --compare ten.csv -o dir", {"--compare", "'ten.csv'", "NAME=FILE"}},
      {"analyze p.csv --compare =ten.csv -o dir", {"--compare", "NAME=FILE"}},
      {"analyze p.csv --compare a=p.csv a=p.csv -o dir", {"two sets named 'a'"}},
      {"analyze p.csv --max-frequency 0 -o dir", {"--max-frequency", "above 0"}},
      {"analyze p.csv --threads x -o dir", {"--threads", "'x'"}},
  };
  const std::size_t before = directory.entries();
  for (const Case& c : cases) {
    const Ran ran = run(directory, c.line);
    CAPTURE(c.line);
    CAPTURE(ran.errors);
    CHECK(ran.status == 2);
    CHECK(ran.output == "");
    CHECK(ran.errors.rfind("ccvt: error: ", 0) == 0);
    CHECK(ran.errors.find('\n') == ran.errors.size() - 1);
    for (const auto& part : c.expected) {
      CAPTURE(part);
      CHECK(ran.errors.find(part) != std::string::npos);
    }
    CHECK(directory.entries() == before);
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
