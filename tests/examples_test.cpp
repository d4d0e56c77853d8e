// The programs in examples/, run as a newcomer would run them, and what they print and write.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <regex>
#include <string>
#include <vector>

#include "ccvt/ccvt.h"
#include "support/files.h"
#include "support/gif.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

const fs::path sources = CCVT_SOURCES;

/// What an example prints that ends well, and says nothing of errors.
std::string printed(const std::string& name, const TemporaryDirectory& directory,
                    const std::vector<std::string>& arguments = {}) {
  Process process(fs::path(CCVT_EXAMPLES) / name, arguments, directory.path());
  const int status = process.wait();
  CHECK(process.errors().empty());
  REQUIRE_MESSAGE(status == 0, name, ": ", process.errors());
  return process.output();
}

/// The number in `text` that `pattern` has in brackets, the first time.
double number_in(const std::string& text, const std::string& pattern) {
  std::smatch match;
  REQUIRE_MESSAGE(std::regex_search(text, match, std::regex(pattern)), pattern, " in:\n", text);
  return std::stod(match[1]);
}

/// All of them.
std::vector<double> numbers_in(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<double> numbers;
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) {
    numbers.push_back(std::stod((*at)[1]));
  }
  return numbers;
}

double share_of_black(const std::vector<std::uint8_t>& greys) {
  double sum = 0;
  for (const std::uint8_t grey : greys) sum += 1 - grey / 255.0;
  return sum / static_cast<double>(greys.size());
}

/// Of a frame, how much of its ink is in the middle ninth.
double share_in_the_middle(const std::vector<std::uint8_t>& greys, int size) {
  double all = 0, middle = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double ink = 255 - greys[static_cast<std::size_t>(y * size + x)];
      all += ink;
      if (std::max(std::abs(x - size / 2), std::abs(y - size / 2)) < size / 6) middle += ink;
    }
  }
  return middle / all;
}

/// The columns of a binary PLY that are no coordinates have no reader in the library but this.
std::vector<double> weights_of(const fs::path& path) {
  const PointCloud cloud = read_point_cloud(path);
  REQUIRE(std::find(cloud.kept.begin(), cloud.kept.end(), "weight") != cloud.kept.end());
  const auto column = read_points<double>(path, {.columns = {"weight"}});
  return {column.data(), column.data() + column.size()};
}

TEST_SUITE_BEGIN("examples");

TEST_CASE("start is what README shows, and runs") {
  const std::string readme = get(sources / "README.md");
  const std::string open = "```cpp\n";
  const auto from = readme.find(open) + open.size();
  const std::string shown = readme.substr(from, readme.find("```", from) - from);
  const std::string start = get(sources / "tests/examples/start.cpp");
  REQUIRE(shown.size() > 200);
  // The guide has both of README's blocks.
  const std::string guide = get(sources / "src/docs/cplusplus.md");
  CHECK(guide.find(open + shown + "```") != std::string::npos);
  const auto second = readme.find(open, from) + open.size();
  const std::string steps = readme.substr(second, readme.find("```", second) - second);
  REQUIRE(steps.find("solver.step()") != std::string::npos);
  CHECK(guide.find(open + steps + "```") != std::string::npos);
  CHECK(start.substr(start.find("#include")) == shown);

  const TemporaryDirectory directory;
  const std::string text = printed("start", directory);
  CHECK(text.starts_with("stable after "));
  CHECK(number_in(text, "normalized energy ([0-9.]+)") < 0.26);
  CHECK(numbers_in(text.substr(text.find("first site:")), "(0?\\.[0-9]+)").size() == 3);
}

TEST_CASE("relax_gif: sites spread from the middle, frame by frame") {
  const TemporaryDirectory directory;
  const std::string text = printed("relax_gif", directory, {"relax.gif"});
  const std::string bytes = get(directory / "relax.gif");
  const Gif gif = GifReader(bytes).read();
  CHECK(gif.width == 320);
  CHECK(gif.height == 320);
  REQUIRE(gif.frames.size() >= 10);
  CHECK(static_cast<double>(gif.frames.size()) == number_in(text, "^([0-9]+) frames"));
  CHECK(share_in_the_middle(gif.frames.front(), 320) > 0.99);
  CHECK(share_in_the_middle(gif.frames.back(), 320) == doctest::Approx(1 / 9.0).epsilon(0.1));
  // 500 dots of radius 3 that do not cover each other, but a little off the border.
  CHECK(share_of_black(gif.frames.back()) ==
        doctest::Approx(500 * std::numbers::pi * 9 / (320 * 320)).epsilon(0.02));
  for (std::size_t f = 1; f < 5; ++f) CHECK(gif.frames[f] != gif.frames[f - 1]);
}

TEST_CASE("density_function: as many sites in each ring as the function says") {
  const TemporaryDirectory directory;
  printed("density_function", directory, {"made"});
  const auto sites = read_points<double>(directory / "made/sites.csv");
  REQUIRE(sites.rows() == 2);
  REQUIRE(sites.cols() == 3000);
  CHECK(sites.cwiseAbs().maxCoeff() < 4);

  // The masses of the rings 0 to 0.8, to 2.4, to 4, by the midpoint rule on the box.
  const auto ring_of = [](double r) { return r < 0.8 ? 0 : r < 2.4 ? 1 : r < 4 ? 2 : 3; };
  std::vector<double> mass(4), found(4);
  double all = 0;
  for (double x = -3.995; x < 4; x += 0.01) {
    for (double y = -3.995; y < 4; y += 0.01) {
      const double r = std::hypot(x, y);
      const double density = std::exp(-r / 2) * (1 + std::cos(4 * r)) / 2;
      mass[static_cast<std::size_t>(ring_of(r))] += density;
      all += density;
    }
  }
  for (const auto& site : sites.colwise()) ++found[static_cast<std::size_t>(ring_of(site.norm()))];
  for (std::size_t ring = 0; ring < 4; ++ring) {
    CHECK(found[ring] == doctest::Approx(3000 * mass[ring] / all).epsilon(0.05));
  }
  const Image picture = read_image(directory / "made/sites.png");
  CHECK(picture.width == 800);
  CHECK(picture.height == 800);
  CHECK(*std::min_element(picture.values.begin(), picture.values.end()) < 0.1F);
}

TEST_CASE("volume: samples in the shell that carry its mass") {
  const TemporaryDirectory directory;
  const std::string text = printed("volume", directory, {"shell.ply"});
  const auto sites = read_points<double>(directory / "shell.ply");
  REQUIRE(sites.rows() == 3);
  REQUIRE(sites.cols() == 5000);
  const auto radii = sites.colwise().norm().eval();
  CHECK(radii.minCoeff() > 30 - 4);  // within a cell
  CHECK(radii.maxCoeff() < 50 + 4);

  // The shell's mass is 4 pi times the integral of r^2 (1 - |r - 40| / 10).
  const double mass = 4 * std::numbers::pi * (1600 * 10 + 1000 / 6.0);
  double sum = 0;
  for (const double weight : weights_of(directory / "shell.ply")) sum += weight;
  CHECK(sum == doctest::Approx(mass).epsilon(0.01));
  CHECK(number_in(text, "mass ([0-9.e+]+)") == doctest::Approx(sum).epsilon(1e-4));
  CHECK(number_in(text, "radius ([0-9.]+)") == doctest::Approx(41.0).epsilon(0.01));
}

TEST_CASE("volume: a file in the place of the shell") {
  const TemporaryDirectory directory;
  Points<double> plane(4, 8);  // as an array, 8 by 4; a volume has three dimensions
  plane.setOnes();
  write_points(directory / "plane.npy", plane);
  Process refused(fs::path(CCVT_EXAMPLES) / "volume", {"s.ply", "plane.npy"}, directory.path());
  CHECK(refused.wait() == 1);
  CHECK(refused.errors().find("plane.npy") != std::string::npos);
  CHECK_FALSE(fs::exists(directory / "s.ply"));

  put(directory / "cube.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nspacings: 2 2 2\n\n" +
          std::string(64, '\1'));
  printed("volume", directory, {"s.ply", "cube.nrrd"});
  double sum = 0;
  for (const double weight : weights_of(directory / "s.ply")) sum += weight;
  CHECK(sum == doctest::Approx(8 * 64).epsilon(1e-5));
}

TEST_CASE("codebook_search: equal lists, and most neighbours found in few of them") {
  const TemporaryDirectory directory;
  const std::string text = printed("codebook_search", directory);
  CHECK(number_in(text, "longest list ([0-9]+)") == 313);
  CHECK(number_in(text, "shortest ([0-9]+)") == 312);
  CHECK(number_in(text, "scanned ([0-9]+)") <= 4 * 313);
  const double recall = number_in(text, "recall ([0-9.]+)");
  CHECK(recall > 0.9);
  CHECK(recall <= 1);
}

TEST_CASE("warm_start: fewer iterations, each step") {
  const TemporaryDirectory directory;
  const std::string text = printed("warm_start", directory);
  const auto warm = numbers_in(text, ": ([0-9]+) iterations");
  const auto cold = numbers_in(text, "cold ([0-9]+)");
  REQUIRE(warm.size() == 5);
  REQUIRE(cold.size() == 5);
  for (std::size_t step = 0; step < 5; ++step) CHECK(2 * warm[step] < cold[step]);
}

TEST_CASE("cancel: stopped before the end, with cells as large as they should be") {
  const TemporaryDirectory directory;
  const std::string text = printed("cancel", directory);
  const auto progress = numbers_in(text, "progress ([0-9.]+)");
  REQUIRE_FALSE(progress.empty());
  CHECK(std::is_sorted(progress.begin(), progress.end()));
  CHECK(progress.back() < 1);
  CHECK(text.find("ended: cancelled; every site owns 1000 to 1000 points\n") != std::string::npos);
}

TEST_CASE("own_types: what rises evenly is, in the mean of a cell, what it is at the site") {
  const TemporaryDirectory directory;
  const std::string text = printed("own_types", directory);
  const auto site = numbers_in(text.substr(0, text.find(',')), " (0?\\.[0-9]+)");
  REQUIRE(site.size() == 3);
  CHECK(number_in(text, "temperature ([0-9.]+)") ==
        doctest::Approx(300 + 10 * site[2]).epsilon(1e-5));
  CHECK(text.find("100 sites of type double: stable after") != std::string::npos);
}

TEST_CASE("thin_cloud: so many of the cloud's own points") {
  const TemporaryDirectory directory;
  const auto cloud = sample_uniform<float, 2>(Box::unit(2), 5000, 3);
  std::ofstream(directory / "cloud.csv") << "x,y,name\n";
  {
    std::ofstream file(directory / "cloud.csv", std::ios::app);
    file.precision(9);
    for (Index p = 0; p < 5000; ++p) file << cloud(0, p) << "," << cloud(1, p) << ",p" << p << "\n";
  }
  const std::string text = printed("thin_cloud", directory, {"cloud.csv", "200", "thin.csv"});
  CHECK(text.starts_with("200 of 5000 points"));
  const auto chosen = read_points<float>(directory / "thin.csv");
  REQUIRE(chosen.cols() == 200);
  for (const auto& point : chosen.colwise()) {
    CHECK((cloud.colwise() - point).colwise().squaredNorm().minCoeff() == 0);
  }
  const PointSet set(chosen, Domain::euclidean(Box::unit(2)));
  CHECK(nearest_distances(set).smallest > 0.5);
  const auto counts = read_points<double>(directory / "thin.csv", {.columns = {"count"}});
  CHECK(counts.sum() == 5000);

  Process refused(fs::path(CCVT_EXAMPLES) / "thin_cloud", {"cloud.csv", "0", "none.csv"},
                  directory.path());
  CHECK(refused.wait() == 1);
  CHECK(refused.errors().find("sites") != std::string::npos);
  CHECK_FALSE(fs::exists(directory / "none.csv"));
}

TEST_CASE("particle_load: eight tiles in a periodic box, evenly spread") {
  const TemporaryDirectory directory;
  const std::string text = printed("particle_load", directory, {"load.gadget"});
  const auto particles = read_points<double>(directory / "load.gadget");
  REQUIRE(particles.cols() == 8 * 1728);
  CHECK(inspect_points(directory / "load.gadget").box == std::vector<double>(3, 100));
  const PointSet set(particles, Domain::periodic({{0, 0, 0}, {100, 100, 100}}));
  const double smallest = nearest_distances(set).smallest;
  CHECK(smallest > 0.6);
  CHECK(number_in(text, "neighbours are ([0-9.]+)") == doctest::Approx(smallest).epsilon(1e-4));
  CHECK(number_in(text, "mass ([0-9.]+)") == doctest::Approx(8.6e6 / (8 * 1728)));
}

TEST_CASE("stipple: dots whose ink is the photograph's") {
  const TemporaryDirectory directory;
  const std::string photo = CCVT_TEST_DATA "/camera.png";
  printed("stipple", directory, {photo, "3000", "made"});
  const std::string svg = get(directory / "made/dots.svg");
  CHECK(numbers_in(svg, "<circle cx=\"([0-9.]+)\"").size() == 3000);
  const auto ink = [](const Image& image) {
    double sum = 0;
    for (const float value : image.values) sum += 1 - static_cast<double>(value);
    return sum / static_cast<double>(image.values.size());
  };
  CHECK(ink(read_image(directory / "made/dots.png")) ==
        doctest::Approx(ink(read_image(photo))).epsilon(0.02));

  Process refused(fs::path(CCVT_EXAMPLES) / "stipple", {"nothing.png", "10", "made"},
                  directory.path());
  CHECK(refused.wait() == 1);
  CHECK(refused.errors().find("nothing.png") != std::string::npos);
}

TEST_CASE("every example is built and listed, short, and says what it does and how to run it") {
  const std::string list = get(sources / "tests/examples/README.md");
  int programs = 0;
  for (const auto& entry : fs::directory_iterator(sources / "tests/examples")) {
    const fs::path& path = entry.path();
    const std::string text = get(path);
    const bool cpp = path.extension() == ".cpp";
    if (!cpp && path.extension() != ".py") continue;
    CAPTURE(path.filename().string());
    CHECK(list.find("(" + path.filename().string() + ")") != std::string::npos);
    CHECK(std::count(text.begin(), text.end(), '\n') <= 70);
    if (!cpp) continue;
    ++programs;
    CHECK(text.starts_with("// "));
    CHECK(text.find("g++ -std=c++20 -O2 " + path.filename().string()) != std::string::npos);
    CHECK(fs::exists(fs::path(CCVT_EXAMPLES) / path.stem()));
  }
  CHECK(programs >= 11);
}

TEST_SUITE_END();

}  // namespace
}  // namespace ccvt::test
