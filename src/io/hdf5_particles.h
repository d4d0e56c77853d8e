#pragma once

#include <filesystem>

#include "ccvt/io.h"
#include "io/particle_load.h"
#include "io/points_map.h"

/// Particles in HDF5 files: see ccvt/particles.h. Where the library is built without HDF5,
/// hdf5_absent.cpp takes the place of hdf5_particles.cpp.
namespace ccvt::io {

/// Whether the library is built with it.
bool has_hdf5();

/// Throws InvalidInput, which says what is missing, unless there is HDF5.
void check_hdf5(const std::filesystem::path& path);

/// Throws IoError.
void write_hdf5_particles(const std::filesystem::path& path, const ParticleLoad& load);

/// Coordinates of the particles of all types, of one file. Both throw InvalidInput unless it has
/// datasets PartType*/Coordinates of shape (#particles, 3) and real numbers;
/// read_hdf5_points() does not look whether coordinates are finite.
PointsHeader inspect_hdf5_points(const std::filesystem::path& path);
template <class Scalar>
PointsMap<Scalar> read_hdf5_points(const std::filesystem::path& path,
                                   const detail::Allocation<Scalar>& allocation);

}  // namespace ccvt::io
