#include "cli/volume_mask.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "cli/outputs.h"
#include "cli/standard_streams.h"
#include "cli/volume_input.h"
#include "io/formats.h"

namespace ccvt::cli {

namespace {

constexpr AxisOrder kSameOrder = {MaskAxis{0, false}, MaskAxis{1, false}, MaskAxis{2, false}};

/// Whether a file does not say where in the world its values are.
bool has_no_place(const std::filesystem::path& file) {
  return is_raw(file) || io::extension_of(file) == ".npy";
}

/// What is said of `file`, where there is `other` too.
VolumeLayout layout_of(const std::filesystem::path& file, const std::filesystem::path& other,
                       VolumeLayout layout) {
  if (is_raw(other) && !is_raw(file)) {
    layout.shape.clear();
    layout.type.reset();
    layout.big_endian = false;
  }
  if (has_no_place(other) && !has_no_place(file)) {
    layout.spacing.clear();
    layout.origin.clear();
  }
  return layout;
}

/// The edges of the box of all cells, one a column.
Eigen::Matrix3d sides_of(const Grid& grid) {
  const Eigen::Map<const Eigen::Vector3<std::int64_t>> cells(grid.shape.data());
  return grid.axes.eigen() * cells.cast<double>().asDiagonal();
}

std::string shape_text(std::span<const std::int64_t> shape) {
  std::string result;
  for (const std::int64_t cells : shape) {
    result += (result.empty() ? "" : " x ") + std::to_string(cells);
  }
  return result;
}

std::string words_of(const std::vector<std::int64_t>& labels) {
  std::string words = labels.size() == 1 ? "the label " : "one of the labels ";
  for (std::size_t i = 0; i < labels.size(); ++i) {
    words += (i > 0 ? ", " : "") + std::to_string(labels[i]);
  }
  return words;
}

/// Which axis of b runs nearest along each of a, or against it.
AxisOrder directions(const Grid& a, const Grid& b) {
  const Eigen::Matrix3d along =
      a.axes.eigen().colwise().normalized().transpose() * b.axes.eigen().colwise().normalized();
  std::array<int, 3> axes = {0, 1, 2};
  AxisOrder best = kSameOrder;
  double most = -1;
  do {
    double sum = 0;
    AxisOrder order = kSameOrder;
    for (int axis = 0; axis < 3; ++axis) {
      const int other = axes.data()[axis];
      sum += std::abs(along(axis, other));
      order.data()[axis] = {other, along(axis, other) < 0};
    }
    if (sum > most + 1e-9) best = order;
    most = std::max(most, sum);
  } while (std::next_permutation(axes.begin(), axes.end()));
  return best;
}

/// The same cells, their axes in that order.
Grid reordered(const Grid& grid, const AxisOrder& order) {
  Grid result = grid;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [from, reversed] = order.data()[axis];
    const std::int64_t cells = grid.shape[static_cast<std::size_t>(from)];
    const Eigen::Vector3d step = grid.axes.col(from);
    result.shape[static_cast<std::size_t>(axis)] = cells;
    result.axes.eigen().col(axis) = reversed ? Eigen::Vector3d(-step) : step;
    if (reversed) result.origin.eigen() += step * static_cast<double>(cells - 1);
  }
  return result;
}

/// Cells along x, y and z, or what runs nearest along these.
std::array<std::int64_t, 3> shape_in_world(const Grid& grid) {
  Grid world = grid;
  world.axes = Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Grid seen = reordered(grid, directions(world, grid));
  return {seen.shape[0], seen.shape[1], seen.shape[2]};
}

/// The same cells in a space whose x and y run the other way.
Grid turned_round(const Grid& grid) {
  Grid result = grid;
  result.axes.eigen().topRows(2) *= -1;
  result.origin.eigen().head(2) *= -1;
  return result;
}

/// Whether the cells of b lie where those of a do, axis by axis.
bool coincide(const Grid& a, const Grid& b) {
  const double tolerance = 0.1 * a.spacing().minCoeff();
  const Eigen::Vector3d moved = a.origin.eigen() - b.origin.eigen();
  const Eigen::Matrix3d turned = sides_of(a) - sides_of(b);
  return moved.norm() <= tolerance && turned.colwise().norm().sum() <= tolerance;
}

[[noreturn]] void refuse_shape(const VolumeArguments& arguments, const Grid& volume,
                               const Grid& mask) {
  std::array<std::int64_t, 3> of_volume = shape_in_world(volume);
  std::array<std::int64_t, 3> of_mask = shape_in_world(mask);
  if (of_volume == of_mask) {
    throw InvalidInput(arguments.mask.string() + ": its axes are turned against those of " +
                       arguments.volume.string() + "; resample it first");
  }
  const std::string message = arguments.mask.string() + ": has " + shape_text(of_mask) +
                              " cells along x, y and z, but " + arguments.volume.string() +
                              " has " + shape_text(of_volume);
  std::sort(of_volume.begin(), of_volume.end());
  std::sort(of_mask.begin(), of_mask.end());
  throw InvalidInput(message +
                     (of_volume == of_mask ? ": they say otherwise where their axes point" : ""));
}

/// The values of a mask, in the order of the volume that has these axes of it.
std::vector<std::uint8_t> reordered(const std::vector<std::uint8_t>& mask, const Grid& grid,
                                    const AxisOrder& order) {
  const auto cells = [&](int axis) { return grid.shape[static_cast<std::size_t>(axis)]; };
  const std::array<std::int64_t, 3> strides = {1, cells(0), cells(0) * cells(1)};
  std::array<std::int64_t, 3> count{};
  std::array<std::int64_t, 3> step{};
  std::int64_t first = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto [axis, reversed] = order.data()[a];
    const std::int64_t stride = strides.data()[axis];
    count.data()[a] = cells(axis);
    step.data()[a] = reversed ? -stride : stride;
    if (reversed) first += stride * (cells(axis) - 1);
  }
  std::vector<std::uint8_t> result;
  result.reserve(mask.size());
  for (std::int64_t k = 0; k < count[2]; ++k) {
    for (std::int64_t j = 0; j < count[1]; ++j) {
      const std::int64_t row = first + j * step[1] + k * step[2];
      for (std::int64_t i = 0; i < count[0]; ++i) {
        result.push_back(mask[static_cast<std::size_t>(row + i * step[0])]);
      }
    }
  }
  return result;
}

}  // namespace

void check_mask_options(const VolumeArguments& arguments) {
  if (!arguments.labels.empty() && arguments.mask.empty()) {
    throw InvalidInput("--label: needs --mask, the volume of labels; see " + program_name() +
                       " volume --help");
  }
  if (arguments.mask_layout.type && !is_raw(arguments.mask)) {
    throw InvalidInput(
        "--mask-type: needs a .raw file for --mask; others say their type themselves");
  }
}

VolumeLayout layout_of_volume(const VolumeArguments& arguments) {
  return layout_of(arguments.volume, arguments.mask, arguments.layout);
}

VolumeLayout layout_of_mask(const VolumeArguments& arguments) {
  VolumeLayout layout = layout_of(arguments.mask, arguments.volume, arguments.layout);
  if (arguments.mask_layout.type) {
    layout.type = arguments.mask_layout.type;
    layout.big_endian = arguments.mask_layout.big_endian;
  }
  return layout;
}

VolumeHeader inspect_mask(const VolumeArguments& arguments, const VolumeHeader& volume) {
  VolumeHeader mask = inspect_input(arguments.mask, layout_of_mask(arguments));
  if (has_no_place(arguments.mask) && !has_no_place(arguments.volume) &&
      arguments.layout.spacing.empty() && arguments.layout.origin.empty()) {
    mask.grid.axes = volume.grid.axes.eigen() * mask.grid.axes.eigen();
    mask.grid.origin = volume.grid.origin;
  }
  return mask;
}

AxisOrder order_of_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                        const VolumeHeader& mask) {
  const AxisOrder order = directions(volume.grid, mask.grid);
  const Grid seen = reordered(mask.grid, order);
  if (seen.shape != volume.grid.shape) refuse_shape(arguments, volume.grid, mask.grid);
  if (coincide(volume.grid, seen)) return order;
  const Grid other = turned_round(mask.grid);
  if (coincide(volume.grid, reordered(other, directions(volume.grid, other)))) {
    throw InvalidInput(arguments.mask.string() + ": its cells are where those of " +
                       arguments.volume.string() +
                       " are if x and y run the other way, as in left-posterior-superior and "
                       "right-anterior-superior; both must be in one space");
  }
  throw InvalidInput(arguments.mask.string() + ": its cells are not where those of " +
                     arguments.volume.string() + " are; resample it first");
}

std::vector<std::uint8_t> read_mask(const VolumeArguments& arguments, const VolumeHeader& volume,
                                    const VolumeHeader& mask) {
  const AxisOrder order = order_of_mask(arguments, volume, mask);
  std::vector<std::uint8_t> cells =
      mask_of(arguments, read_volume(arguments.mask, layout_of_mask(arguments)));
  if (!counts(cells)) refuse_mask(arguments);
  return order == kSameOrder ? cells : reordered(cells, mask.grid, order);
}

void check_mask_of_parts(const VolumeArguments& arguments, const VolumeHeader& volume,
                         const VolumeHeader& mask) {
  if (order_of_mask(arguments, volume, mask) == kSameOrder) return;
  throw InvalidInput(
      arguments.mask.string() + ": its axes are stored in another order than those of " +
      arguments.volume.string() +
      " (of two .npy, one is in C order, the other in Fortran order), or from the other end: "
      "several processes need both alike");
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

}  // namespace ccvt::cli
