#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/types.h"

/// Particle loads: sites in a periodic cube as particles at rest, the uniform start from which
/// cosmological and SPH simulations are set up [Liao 2018, arXiv:1807.03574], by extension:
///
///   .gadget  GADGET's binary files: formats 1 and 2 with the header of GADGET-2, 256 bytes (of
///            GADGET-4 when it is built with GADGET2_HEADER), little endian. Coordinates and
///            velocities are float32 or float64 as the sites are, numbers of particles uint32. A
///            record has 2^31 - 1 bytes at most: 178,956,970 particles in float32.
///   .hdf5    HDF5 files as GADGET-4, SWIFT and AREPO document theirs: groups Header, RuntimePars
///            and PartType0 or 1. Coordinates are float64 of shape (#particles, 3). Velocities (0)
///            and masses are datasets with a fill value, and take no space. Counts and numbers of
///            particles are uint32, from 2^32 particles on uint64: then NumPart_Total holds all of
///            the count, and NumPart_Total_HighWord is 0, which those that can read so many from
///            one file, SWIFT and GADGET-4, both understand. Only where the library was built with
///            libhdf5: elsewhere InvalidInput says so.
///
/// read_points() in io.h reads the positions back. Units are those of the numbers that are given:
/// files say nothing of them.
namespace ccvt {

/// The types of GADGET that a load may have; the numbers are those in files.
enum class ParticleType { gas = 0, dark_matter = 1 };

/// What is written of particles beside their places.
struct ParticleOptions {
  /// Side of the periodic cube that is written, BoxSize; 1e-30 to 1e30.
  double box_size = 1;
  /// The sites are a tile, laid so many times along each axis: repeat^3 as many particles. 1 to
  /// 1000.
  int repeat = 1;
  /// Mean mass in a unit of volume. All particles have the same mass. Above 0.
  double density = 1;
  /// Redshift in the header; Time is 1 / (1 + redshift). SWIFT holds it against its parameter file.
  /// At least 0.
  double redshift = 0;
  /// Gas has an internal energy, 0, for the simulation to set, and in .hdf5 a smoothing length,
  /// 1.2348 mean spacings, which makes 48 neighbours of the cubic spline [Dehnen, Aly 2012].
  ParticleType type = ParticleType::dark_matter;
  /// Of .gadget: 1 or 2. 2 has a record with a label in front of each.
  int gadget_format = 1;
  /// Asked for each 2^16 particles; true makes write_particles() remove what it has begun, and
  /// throw Cancelled.
  std::function<bool()> cancelled = {};
};

/// The number of particles, repeat^3 for each site.
[[nodiscard]] CCVT_EXPORT std::uint64_t particle_count(Index sites, const ParticleOptions& options);

/// The mass of each, density * box_size^3 / particle_count().
[[nodiscard]] CCVT_EXPORT double particle_mass(Index sites, const ParticleOptions& options);

/// Throws InvalidInput where write_particles() would, of sites of so many bytes a coordinate, but
/// looks at no file and no site: to be called before the sites are made.
CCVT_EXPORT void check_particles(const std::filesystem::path& path, Index sites,
                                 std::size_t scalar_bytes, const ParticleOptions& options);

/// `sites`: 3 by n, in the periodic unit cube, its faces included, as tessellate() leaves them
/// there. Particle p of tile (i, j, k), i fastest, has the number 1 + p + n (i + repeat (j +
/// repeat k)) and is at (site + (i, j, k)) box_size / repeat, rounded to the type of the file; what
/// that rounds to box_size is at 0, so that all coordinates are in [0, box_size). O(particles)
/// time, O(n) memory.
///
/// Files are written as io.h says of all writers. Throws InvalidInput for sites outside the cube or
/// of other than 3 dimensions, options out of range, another extension, or more particles than the
/// format holds; IoError when the system refuses.
template <class Scalar>
CCVT_EXPORT void write_particles(const std::filesystem::path& path, PointsView<Scalar> sites,
                                 const ParticleOptions& options = {});
template <class Derived>
void write_particles(const std::filesystem::path& path, const Eigen::DenseBase<Derived>& sites,
                     const ParticleOptions& options = {}) {
  write_particles(path, view_points(sites), options);
}
template <class Scalar>
void write_particles(const std::filesystem::path& path, const Columns<Scalar>& sites,
                     const ParticleOptions& options = {}) {
  write_particles(path, view_points(sites), options);
}

}  // namespace ccvt
