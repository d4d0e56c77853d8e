#include "ccvt/stipple.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "random.h"
#include "support/files.h"
#include "support/message.h"
#include "support/processor_time.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

Image constant_image(int width, int height, float value) {
  return {width, height,
          std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                             value)};
}

/// Dark on the right, with a black disc at the left.
Image test_picture() {
  Image image = constant_image(96, 64, 1);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double dark = std::hypot(x - 20, y - 40) < 12 ? 1 : x / 120.0;
      image.values[static_cast<std::size_t>(y * image.width + x)] = static_cast<float>(1 - dark);
    }
  }
  return image;
}

double ink_of(const Image& image) {
  const auto dark = darkness(image);
  return std::accumulate(dark.begin(), dark.end(), 0.0);
}

/// The covered area inside the picture, by counting places of a grid of its own.
template <class Scalar>
double union_area(const ccvt::Columns<Scalar>& dots, double radius, int width, int height) {
  const int fine = 7;
  std::int64_t covered = 0;
  for (int row = 0; row < height * fine; ++row) {
    for (int column = 0; column < width * fine; ++column) {
      const double x = (column + 0.5) / fine;
      const double y = (row + 0.5) / fine;
      for (Eigen::Index dot = 0; dot < dots.cols(); ++dot) {
        const double dx = static_cast<double>(dots(0, dot)) - x;
        const double dy = static_cast<double>(dots(1, dot)) - y;
        if (dx * dx + dy * dy <= radius * radius) {
          ++covered;
          break;
        }
      }
    }
  }
  return static_cast<double>(covered) / (fine * fine);
}

/// Dots anywhere in a square.
Points<double> scattered(Index count, double side) {
  ccvt::Random random(5, 1);
  Points<double> dots(2, count);
  for (double& x : dots.reshaped()) x = side * random.uniform();
  return dots;
}

}  // namespace

TEST_SUITE_BEGIN("stipple");

TEST_CASE_TEMPLATE("no dot lies on blank paper", Scalar, float, double) {
  // Two black squares, far apart: with an odd number of dots, one has points of both.
  Image image = constant_image(300, 100, 1);
  const auto value = [&](double x, double y) -> float& {
    return image.values[static_cast<std::size_t>(std::floor(y) * image.width + std::floor(x))];
  };
  for (int y = 30; y < 70; ++y) {
    for (int x = 10; x < 50; ++x) value(x, y) = value(x + 240, y) = 0;
  }
  for (const Index sites : {3, 5, 101}) {
    CAPTURE(sites);
    const auto stippling = stipple<Scalar>(image, sites);
    CHECK(stippling.put_back == 1);
    CHECK(stippling.farthest_put_back > 90);
    CHECK(stippling.farthest_put_back < 130);
    for (Index dot = 0; dot < sites; ++dot) {
      CHECK(value(double{stippling.dots(0, dot)}, double{stippling.dots(1, dot)}) == 0);
    }
  }
  const auto dark = stipple<Scalar>(test_picture(), 100);
  CHECK(dark.put_back == 0);
  CHECK(dark.farthest_put_back == 0);
}

TEST_CASE("a written picture comes back to 8 bits") {
  const TemporaryDirectory directory;
  const Image image = test_picture();
  write_png(directory / "p.png", image);
  const Image read = read_image(directory / "p.png");
  REQUIRE(read.width == 96);
  REQUIRE(read.height == 64);
  REQUIRE(read.values.size() == image.values.size());
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    CHECK(std::abs(read.values[i] - image.values[i]) <= 0.5F / 255 + 1e-6F);
  }
  write_png(directory / "again.png", read);
  CHECK(get(directory / "again.png") == get(directory / "p.png"));
  Image wild = constant_image(3, 1, 2);
  wild.values[1] = -1;
  wild.values[2] = std::numeric_limits<float>::quiet_NaN();
  write_png(directory / "wild.png", wild);
  CHECK(read_image(directory / "wild.png").values == std::vector<float>{1, 0, 0});
}

TEST_CASE("darkness") {
  Image image = constant_image(2, 1, 1);
  image.values[0] = 0.25F;
  CHECK(darkness(image) == std::vector<float>{0.75F, 0});
  CHECK(darkness(image, true) == std::vector<float>{0.25F, 1});
  CHECK(darkness(image, false, 2) == std::vector<float>{0.5625F, 0});
  CHECK_THROWS_AS(darkness(image, false, 0), InvalidInput);
  CHECK_THROWS_AS(darkness(image, false, NAN), InvalidInput);
  image.values[1] = 1.5F;
  CHECK_THROWS_AS(darkness(image), InvalidInput);
  image.values.pop_back();
  CHECK_THROWS_AS(darkness(image), InvalidInput);
}

TEST_CASE_TEMPLATE("stipple: dots follow the darkness", Scalar, float, double) {
  const Image image = test_picture();
  const Index sites = 600;
  const auto result = stipple<Scalar>(image, sites, {.points_per_site = 64});
  REQUIRE(result.dots.rows() == 2);
  REQUIRE(result.dots.cols() == sites);
  CHECK(result.width == 96);
  CHECK(result.height == 64);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(result.summary.points == sites * 64);
  CHECK((result.dots.eigen().array() >= 0).all());
  CHECK((result.dots.eigen().row(0).array() <= 96).all());
  CHECK((result.dots.eigen().row(1).array() <= 64).all());

  // Dots have equal shares of the ink, so every region has as many as its ink asks for. Cells
  // on its border may go either way: some four for each cell of its diameter.
  const auto dark = darkness(image);
  const double ink = ink_of(image);
  const auto share = [&](auto&& inside) {
    double inked = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (inside(x + 0.5, y + 0.5))
          inked += static_cast<double>(dark[static_cast<std::size_t>(y * 96 + x)]);
      }
    }
    Index dots = 0;
    for (Eigen::Index dot = 0; dot < sites; ++dot) {
      dots +=
          inside(static_cast<double>(result.dots(0, dot)), static_cast<double>(result.dots(1, dot)))
              ? 1
              : 0;
    }
    CHECK(std::abs(dots - sites * inked / ink) < 20);
  };
  share([](double x, double) { return x < 48; });
  share([](double, double y) { return y < 32; });
  share([](double x, double y) { return std::hypot(x - 20.5, y - 40.5) < 12; });

  // By default the dots cover as much as is dark.
  CHECK(union_area(result.dots, result.dot_radius, 96, 64) == doctest::Approx(ink).epsilon(0.01));
  const auto given = stipple<Scalar>(image, sites, {.points_per_site = 64, .dot_radius = 0.5});
  CHECK(given.dot_radius == 0.5);
  CHECK(given.dots == result.dots);
}

TEST_CASE("stipple: inverting the picture or the option is the same") {
  const Image image = test_picture();
  Image negative = image;
  // In eighths, so that 1 - (1 - v) is v.
  for (float& value : negative.values) value = std::round(value * 8) / 8;
  Image positive = negative;
  for (float& value : positive.values) value = 1 - value;
  const auto a = stipple(negative, 100, {.points_per_site = 16, .invert = true});
  const auto b = stipple(positive, 100, {.points_per_site = 16});
  CHECK(a.dots == b.dots);
  CHECK(a.dot_radius == b.dot_radius);
}

TEST_CASE("stipple refuses what cannot be done") {
  const Image image = test_picture();
  CHECK_THROWS_AS(stipple(constant_image(9, 9, 1), 10), InvalidInput);
  CHECK_THROWS_AS(stipple(constant_image(9, 9, 0), 10, {.invert = true}), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 0), InvalidInput);
  CHECK_THROWS_AS(stipple(image, -1), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 2000000000), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 10, {.points_per_site = 0}), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 10, {.gamma = 0}), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 10, {.gamma = std::nan("")}), InvalidInput);
  CHECK_THROWS_AS(stipple(image, 10, {.dot_radius = -1}), InvalidInput);
  CHECK(test::message_of([&] { stipple(image, 10, {.gamma = -1e-9}); }) ==
        "gamma: is -1e-09; must be positive and finite");
  CHECK_THROWS_AS(stipple(image, 10, {.tessellation = {.max_iterations = -1}}), InvalidInput);
  Image wrong = image;
  wrong.values.pop_back();
  CHECK_THROWS_AS(stipple(wrong, 10), InvalidInput);
  CHECK_THROWS_AS(stipple(Image{}, 10), InvalidInput);
  wrong = image;
  wrong.values[7] = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(stipple(wrong, 10), InvalidInput);
}

TEST_CASE("drawings of what is no stippling are refused") {
  const TemporaryDirectory directory;
  const auto refuse = [&](ccvt::Stippling<double> stippling, const std::string& message) {
    CHECK(message_of([&] { ccvt::render(stippling, 1); }) == message);
    CHECK(message_of([&] { ccvt::write_svg(directory / "a.svg", stippling); }) == message);
    CHECK_FALSE(fs::exists(directory / "a.svg"));
  };
  ccvt::Stippling<double> good;
  good.width = good.height = 4;
  good.dots = ccvt::Points<double>::Constant(2, 3, 1.5);
  good.dot_radius = 1;
  CHECK_NOTHROW(ccvt::render(good, 1));
  ccvt::Stippling<double> bad = good;
  bad.height = 0;
  refuse(bad, "stippling: is 4 x 0 pixels; needs at least one");
  bad = good;
  bad.dot_radius = -1;
  refuse(bad, "stippling: dot_radius is -1: it must be finite and not negative");
  bad = good;
  bad.dots = ccvt::Points<double>::Constant(1, 3, 1.5);
  refuse(bad, "stippling: dots have 1 coordinates: they must have 2");
  bad = good;
  bad.dots = ccvt::Points<double>::Constant(2, 3, std::nan(""));
  refuse(bad, "stippling: dot 0 is not finite");
}

TEST_CASE("dot radius: single dots and overlaps") {
  Points<double> one(2, 1);
  one << 50, 40;
  CHECK(dot_radius_for(one, 100, 80, 100) ==
        doctest::Approx(std::sqrt(100 / std::numbers::pi)).epsilon(0.01));
  // All of the picture: to the farthest corner.
  CHECK(dot_radius_for(one, 100, 80, 8000) == doctest::Approx(std::hypot(50, 40)).epsilon(0.01));
  // A dot in a corner has a quarter of its disc inside.
  one << 0, 0;
  CHECK(dot_radius_for(one, 100, 80, 100) ==
        doctest::Approx(std::sqrt(400 / std::numbers::pi)).epsilon(0.01));
  // Dots on one another count once.
  const Points<double> many = Eigen::Vector2d(50, 40).replicate(1, 9);
  CHECK(dot_radius_for(many, 100, 80, 100) ==
        doctest::Approx(std::sqrt(100 / std::numbers::pi)).epsilon(0.01));
  const Points<double> random = scattered(60, 80);
  // Dots that small lie apart.
  CHECK(60 * std::numbers::pi * std::pow(dot_radius_for(random, 80, 80, 10), 2) ==
        doctest::Approx(10).epsilon(0.01));
  for (const double ink : {500.0, 3000.0, 5500.0, 6400.0}) {
    const double radius = dot_radius_for(random, 80, 80, ink);
    CAPTURE(ink);
    CHECK(union_area(ccvt::Columns<double>(random), radius, 80, 80) ==
          doctest::Approx(ink).epsilon(0.015));
  }
  // Dots on both sides of the picture, too far to cover anything.
  for (const double far : {500.0, 1e21}) {
    Points<double> outside(2, 2);
    outside << -far, far, 5, 5;
    CHECK(dot_radius_for(outside, 10, 10, 5) ==
          doctest::Approx(std::sqrt(5 / (2 * std::numbers::pi))).epsilon(1e-12));
  }
  CHECK_THROWS_AS(dot_radius_for(random, 80, 80, 0), InvalidInput);
  CHECK_THROWS_AS(dot_radius_for(random, 80, 80, 6401), InvalidInput);
  CHECK_THROWS_AS(dot_radius_for(Points<double>(2, 0), 80, 80, 10), InvalidInput);
  CHECK_THROWS_AS(dot_radius_for(Points<double>(Points<double>::Zero(3, 2)), 80, 80, 10),
                  InvalidInput);
}

TEST_CASE("SVG has one circle a dot, where the dot is") {
  const TemporaryDirectory directory;
  Stippling<double> stippling;
  stippling.width = 40;
  stippling.height = 30;
  stippling.dot_radius = 0.5;
  stippling.dots = scattered(500, 30);
  stippling.dots.eigen().col(0) << 0, 12;
  write_svg(directory / "s.svg", stippling);
  const std::string svg = get(directory / "s.svg");
  CHECK(svg.find("viewBox=\"0 0 40 30\"") != std::string::npos);
  CHECK(svg.find("<circle cx=\"0\" cy=\"12\" r=\"0.5\"/>") != std::string::npos);
  CHECK(svg.substr(svg.size() - 7) == "</svg>\n");
  Eigen::Index dot = 0;
  for (std::size_t at = svg.find("<circle "); at != std::string::npos;
       at = svg.find("<circle ", at + 1), ++dot) {
    REQUIRE(dot < 500);
    const std::size_t x = svg.find("cx=\"", at) + 4;
    const std::size_t y = svg.find("cy=\"", at) + 4;
    CHECK(std::abs(std::stod(svg.substr(x, 20)) - stippling.dots(0, dot)) <= 0.0051);
    CHECK(std::abs(std::stod(svg.substr(y, 20)) - stippling.dots(1, dot)) <= 0.0051);
  }
  CHECK(dot == 500);
  CHECK_THROWS_AS(write_svg(directory / "s.png", stippling), InvalidInput);
  CHECK(directory.entries() == 1);
}

TEST_CASE("render: the ink of a dot is its area, at any place and scale") {
  Stippling<double> stippling;
  stippling.width = 20;
  stippling.height = 10;
  stippling.dot_radius = 2;
  stippling.dots = {2, 1};
  for (const double scale : {1.0, 2.5, 7.0}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      stippling.dots.eigen() << 8 + shift, 5 - shift;
      const Image image = render(stippling, scale);
      CHECK(image.width == std::ceil(20 * scale));
      CHECK(image.height == std::ceil(10 * scale));
      CHECK(ink_of(image) / (scale * scale) == doctest::Approx(std::numbers::pi * 4).epsilon(0.03));
      CHECK(image(static_cast<int>((8 + shift) * scale), static_cast<int>((5 - shift) * scale)) ==
            0);
      CHECK(image(0, 0) == 1);
    }
  }
  stippling.dot_radius = 1e200;
  CHECK(ink_of(render(stippling, 1)) == 200);
  stippling.dot_radius = 2;
  // Smaller than a pixel as well: at each place nearly, and exactly on the average.
  for (const double scale : {0.02, 0.1, 0.2, 0.28}) {
    stippling.width = stippling.height = 1000;
    double sum = 0;
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        stippling.dots.eigen() << (9 + i / 8.0) / scale, (9 + j / 8.0) / scale;
        const double ink = ink_of(render(stippling, scale)) / (scale * scale);
        CHECK(ink == doctest::Approx(std::numbers::pi * 4).epsilon(0.13));
        sum += ink / 64;
      }
    }
    CHECK(sum == doctest::Approx(std::numbers::pi * 4).epsilon(0.005));
  }
  stippling.width = 20;
  stippling.height = 10;
  // Half of a dot on the edge is outside; one that is all outside leaves no trace.
  stippling.dots.eigen() << 0, 5;
  CHECK(ink_of(render(stippling, 8)) / 64 == doctest::Approx(std::numbers::pi * 2).epsilon(0.02));
  stippling.dots.eigen() << -9, 5;
  CHECK(ink_of(render(stippling, 8)) == 0);

  CHECK(render(stippling).width == 30);  // a radius of 3 pixels
  stippling.dot_radius = 5;
  CHECK(render(stippling).width == 20);
  CHECK_THROWS_AS(render(stippling, -1), InvalidInput);
  CHECK_THROWS_AS(render(stippling, 1e6), InvalidInput);
  CHECK_THROWS_AS(render(stippling, std::nan("")), InvalidInput);
  CHECK_THROWS_AS(render(Stippling<double>{}), InvalidInput);
}

TEST_CASE("render: large dots that cover each other are drawn soon, each as if it were alone") {
  Stippling<double> stippling;
  stippling.width = 150;
  stippling.height = 90;
  for (const double radius : {0.3, 9.0, 40.0, 70.0}) {
    CAPTURE(radius);
    stippling.dot_radius = radius;
    const Points<double> dots = scattered(30, 150);
    Image product = constant_image(150, 90, 1);
    for (Index dot = 0; dot < dots.cols(); ++dot) {
      stippling.dots = dots.col(dot);
      const Image alone = render(stippling, 1);
      for (std::size_t i = 0; i < alone.values.size(); ++i) product.values[i] *= alone.values[i];
    }
    stippling.dots = dots;
    CHECK(render(stippling, 1).values == product.values);
  }
  stippling.width = stippling.height = 400;
  stippling.dot_radius = 100;
  stippling.dots = Points<double>(scattered(100000, 40).array() + 150);
  const double start = processor_seconds();
  const Image image = render(stippling, 1);
  CHECK(processor_seconds() - start < 2);
  CHECK(image(170, 170) == 0);
  CHECK(image(0, 0) == 1);
}

TEST_SUITE_END();

}  // namespace ccvt::test
