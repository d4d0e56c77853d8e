#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/ranks.h"
#include "parallel/arena.h"
#include "sampling/cell_densities.h"
#include "sampling/hilbert.h"

namespace ccvt {

/// The layers of a grid, see LayerRange, and which of several ranks has which. Those of a rank hold
/// whole parts of the curve.
struct GridLayers {
  GridLayers(std::span<const std::int64_t> shape, int level);

  /// The layers whose parts are a rank's, and the rank of a layer.
  [[nodiscard]] LayerRange of(int rank, int ranks) const;
  [[nodiscard]] int rank_of(std::int64_t layer, int ranks) const;
  /// Those, and one to either side.
  [[nodiscard]] LayerRange around(int rank, int ranks) const;

  std::int64_t count = 1;
  std::int64_t cells = 1;      ///< of one
  std::int64_t thickness = 1;  ///< of a part, in layers
  [[nodiscard]] std::int64_t thick() const { return (count + thickness - 1) / thickness; }
};

/// The level of the parts that a grid's curve is cut into.
int level_of_parts(std::span<const std::int64_t> shape);

/// The curve through the cells of a grid, cut into parts that are worked on by themselves. Where
/// several ranks work, each has those in its layers.
class DensityParts {
 public:
  /// All parts are here.
  explicit DensityParts(std::span<const std::int64_t> shape);
  DensityParts(std::span<const std::int64_t> shape, const Ranks& ranks);

  [[nodiscard]] const HilbertCurve& curve() const { return curve_; }
  [[nodiscard]] int level() const { return level_; }
  [[nodiscard]] const HilbertCurve::Part& operator[](std::size_t part) const {
    return parts_[part];
  }
  [[nodiscard]] std::size_t size() const { return parts_.size(); }
  /// Those that are here, ascending.
  [[nodiscard]] std::span<const std::size_t> own() const { return own_; }

  /// The mass of each part of a density, of which all ranks (null: this one) have those of their
  /// own. Throws InvalidInput, on all ranks, for values that sample_density() refuses.
  [[nodiscard]] std::vector<double> masses(const DensityGrid& grid, const CellDensities& densities,
                                           const Arena& arena, Ranks* ranks) const;

 private:
  [[nodiscard]] int rank_of(std::size_t part, int ranks) const {
    return layers_.rank_of(parts_[part].index / layers_.cells, ranks);
  }
  [[nodiscard]] std::vector<double> own_masses(const DensityGrid& grid,
                                               const CellDensities& densities,
                                               const Arena& arena) const;
  [[nodiscard]] std::vector<double> of_all(Ranks& ranks, std::span<const double> own) const;

  HilbertCurve curve_;
  int level_ = 0;
  GridLayers layers_;
  std::vector<HilbertCurve::Part> parts_;
  std::vector<std::size_t> own_;
};

}  // namespace ccvt
