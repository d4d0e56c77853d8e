#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "ccvt/density.h"

namespace ccvt {

/// The densities of a grid's cells: its values, mapped and masked. Must not outlive the grid.
class CellDensities {
 public:
  /// `first`: the cell whose value is the grid's first one; those before it are not here.
  explicit CellDensities(const DensityGrid& grid, std::int64_t first = 0)
      : grid_(grid), first_(first) {
    tabulate();
  }

  [[nodiscard]] double operator()(std::int64_t cell) const {
    cell -= first_;
    if (!grid_.mask.empty() && grid_.mask.data()[cell] == 0) return 0;
    return std::visit([&](const auto& values) { return density(values.data()[cell]); },
                      grid_.values);
  }

  /// The densities of as many adjacent cells as `out` has room for.
  void row(std::int64_t first, std::span<double> out) const {
    const std::int64_t begin = first - first_;
    std::visit(
        [&](const auto& values) {
          const auto* const from = values.data() + begin;
          if (!grid_.mask.empty()) {
            const auto* const mask = grid_.mask.data() + begin;
            for (std::size_t k = 0; k < out.size(); ++k) {
              out[k] = mask[k] == 0 ? 0.0 : density(from[k]);
            }
          } else if (grid_.map) {
            for (std::size_t k = 0; k < out.size(); ++k) out[k] = density(from[k]);
          } else {
            for (std::size_t k = 0; k < out.size(); ++k) out[k] = static_cast<double>(from[k]);
          }
        },
        grid_.values);
  }

  /// The value of a cell as it is stored.
  [[nodiscard]] double value(std::int64_t cell) const {
    return std::visit(
        [&](const auto& values) { return static_cast<double>(values.data()[cell - first_]); },
        grid_.values);
  }

 private:
  template <class Value>
  static constexpr bool is_small = std::is_integral_v<Value> && sizeof(Value) <= 2;

  template <class Value>
  [[nodiscard]] double density(Value value) const {
    if constexpr (is_small<Value>) {
      if (!table_.empty()) return table_.data()[value - std::numeric_limits<Value>::min()];
    }
    const auto number = static_cast<double>(value);
    return grid_.map ? grid_.map(number) : number;
  }

  // Of small types every number is mapped once, from the least to the greatest, unless there are
  // fewer cells than numbers.
  void tabulate() {
    if (!grid_.map) return;
    std::visit(
        [&]<class Value>(const std::span<const Value>& values) {
          if constexpr (is_small<Value>) {
            constexpr std::size_t numbers = std::size_t{1} << (8 * sizeof(Value));
            if (values.size() < numbers) return;
            table_.reserve(numbers);
            using Limits = std::numeric_limits<Value>;
            for (double x = Limits::min(); x <= Limits::max(); ++x) table_.push_back(grid_.map(x));
          }
        },
        grid_.values);
  }

  const DensityGrid& grid_;
  std::int64_t first_;
  std::vector<double> table_;
};

}  // namespace ccvt
