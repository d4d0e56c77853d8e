#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/particles.h"

namespace ccvt::io {

/// The particles of a load, in their order, made where they are asked for.
class ParticleLoad {
 public:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;  ///< particles written at a time

  /// Throws InvalidInput unless the sites are in the unit cube.
  template <class Scalar>
  ParticleLoad(PointsView<Scalar> sites, const ParticleOptions& options);

  [[nodiscard]] const ParticleOptions& options() const { return options_; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mass() const { return mass_; }
  /// box_size / count^(1/3).
  [[nodiscard]] double spacing() const;
  /// Their type, as an index.
  [[nodiscard]] std::size_t type() const { return static_cast<std::size_t>(options_.type); }
  /// Header fields that hold a number for each of six types, here `value` for that of the load.
  template <class Number>
  [[nodiscard]] std::array<Number, 6> by_type(Number value) const {
    std::array<Number, 6> numbers{};
    numbers.at(type()) = value;
    return numbers;
  }

  /// x, y, z of the particles from `first` on, as many as there is room for.
  template <class Real>
  void positions(std::uint64_t first, std::span<Real> xyz) const {
    const std::uint64_t sites = unit_.size() / 3;
    std::uint64_t tile = first / sites;
    std::size_t coordinate = 3 * (first % sites);
    auto corner = corner_of(tile);
    for (std::size_t i = 0; i < xyz.size(); ++i) {
      if (coordinate == unit_.size()) {
        coordinate = 0;
        corner = corner_of(++tile);
      }
      const auto x = static_cast<Real>((unit_[coordinate] + corner[i % 3]) * side_);
      xyz[i] = x < options_.box_size ? x : Real{0};
      ++coordinate;
    }
  }

  /// Throws Cancelled if the caller wants it.
  void check() const {
    if (options_.cancelled && options_.cancelled()) throw Cancelled();
  }

 private:
  [[nodiscard]] std::array<double, 3> corner_of(std::uint64_t tile) const;

  std::vector<double> unit_;  ///< coordinates of the sites, in [0, 1]
  ParticleOptions options_;
  std::uint64_t count_ = 0;
  double mass_ = 0;
  double side_ = 0;  ///< of a tile
};

/// Calls write(first, number) for all particles, a block at a time.
template <class Write>
void for_blocks(const ParticleLoad& load, const Write& write) {
  for (std::uint64_t first = 0; first < load.count(); first += ParticleLoad::kBlock) {
    load.check();
    const std::uint64_t left = load.count() - first;
    write(first,
          left < ParticleLoad::kBlock ? static_cast<std::size_t>(left) : ParticleLoad::kBlock);
  }
}

}  // namespace ccvt::io
