#pragma once

#include <cstdint>

/// All random streams of one seed: each is used for one thing, so that points and what is done with
/// them may share a seed. Those with room have as many behind them, for parts of the work.
namespace ccvt::streams {

constexpr std::uint64_t room = std::uint64_t{1} << 32;

// The solver.
constexpr std::uint64_t initial_sites = 1;
constexpr std::uint64_t levels = 2;
constexpr std::uint64_t joining_order = 3;

// Thinning.
constexpr std::uint64_t thin_spacing = 32;

// Points with masses.
constexpr std::uint64_t mass_offset = 8;

// Codebooks.
constexpr std::uint64_t codebook_sample = 16;
constexpr std::uint64_t codebook_seeding = 17;
constexpr std::uint64_t codebook_levels = 18;
constexpr std::uint64_t codebook_restarts = 64;                      ///< with room
constexpr std::uint64_t codebook_breeding = 0x62726564'00000000ULL;  ///< with room

// Drawing points, with room.
constexpr std::uint64_t uniform = 0x73616d70'00000000ULL;
constexpr std::uint64_t density_mass = 0x73616d71'00000000ULL;
constexpr std::uint64_t density_place = 0x73616d72'00000000ULL;
constexpr std::uint64_t function_tabulate = 0x73616d73'00000000ULL;
constexpr std::uint64_t density_deal = 0x73616d74'00000000ULL;
constexpr std::uint64_t surface = 0x73616d75'00000000ULL;
constexpr std::uint64_t density_far_mass = 0x73617000'00000000ULL;  ///< with 2^40 behind it

// Metrics, with room.
constexpr std::uint64_t integration_places = 0x696e7467'00000000ULL;
constexpr std::uint64_t spectrum_frequencies = 0x73706563'00000000ULL;

}  // namespace ccvt::streams
