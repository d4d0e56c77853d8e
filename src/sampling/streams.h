#pragma once

#include <cstdint>

/// Random streams of sampling, away from those of the solver, so that points and their
/// tessellation may share a seed. Each has room for 2^32 more behind it.
namespace ccvt::streams {

constexpr std::uint64_t uniform = 0x73616d70'00000000ULL;
constexpr std::uint64_t density_mass = 0x73616d71'00000000ULL;
constexpr std::uint64_t density_place = 0x73616d72'00000000ULL;
constexpr std::uint64_t function_tabulate = 0x73616d73'00000000ULL;
constexpr std::uint64_t density_deal = 0x73616d74'00000000ULL;

}  // namespace ccvt::streams
