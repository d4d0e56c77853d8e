#include "sampling/density_parts.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include "random.h"
#include "sampling/part_walk.h"

namespace ccvt::test {
namespace {

using Shape = std::vector<std::int64_t>;

const std::vector<Shape> kShapes = {
    {1},          {70},         {100'000},    {5, 3},          {32, 32},          {3, 40, 2},
    {1, 300, 1},  {513, 300},   {9, 10, 11},  {70, 66, 65},    {16, 16, 256},     {17, 18, 19, 20},
    {4, 4, 4, 4}, {2, 300'000}, {300'000, 2}, {9, 8, 9, 8, 9}, {7, 6, 7, 6, 7, 6}};

/// Densities, none of them 0.
std::vector<float> densities_for(const Shape& shape) {
  std::vector<float> values(static_cast<std::size_t>(
      std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>())));
  Random random(3);
  for (float& value : values) value = 1 + static_cast<float>(random.uniform());
  return values;
}

DensityGrid grid_of(const std::vector<float>& values, const Shape& shape) {
  return {.values = std::span<const float>(values),
          .shape = shape,
          .box = Box::unit(static_cast<int>(shape.size()))};
}

}  // namespace

TEST_SUITE_BEGIN("density");

TEST_CASE("a walk meets the cells of a part along the curve, with their densities") {
  for (const Shape& shape : kShapes) {
    CAPTURE(shape.size());
    CAPTURE(shape[0]);
    const std::vector<float> values = densities_for(shape);
    const DensityGrid grid = grid_of(values, shape);
    const CellDensities densities(grid);
    HilbertCurve curve(shape);
    for (int level = 0; level * static_cast<int>(curve.dimensions()) <= 12 && level < 7; ++level) {
      PartWalk walk(curve, level, densities);
      bool same = true;
      const auto parts = curve.parts(level);
      for (std::size_t k = 0; k < parts.size(); k += 1 + parts.size() / 1000) {
        std::vector<std::pair<std::int64_t, double>> along;
        curve.visit(parts[k], level,
                    [&](std::int64_t cell) { along.emplace_back(cell, densities(cell)); });
        std::vector<std::pair<std::int64_t, double>> met;
        walk(parts[k], [&](std::int64_t place, double density) {
          if (density > 0) met.emplace_back(walk.cell(place), density);
        });
        same = same && met == along;
      }
      CHECK_MESSAGE(same, "level " << level);
      if (curve.dimensions() == 0) break;
    }
  }
}

TEST_CASE("the mass of a part is that of its rows, one after the other, to the bit") {
  for (const Shape& shape : kShapes) {
    CAPTURE(shape.size());
    CAPTURE(shape[0]);
    std::vector<float> values = densities_for(shape);
    const DensityGrid grid = grid_of(values, shape);
    const CellDensities densities(grid);
    const DensityParts parts(shape);
    for (const int threads : {1, 2}) {
      const std::vector<double> masses = parts.masses(grid, densities, Arena(threads), nullptr);
      REQUIRE(masses.size() == parts.size());
      bool same = true;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        double mass = 0;
        parts.curve().visit_rows(parts[k], parts.level(),
                                 [&](std::int64_t first, std::int64_t count, std::int64_t) {
                                   double row = 0;
                                   for (std::int64_t i = 0; i < count; ++i) {
                                     row += densities(first + i);
                                   }
                                   mass += row;
                                 });
        same = same && mass == masses[k];
      }
      CHECK(same);
    }
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
