// Samples as dense as a function says, here ripples round the origin: sites.csv and a picture.
//   g++ -std=c++20 -O2 density_function.cpp $(pkg-config --cflags --libs ccvt) -o density_function
//   ./density_function FOLDER
#include <ccvt/ccvt.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <iostream>
#include <span>

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: density_function FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);

  // Any function of the coordinates that is nowhere negative, and nowhere above the maximum given.
  const auto density = [](std::span<const double> x) {
    const double r = std::hypot(x[0], x[1]);
    return std::exp(-r / 2) * (1 + std::cos(4 * r)) / 2;
  };
  const ccvt::Box box{{-4, -4}, {4, 4}};
  constexpr ccvt::Index count = 3000;

  // Points drawn from it, 256 for each site, of which each site then owns exactly as many.
  // With several threads (0: one per processor) the function is called by several at once.
  const auto points =
      ccvt::sample_function<float, 2>(density, /*maximum=*/1, box, count * 256, /*seed=*/1,
                                      ccvt::DensitySampling::stratified, /*threads=*/0);
  const auto [sites, owners, summary] = ccvt::tessellate(points, count, ccvt::Options::samples());
  ccvt::write_points(folder / "sites.csv", sites);
  std::cout << summary.brief() << "\n";

  // The box as a picture of 800 x 800 pixels, y upward.
  Eigen::Matrix2Xf pixels(2, sites.cols());
  pixels.row(0) = 100 * (sites.row(0).array() + 4);
  pixels.row(1) = 100 * (4 - sites.row(1).array());
  const ccvt::Stippling<float> dots{800, 800, pixels, /*dot_radius=*/2.5, {}};
  ccvt::write_png(folder / "sites.png", ccvt::render(dots, /*scale=*/1));
} catch (const std::exception& error) {
  std::cerr << "density_function: " << error.what() << "\n";
  return 1;
}
