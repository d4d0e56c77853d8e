// Watch sites spread: an animated GIF with a frame for each iteration of the solver.
//   g++ -std=c++20 -O2 relax_gif.cpp $(pkg-config --cflags --libs ccvt) -o relax_gif
//   ./relax_gif relax.gif
#include <ccvt/ccvt.h>

#include <exception>
#include <iostream>
#include <vector>

#include "gif.h"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: relax_gif FILE.gif\n";
    return 2;
  }
  constexpr int size = 320, count = 500;
  const ccvt::Box picture{{0, 0}, {size, size}};
  const auto points = ccvt::sample_uniform<float, 2>(picture, count * 256, /*seed=*/1);

  // With random owners all sites start as the centroids of the same cloud, in the middle. That and
  // one level show how sites find their places; the defaults start better, and are there sooner.
  ccvt::Problem problem(points, count);
  problem.set_domain(ccvt::Domain::euclidean(picture));
  ccvt::Solver solver(problem, {.energy_tolerance = 1e-4,
                                .initialization = ccvt::Initialization::random,
                                .multilevel = false});

  std::vector<ccvt::Image> frames;
  const auto draw = [&] {
    const ccvt::Stippling<float> dots{size, size, solver.sites(), /*dot_radius=*/3, {}};
    frames.push_back(ccvt::render(dots, /*scale=*/1));
  };
  draw();
  while (solver.step()) draw();

  ccvt::write_text(argv[1], animated_gif(frames, /*hundredths=*/12));
  std::cout << frames.size() << " frames; " << solver.summary().brief() << "\n";
} catch (const std::exception& error) {
  std::cerr << "relax_gif: " << error.what() << "\n";
  return 1;
}
