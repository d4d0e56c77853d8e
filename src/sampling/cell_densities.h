#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "ccvt/density.h"

namespace ccvt {

/// The densities of a grid's cells: its values, mapped and masked. Must not outlive the grid.
class CellDensities {
 public:
  explicit CellDensities(const DensityGrid& grid) : grid_(grid) { tabulate(); }

  [[nodiscard]] double operator()(std::int64_t cell) const {
    const auto i = static_cast<std::size_t>(cell);
    if (!grid_.mask.empty() && grid_.mask[i] == 0) return 0;
    return std::visit([&](const auto& values) { return density(values[i]); }, grid_.values);
  }

  /// Calls visit(cell, density) for adjacent cells.
  template <class Visit>
  void visit_row(std::int64_t first, std::int64_t count, const Visit& visit) const {
    std::visit(
        [&](const auto& values) {
          for (std::int64_t cell = first; cell < first + count; ++cell) {
            const auto i = static_cast<std::size_t>(cell);
            const bool masked = !grid_.mask.empty() && grid_.mask[i] == 0;
            visit(cell, masked ? 0.0 : density(values[i]));
          }
        },
        grid_.values);
  }

  /// The value of a cell as it is stored.
  [[nodiscard]] double value(std::int64_t cell) const {
    return std::visit(
        [&](const auto& values) {
          return static_cast<double>(values[static_cast<std::size_t>(cell)]);
        },
        grid_.values);
  }

 private:
  template <class Value>
  static constexpr bool is_small = std::is_integral_v<Value> && sizeof(Value) <= 2;

  template <class Value>
  [[nodiscard]] double density(Value value) const {
    if constexpr (is_small<Value>) {
      if (!table_.empty()) return table_[static_cast<std::make_unsigned_t<Value>>(value)];
    }
    return grid_.map ? grid_.map(static_cast<double>(value)) : static_cast<double>(value);
  }

  // Of small types every number is mapped once, unless there are fewer cells than numbers.
  void tabulate() {
    if (!grid_.map) return;
    std::visit(
        [&]<class Value>(const std::span<const Value>& values) {
          if constexpr (is_small<Value>) {
            constexpr std::size_t numbers = std::size_t{1} << (8 * sizeof(Value));
            if (values.size() < numbers) return;
            table_.resize(numbers);
            for (std::size_t i = 0; i < numbers; ++i) {
              table_[i] = grid_.map(static_cast<double>(static_cast<Value>(i)));
            }
          }
        },
        grid_.values);
  }

  const DensityGrid& grid_;
  std::vector<double> table_;
};

}  // namespace ccvt
