// Points where they lie, without a copy: in a vector of your own structs, and in memory of somebody
// else; float stays float, double stays double.
//   g++ -std=c++20 -O2 own_types.cpp $(pkg-config --cflags --libs ccvt) -o own_types && ./own_types
#include <ccvt/ccvt.h>

#include <iostream>
#include <random>
#include <span>
#include <vector>

struct Particle {
  float x, y, z;  // neighbours in memory: the coordinates of a point
  float temperature;
};

/// Coordinates are found by a stride: the floats from one particle to the next.
auto positions_of(const std::vector<Particle>& particles) {
  constexpr int stride = sizeof(Particle) / sizeof(float);
  using View = Eigen::Map<const Eigen::Matrix3Xf, Eigen::Unaligned, Eigen::OuterStride<>>;
  return View(&particles[0].x, 3, std::ssize(particles), Eigen::OuterStride<>(stride));
}

/// Memory that another library lends: x0 y0 x1 y1 ... Neither Eigen nor a stride is needed.
ccvt::PointsView<double> plane_points(std::span<const double> numbers) {
  return {.data = numbers.data(),
          .dimension = 2,
          .count = static_cast<ccvt::Index>(numbers.size() / 2),
          .stride = 2};
}

int main() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  std::vector<Particle> particles(25'600);
  for (Particle& p : particles) {
    p = {uniform(random), uniform(random), uniform(random), 0};
    p.temperature = 300 + 10 * p.z;
  }
  const auto cells = ccvt::tessellate(positions_of(particles), 100);

  // Owners are in the order of the particles, whose other members are thus at hand. What rises
  // evenly with the height is, in the mean over a cell, what it is at the site, the centroid.
  std::vector<float> mean(100);
  for (std::size_t p = 0; p < particles.size(); ++p) {
    mean[static_cast<std::size_t>(cells.owners[p])] += particles[p].temperature / 256;
  }
  std::cout << "site 0 at " << cells.sites.col(0).transpose() << ", mean temperature " << mean[0]
            << "\n";

  std::vector<double> lent(51'200);
  for (double& number : lent) number = uniform(random);
  const ccvt::Problem<double> problem(plane_points(lent), 100);
  const ccvt::Result<double, 2> plane = ccvt::tessellate<2>(problem);
  std::cout << plane.sites.cols() << " sites of type double: " << plane.summary.brief() << "\n";
}
