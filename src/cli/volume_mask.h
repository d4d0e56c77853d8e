#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cli/arguments.h"

/// --mask, --mask-type and --label.
namespace ccvt::cli {

/// Throws InvalidInput where there are labels, but no --mask, or its type where it says that
/// itself.
void check_mask_options(const VolumeArguments& arguments);

/// What --spacing, --origin, --shape and --type say of FILE, or of --mask: what only the other of
/// the two takes is not for this one.
VolumeLayout layout_of_volume(const VolumeArguments& arguments);
VolumeLayout layout_of_mask(const VolumeArguments& arguments);

/// The header of --mask. A file that has no place of its own (.npy, .raw) beside one that has
/// (.nii, .nrrd) counts the cells along the axes of that.
VolumeHeader inspect_mask(const VolumeArguments& arguments, const VolumeHeader& volume);

/// Which axis of the mask each axis of the volume is, and whether from its end. Throws InvalidInput
/// unless the mask has the cells of the volume, at the same places.
struct MaskAxis {
  int axis;
  bool reversed;
  bool operator==(const MaskAxis&) const = default;
};
using AxisOrder = std::array<MaskAxis, 3>;
AxisOrder order_of_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                        const VolumeHeader& mask);

/// One byte for each cell of `volume`: not 0 where --mask, whose header is `mask`, and --label let
/// samples be. Throws InvalidInput as order_of_mask() does, and unless some cells count.
std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                                    const VolumeHeader& mask);

/// Of a mask of which processes have parts: throws unless it is of that volume, and stored in the
/// same order; what is in a part, and whether any of that counts; and throws, where none does on
/// any of them.
void check_mask_of_parts(const VolumeArguments& arguments, const VolumeHeader& volume,
                         const VolumeHeader& mask);
std::vector<std::uint8_t> mask_of(const VolumeArguments& arguments, const Volume& file);
bool counts(std::span<const std::uint8_t> mask);
[[noreturn]] void refuse_mask(const VolumeArguments& arguments);

}  // namespace ccvt::cli
