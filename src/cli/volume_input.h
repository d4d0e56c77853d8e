#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "cli/arguments.h"

namespace ccvt::cli {

/// The header of FILE or --mask. Throws InvalidInput, as inspect_volume() does, and where standard
/// input has the header, but not the data.
VolumeHeader inspect_input(const std::filesystem::path& file, const VolumeLayout& layout);

/// One byte for each cell of `volume`: not 0 where --mask, and --label, let samples be; empty
/// without --mask. Throws InvalidInput unless the mask has the cells of the volume, at the same
/// places, and some of them count.
std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume);

/// Throws InvalidInput, naming the option that helps, for values that --map makes no density of.
void check_values(const VolumeArguments& arguments, const Volume& volume,
                  const std::vector<std::uint8_t>& mask);

}  // namespace ccvt::cli
