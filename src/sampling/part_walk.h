#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sampling/cell_densities.h"
#include "sampling/hilbert.h"

namespace ccvt {

/// The orders in which a curve runs through cubes of side 2^level: D 2^D at the most, each of which
/// is found once.
class CubeOrders {
 public:
  /// Places in a cube of 2^16 cells fit two bytes.
  static constexpr unsigned kMostBits = 16;
  CubeOrders(unsigned dimensions, int level)
      : cube_(std::vector<std::int64_t>(dimensions, std::int64_t{1} << level)), level_(level) {}

  /// The places, in the order of memory, of a part's cells along the curve.
  [[nodiscard]] std::span<const std::uint16_t> of(const HilbertCurve::Part& part) {
    std::vector<std::uint16_t>& order = orders_[{part.entry, part.direction}];
    if (order.empty()) {
      cube_.visit({0, part.entry, part.direction}, level_,
                  [&](std::int64_t place) { order.push_back(static_cast<std::uint16_t>(place)); });
    }
    return order;
  }

 private:
  HilbertCurve cube_;
  int level_;
  std::map<std::pair<std::uint64_t, unsigned>, std::vector<std::uint16_t>> orders_;
};

/// Walks through parts of a curve with the densities of their cells. These are fetched in the order
/// of memory: along the curve, fetching them and finding the way take twice as long. One per
/// thread.
class PartWalk {
 public:
  PartWalk(const HilbertCurve& curve, int level, const CellDensities& densities)
      : curve_(curve), level_(curve.limited(level)), densities_(densities) {
    const unsigned dimensions = curve_.dimensions();
    const unsigned bits = static_cast<unsigned>(level_) * dimensions;
    if (bits == 0 || bits > CubeOrders::kMostBits || dimensions > kMostDimensions) return;
    orders_.emplace(dimensions, level_);
    fetched_.resize(std::size_t{1} << bits);
  }

  /// Calls visit(place, density) for the cells of a part along the curve, and perhaps for places of
  /// density 0 that are in no cell.
  template <class Visit>
  void operator()(const HilbertCurve::Part& part, const Visit& visit) {
    const auto cells = static_cast<std::size_t>(curve_.cells(part, level_));
    part_ = part;
    by_order_ = orders_ && 2 * cells >= fetched_.size();
    if (!by_order_) {
      return curve_.visit(part, level_, [&](std::int64_t cell) { visit(cell, densities_(cell)); });
    }
    if (cells < fetched_.size()) std::fill(fetched_.begin(), fetched_.end(), 0.0);
    curve_.visit_rows(
        part, level_, [&](std::int64_t first, std::int64_t count, std::int64_t place) {
          densities_.row(first, std::span(fetched_).subspan(static_cast<std::size_t>(place),
                                                            static_cast<std::size_t>(count)));
        });
    for (const std::uint16_t place : orders_->of(part)) {
      visit(std::int64_t{place}, fetched_.data()[place]);
    }
  }

  /// The cell of a place that was visited last.
  [[nodiscard]] std::int64_t cell(std::int64_t place) const {
    return by_order_ ? curve_.cell(part_, level_, place) : place;
  }

 private:
  /// Orders take .3 MB in 5 dimensions (160 of 1024 cells), 3 MB in 6 (384 of 4096).
  static constexpr unsigned kMostDimensions = 5;

  HilbertCurve curve_;
  int level_;
  const CellDensities& densities_;
  std::optional<CubeOrders> orders_;  ///< where there are few
  std::vector<double> fetched_;       ///< densities of a cube, in the order of memory
  HilbertCurve::Part part_{};
  bool by_order_ = false;
};

}  // namespace ccvt
