#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "ccvt/io.h"
#include "io/particle_load.h"
#include "io/points_map.h"

/// GADGET's binary files, formats 1 and 2 [Springel 2005, User guide for GADGET-2, 6]: records with
/// their length, an int32, before and behind; HEAD, POS, VEL, ID, and U of gas.
namespace ccvt::io {

/// Throws InvalidInput unless a record can hold something of so many particles.
void check_gadget_size(const std::filesystem::path& path, std::uint64_t particles,
                       std::size_t scalar_bytes);

/// Real numbers as Real.
template <class Real>
void write_gadget(const std::filesystem::path& path, const ParticleLoad& load);

/// Positions of the particles of all types. Both formats, little endian, one file; positions in
/// float32 or float64. Both throw InvalidInput unless the header and the records agree;
/// read_gadget_points() does not look whether coordinates are finite.
PointsHeader inspect_gadget_points(const std::filesystem::path& path);
template <class Scalar>
PointsMap<Scalar> read_gadget_points(const std::filesystem::path& path,
                                     const detail::Allocation<Scalar>& allocation);

}  // namespace ccvt::io
