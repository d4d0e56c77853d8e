// Points that move, such as particles of a simulation: each step starts from the cells of the step
// before, which takes a fraction of the iterations, and sites keep their numbers.
//   g++ -std=c++20 -O2 warm_start.cpp $(pkg-config --cflags --libs ccvt) -o warm_start
//   ./warm_start
#include <ccvt/ccvt.h>

#include <iostream>

int main() {
  constexpr ccvt::Index count = 500;
  const ccvt::Box box = ccvt::Box::unit(2);
  Eigen::Matrix2Xd points = ccvt::sample_uniform<double, 2>(box, count * 256, /*seed=*/1);
  auto before = ccvt::tessellate(points, count);

  for (int step = 1; step <= 5; ++step) {
    // A slow swirl: sideways by a wave of the height, then up and down by a wave of the width.
    points.row(0).array() += 0.002 * (6 * points.row(1).array()).sin();
    points.row(1).array() += 0.002 * (6 * points.row(0).array()).sin();

    ccvt::Problem problem(points, count);
    problem.set_initial_owners(before.owners);
    const auto warm = ccvt::tessellate<2>(problem, {.multilevel = false});
    const auto cold = ccvt::tessellate(points, count);
    std::cout << "step " << step << ": " << warm.summary.iterations << " iterations, cold "
              << cold.summary.iterations << "\n";
    before = warm;
  }
}
