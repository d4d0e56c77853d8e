// Particles at rest in a periodic box, to start a simulation from: even, but on no grid.
//   g++ -std=c++20 -O2 particle_load.cpp $(pkg-config --cflags --libs ccvt) -o particle_load
//   ./particle_load load.gadget    (or load.hdf5)
#include <ccvt/ccvt.h>

#include <exception>
#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: particle_load FILE.gadget|FILE.hdf5\n";
    return 2;
  }
  const ccvt::Box box = ccvt::Box::unit(3);
  constexpr ccvt::Index count = 12 * 12 * 12;
  const auto points = ccvt::sample_uniform<double, 3>(box, count * 256, /*seed=*/1);
  ccvt::Problem problem(points, count);
  problem.set_domain(ccvt::Domain::periodic(box));
  const auto load = ccvt::tessellate<3>(problem, ccvt::Options::samples());

  // Eight copies side by side fill a box of side 100; masses follow from the mean density.
  const ccvt::ParticleOptions options{.box_size = 100, .repeat = 2, .density = 8.6, .redshift = 49};
  ccvt::write_particles(argv[1], load.sites, options);

  const ccvt::PointSet set(load.sites, problem.domain());
  std::cout << ccvt::particle_count(count, options) << " particles of mass "
            << ccvt::particle_mass(count, options) << "; nearest neighbours are "
            << ccvt::nearest_distances(set).smallest
            << " of the distance in the densest lattice apart, or more\n";
} catch (const std::exception& error) {
  std::cerr << "particle_load: " << error.what() << "\n";
  return 1;
}
