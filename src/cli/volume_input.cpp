#include "cli/volume_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <variant>

#include "cli/standard_streams.h"
#include "cli/values.h"

namespace ccvt::cli {

namespace {

/// Whether all values beyond some have the same density.
bool has_limits(const ValueMap& map) {
  return map.kind == ValueMap::Kind::window || map.kind == ValueMap::Kind::threshold;
}

/// Calls visit(i, value) for each cell.
template <class Visit>
void visit_values(const Volume& volume, const Visit& visit) {
  std::visit(
      [&](const auto& numbers) {
        for (std::size_t i = 0; i < numbers.size(); ++i) {
          const double value = volume.slope * static_cast<double>(numbers[i]) + volume.intercept;
          visit(i, value);
        }
      },
      volume.stored());
}

[[noreturn]] void refuse_value(const VolumeArguments& arguments, std::uint64_t cell, double value) {
  const std::string file = arguments.volume.string();
  throw InvalidInput(
      file + ": value " + std::to_string(cell) + " is " + concat(value) +
      (std::isnan(value)
           ? "; leave such cells out with --mask FILE, a volume that is 0 or NaN there: " + file +
                 " itself would do"
           : "; choose which values matter with --map window:LO,HI or --map threshold:T"));
}

std::string words_of(const std::vector<std::int64_t>& labels) {
  std::string words = labels.size() == 1 ? "the label " : "one of the labels ";
  for (std::size_t i = 0; i < labels.size(); ++i) {
    words += (i > 0 ? ", " : "") + std::to_string(labels[i]);
  }
  return words;
}

/// The edges of the box of all cells, one a column.
Eigen::Matrix3d sides_of(const Grid& grid) {
  const Eigen::Map<const Eigen::Vector3<std::int64_t>> cells(grid.shape.data());
  return grid.axes.eigen() * cells.cast<double>().asDiagonal();
}

/// Whether two grids have the same sides, but not one after the other as they are in memory.
bool in_another_order(const Grid& a, const Grid& b) {
  const double tolerance = 0.1 * a.spacing().minCoeff();
  std::array<int, 3> order = {0, 1, 2};
  const auto alike = [&] {
    return (sides_of(a) - sides_of(b)(Eigen::all, order)).colwise().norm().sum() <= tolerance;
  };
  if (alike()) return false;
  while (std::next_permutation(order.begin(), order.end())) {
    if (alike()) return true;
  }
  return false;
}

}  // namespace

void check_labels(const VolumeArguments& arguments) {
  if (arguments.labels.empty() || !arguments.mask.empty()) return;
  throw InvalidInput("--label: needs --mask, the volume of labels; see ccvt volume --help");
}

VolumeHeader inspect_input(const std::filesystem::path& file, const VolumeLayout& layout) {
  VolumeHeader header = inspect_volume(file, layout);
  if (is_from_stream(file) && header.data_file != file) {
    throw InvalidInput(with_names_of_streams(file.string()) +
                       ": its header names a data file, which a stream has no directory for; name "
                       "the header as a file");
  }
  return header;
}

void check_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                const VolumeHeader& mask) {
  const auto shape = [](const VolumeHeader& header) {
    std::string result;
    for (const auto n : header.grid.shape) {
      result += (result.empty() ? "" : " x ") + std::to_string(n);
    }
    return result;
  };
  if (in_another_order(volume.grid, mask.grid)) {
    throw InvalidInput(arguments.mask.string() +
                       ": its axes are stored in another order than those of " +
                       arguments.volume.string() +
                       " (of two .npy, one is in C order, the other in Fortran order): store both "
                       "alike");
  }
  if (volume.grid.shape != mask.grid.shape) {
    throw InvalidInput(arguments.mask.string() + ": has " + shape(mask) + " cells, but " +
                       arguments.volume.string() + " has " + shape(volume));
  }
  const double tolerance = 0.1 * volume.grid.spacing().minCoeff();
  const Eigen::Vector3d moved = volume.grid.origin.eigen() - mask.grid.origin.eigen();
  const Eigen::Matrix3d turned = sides_of(volume.grid) - sides_of(mask.grid);
  if (moved.norm() > tolerance || turned.colwise().norm().sum() > tolerance) {
    throw InvalidInput(arguments.mask.string() + ": its cells are not where those of " +
                       arguments.volume.string() + " are; resample it first");
  }
}

std::vector<std::uint8_t> mask_of(const VolumeArguments& arguments, const Volume& file) {
  std::vector<std::uint8_t> mask(file.cells());
  const auto counts = [&](double value) {
    if (arguments.labels.empty()) return value != 0 && !std::isnan(value);
    return std::any_of(arguments.labels.begin(), arguments.labels.end(),
                       [&](std::int64_t label) { return value == static_cast<double>(label); });
  };
  visit_values(file, [&](std::size_t i, double value) { mask[i] = counts(value) ? 1 : 0; });
  return mask;
}

bool counts(std::span<const std::uint8_t> mask) {
  return std::any_of(mask.begin(), mask.end(), [](std::uint8_t entry) { return entry != 0; });
}

void refuse_mask(const VolumeArguments& arguments) {
  throw InvalidInput(
      arguments.mask.string() + ": no cell " +
      (arguments.labels.empty() ? "is anything but 0" : "has " + words_of(arguments.labels)));
}

std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume) {
  if (arguments.mask.empty()) return {};
  check_mask(arguments, volume, inspect_volume(arguments.mask, arguments.layout));
  std::vector<std::uint8_t> mask =
      mask_of(arguments, read_volume(arguments.mask, arguments.layout));
  if (!counts(mask)) refuse_mask(arguments);
  return mask;
}

void check_values(const VolumeArguments& arguments, const Volume& volume,
                  const std::vector<std::uint8_t>& mask) {
  check_range(arguments, check_each_value(arguments, volume, mask, 0));
}

ValueRange check_each_value(const VolumeArguments& arguments, const Volume& part,
                            const std::vector<std::uint8_t>& mask, std::uint64_t first_cell) {
  ValueRange values;
  visit_values(part, [&](std::size_t i, double value) {
    if (!mask.empty() && mask[i] == 0) return;
    if (std::isnan(value) || (!has_limits(arguments.map) && std::isinf(value))) {
      refuse_value(arguments, first_cell + i, value);
    }
    values.least = std::min(values.least, value);
    values.most = std::max(values.most, value);
  });
  return values;
}

void check_range(const VolumeArguments& arguments, const ValueRange& values) {
  if (has_limits(arguments.map) || arguments.map.invert || !(values.least < 0)) return;
  throw InvalidInput(arguments.volume.string() + ": has values from " + concat(values.least) +
                     " to " + concat(values.most) +
                     ", but a density is not negative; choose which values matter with --map "
                     "window:LO,HI (0 up to LO, full from HI) or --map threshold:T");
}

}  // namespace ccvt::cli
