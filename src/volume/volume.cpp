#include "ccvt/volume.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "checks.h"
#include "number_text.h"
#include "volume/mask_entries.h"

namespace ccvt {

namespace {

template <class Value>
std::span<const Value> view_as(const std::vector<std::byte>& data) {
  return {reinterpret_cast<const Value*>(data.data()), data.size() / sizeof(Value)};
}

void check_finite(double value, const char* field) {
  if (std::isfinite(value)) return;
  throw InvalidInput(std::string(field) + ": is " + text(value) + "; must be finite");
}

}  // namespace

Grid Grid::spaced(std::vector<std::int64_t> shape, const Coordinates& spacing,
                  const Coordinates& origin) {
  const std::ptrdiff_t dimension = std::ssize(shape);
  if (spacing.size() != dimension || origin.size() != dimension) {
    throw InvalidInput("grid: the shape has " + std::to_string(dimension) +
                       " dimensions, the spacing " + std::to_string(spacing.size()) +
                       " and the origin " + std::to_string(origin.size()) +
                       "; all must be the same");
  }
  for (Eigen::Index d = 0; d < dimension; ++d) {
    if (spacing[d] > 0 && std::isfinite(spacing[d])) continue;
    throw InvalidInput("grid: spacing[" + std::to_string(d) + "] is " + text(spacing[d]) +
                       "; must be positive and finite");
  }
  return {std::move(shape), origin, Eigen::MatrixXd(spacing.eigen().asDiagonal())};
}

double Grid::cell_volume() const { return std::abs(axes.eigen().determinant()); }

DensityGrid Grid::density(GridValues values, Interpolation interpolation) const {
  // In the box, the centres of the cells are at whole numbers.
  Box box{Coordinates::constant(dimension(), -0.5), Coordinates::constant(dimension(), 0)};
  std::transform(shape.begin(), shape.end(), box.upper.data(),
                 [](double cells) { return cells - 0.5; });
  DensityGrid result{values, shape, std::move(box)};
  result.interpolation = interpolation;
  result.to_world = Affine{axes, origin};
  return result;
}

void ValueMap::validate() const {
  require_enumerator("kind", kind, Kind::gamma);
  check_finite(low, "low");
  check_finite(high, "high");
  if (kind == Kind::window && !(low < high)) {
    throw InvalidInput("low: is " + text(low) + " and high is " + text(high) +
                       "; low must be less than high");
  }
  if (kind == Kind::window && !std::isfinite(high - low)) {
    throw InvalidInput("high: is too far from low, " + text(low));
  }
  if (!(gamma > 0 && std::isfinite(gamma))) {
    throw InvalidInput("gamma: is " + text(gamma) + "; must be positive and finite");
  }
}

double ValueMap::operator()(double value, double greatest) const {
  switch (kind) {
    case Kind::linear:
      return invert ? greatest - value : value;
    case Kind::window: {
      // A NaN stays one, and is refused as a density.
      const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
      return invert ? 1 - share : share;
    }
    case Kind::threshold:
      if (std::isnan(value)) return value;
      return (value >= low) != invert ? 1 : 0;
    case Kind::gamma: {
      const double inverted = invert ? greatest - value : value;
      // A negative value stays one, and is refused as a density.
      return inverted < 0 ? inverted : std::pow(inverted / greatest, gamma);
    }
  }
  require_enumerator("kind", kind, Kind::gamma);  // which throws: all have returned
  return value;
}

std::size_t bytes_of(VoxelType type) {
  require_enumerator("type", type, VoxelType::float64);
  switch (type) {
    case VoxelType::int8:
    case VoxelType::uint8:
      return 1;
    case VoxelType::int16:
    case VoxelType::uint16:
      return 2;
    case VoxelType::int32:
    case VoxelType::uint32:
    case VoxelType::float32:
      return 4;
    case VoxelType::int64:
    case VoxelType::uint64:
    case VoxelType::float64:
      return 8;
  }
  return 0;
}

const char* to_string(VoxelType type) {
  require_enumerator("type", type, VoxelType::float64);
  constexpr std::array<const char*, 10> names = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                                 "uint32", "int64", "uint64", "float32", "float64"};
  return names[static_cast<std::size_t>(type)];
}

std::uint64_t VolumeHeader::cells() const {
  return std::accumulate(grid.shape.begin(), grid.shape.end(), std::uint64_t{1},
                         std::multiplies<std::uint64_t>());
}

GridValues Volume::stored() const& {
  require_enumerator("Volume::type", type, VoxelType::float64);
  switch (type) {
    case VoxelType::int8:
      return view_as<std::int8_t>(data);
    case VoxelType::uint8:
      return view_as<std::uint8_t>(data);
    case VoxelType::int16:
      return view_as<std::int16_t>(data);
    case VoxelType::uint16:
      return view_as<std::uint16_t>(data);
    case VoxelType::int32:
      return view_as<std::int32_t>(data);
    case VoxelType::uint32:
      return view_as<std::uint32_t>(data);
    case VoxelType::int64:
      return view_as<std::int64_t>(data);
    case VoxelType::uint64:
      return view_as<std::uint64_t>(data);
    case VoxelType::float32:
      return view_as<float>(data);
    case VoxelType::float64:
      return view_as<double>(data);
  }
  return {};
}

double Volume::greatest(std::span<const std::uint8_t> mask) const {
  require_entries(*this, mask);
  if (data.size() != bytes()) {
    throw InvalidInput("volume: has " + std::to_string(data.size()) + " bytes of data for " +
                       std::to_string(cells()) + " cells of " + to_string(type) + "; needs " +
                       std::to_string(bytes()));
  }
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  std::visit(
      [&](const auto& values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (!mask.empty() && mask[i] == 0) continue;
          const auto value = static_cast<double>(values[i]);
          if (!std::isfinite(value)) {
            throw InvalidInput("volume: value " + std::to_string(i) + " is " + text(value) +
                               "; must be finite");
          }
          least = std::min(least, value);
          most = std::max(most, value);
        }
      },
      stored());
  if (most < least) return most;  // there are none
  return std::max(slope * least + intercept, slope * most + intercept);
}

DensityGrid Volume::density(const ValueMap& map, MaskView mask) const& {
  map.validate();
  require_entries(*this, mask);
  return density(map, map.needs_greatest() ? greatest(mask) : 0, mask);
}

DensityGrid Volume::density(const ValueMap& map, double greatest, MaskView mask) const& {
  map.validate();
  require_entries(*this, mask);
  DensityGrid result = grid.density(stored());
  result.mask = mask;
  const bool plain = map.kind == ValueMap::Kind::linear && !map.invert;
  if (plain && slope == 1 && intercept == 0) return result;
  if (map.kind == ValueMap::Kind::gamma && !(greatest > 0)) {
    throw InvalidInput("volume: its greatest value is " + text(greatest) +
                       "; must be positive for a gamma");
  }
  result.map = [map, greatest, a = slope, b = intercept](double value) {
    return map(a * value + b, greatest);
  };
  return result;
}

}  // namespace ccvt
