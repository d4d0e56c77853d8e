// Samples of a volume, each with the mass that it stands for. The volume is a file (NIfTI, NRRD,
// .npy) or, without one, a shell made here. The samples open in MeshLab, Blender and ParaView.
//   g++ -std=c++20 -O2 volume.cpp $(pkg-config --cflags --libs ccvt) -o volume
//   ./volume samples.ply [scan.nii.gz]
#include <ccvt/ccvt.h>

#include <cmath>
#include <cstddef>
#include <exception>
#include <iostream>
#include <vector>

constexpr ccvt::Index count = 5000;

/// Cells of 2 x 2 x 4 millimetres; the density falls from 1 at a radius of 40 to 0 at 30 and 50.
ccvt::VolumeSamples sample_shell() {
  const auto grid = ccvt::Grid::spaced({64, 64, 32}, {2, 2, 4}, /*origin=*/{-63, -63, -62});
  std::vector<float> values;  // x varies fastest
  for (int z = 0; z < 32; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double radius = std::hypot(2 * x - 63, 2 * y - 63, 4 * z - 62);
        values.push_back(static_cast<float>(std::fmax(0, 1 - std::abs(radius - 40) / 10)));
      }
    }
  }
  return ccvt::sample_volume(grid.density(values), count);  // values are used where they are
}

/// World coordinates are those of the file. A ValueMap can make densities of the values.
ccvt::VolumeSamples sample_file(const char* path) {
  const ccvt::Volume scan = ccvt::read_volume(path);
  return ccvt::sample_volume(scan.density(), count);
}

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: volume SAMPLES.ply [VOLUME]\n";
    return 2;
  }
  try {
    const ccvt::VolumeSamples samples = argc == 3 ? sample_file(argv[2]) : sample_shell();
    ccvt::write_samples(argv[1], samples);  // x, y, z, radius, capacity, weight

    // The sum of weight * f(site) is an estimate of the integral of density * f.
    double mass = 0, second_moment = 0;
    for (std::ptrdiff_t s = 0; s < samples.sites.cols(); ++s) {
      const double weight = samples.weights[static_cast<std::size_t>(s)];
      mass += weight;
      second_moment += weight * samples.sites.col(s).cast<double>().squaredNorm();
    }
    std::cout << samples.summary.brief() << "\nmass " << mass << ", root mean square of the radius "
              << std::sqrt(second_moment / mass) << "\n";
  } catch (const std::exception& error) {  // one line: what is wrong, with which file or argument
    std::cerr << "volume: " << error.what() << "\n";
    return 1;
  }
}
