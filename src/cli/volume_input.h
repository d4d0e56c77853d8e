#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <variant>
#include <vector>

#include "cli/arguments.h"

namespace ccvt::cli {

/// Whether a file is nothing but values.
bool is_raw(const std::filesystem::path& file);

/// The header of a volume. Throws InvalidInput, as inspect_volume() does, naming the options that
/// a raw file needs, and where standard input has the header, but not the data.
VolumeHeader inspect_input(const std::filesystem::path& file, const VolumeLayout& layout);

/// Calls visit(i, value) for each cell.
template <class Visit>
void visit_values(const Volume& volume, const Visit& visit) {
  std::visit(
      [&](const auto& numbers) {
        for (std::size_t i = 0; i < numbers.size(); ++i) {
          visit(i, volume.slope * static_cast<double>(numbers[i]) + volume.intercept);
        }
      },
      volume.stored());
}

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
