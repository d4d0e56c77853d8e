// What stands in for hdf5_particles.cpp where there is no HDF5.

#include "io/hdf5_particles.h"

namespace ccvt::io {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw InvalidInput(path.string() +
                     ": this ccvt was built without HDF5; with libhdf5-dev (Debian) installed, "
                     "configure and build it again");
}

}  // namespace

bool has_hdf5() { return false; }

void check_hdf5(const std::filesystem::path& path) { fail(path); }

void write_hdf5_particles(const std::filesystem::path& path, const ParticleLoad&) { fail(path); }

PointsHeader inspect_hdf5_points(const std::filesystem::path& path) { fail(path); }

template <class Scalar>
PointsMap<Scalar> read_hdf5_points(const std::filesystem::path& path,
                                   const detail::Allocation<Scalar>&) {
  fail(path);
}

template PointsMap<float> read_hdf5_points(const std::filesystem::path&,
                                           const detail::Allocation<float>&);
template PointsMap<double> read_hdf5_points(const std::filesystem::path&,
                                            const detail::Allocation<double>&);

}  // namespace ccvt::io
