#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "cli/arguments.h"

namespace ccvt::cli {

/// Throws InvalidInput where there are labels, but no --mask.
void check_labels(const VolumeArguments& arguments);

/// The header of FILE or --mask. Throws InvalidInput, as inspect_volume() does, and where standard
/// input has the header, but not the data.
VolumeHeader inspect_input(const std::filesystem::path& file, const VolumeLayout& layout);

/// One byte for each cell of `volume`: not 0 where --mask, and --label, let samples be; empty
/// without --mask. Throws InvalidInput unless the mask has the cells of the volume, at the same
/// places, and some of them count.
std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume);

/// Of a mask of which processes have parts: throws unless it is of that volume; what is in a part,
/// and whether any of that counts; and throws, where none does on any of them.
void check_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                const VolumeHeader& mask);
std::vector<std::uint8_t> mask_of(const VolumeArguments& arguments, const Volume& file);
bool counts(std::span<const std::uint8_t> mask);
[[noreturn]] void refuse_mask(const VolumeArguments& arguments);

/// Throws InvalidInput, naming the option that helps, for values that --map makes no density of.
void check_values(const VolumeArguments& arguments, const Volume& volume,
                  const std::vector<std::uint8_t>& mask);

/// The values of cells that count, where there are any.
struct ValueRange {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};
/// The same in two steps: each value of a part, whose first cell is `first_cell`, and all together.
ValueRange check_each_value(const VolumeArguments& arguments, const Volume& part,
                            const std::vector<std::uint8_t>& mask, std::uint64_t first_cell);
void check_range(const VolumeArguments& arguments, const ValueRange& values);

}  // namespace ccvt::cli
