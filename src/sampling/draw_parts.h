#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "parallel/loops.h"
#include "random.h"
#include "sampling/cell_fill.h"
#include "sampling/density_parts.h"
#include "sampling/mass.h"
#include "sampling/part_walk.h"
#include "streams.h"

namespace ccvt {

/// Draws the points of parts of a density, each with random numbers of its own. What it is given
/// must outlive it.
template <class Scalar>
class DrawParts {
 public:
  DrawParts(const DensityGrid& grid, const Eigen::VectorXd& origin, const CellDensities& densities,
            const DensityParts& parts, std::uint64_t seed, DensitySampling sampling,
            const Arena& arena)
      : grid_(grid),
        origin_(origin),
        densities_(densities),
        parts_(parts),
        seed_(seed),
        stratified_(sampling == DensitySampling::stratified),
        tools_(arena) {}

  /// Points where a part has these masses before them, one behind the other in memory. From several
  /// workers at the same time.
  void operator()(std::size_t part, int worker, std::span<const double> targets, Scalar* out) {
    auto& own = tools_[worker];
    if (!own) {
      own.emplace(Tools{{grid_, densities_, origin_, stratified_},
                        {parts_.curve(), parts_.level(), densities_}});
    }
    Random random(seed_, streams::density_place + part);
    deal_to_cells(
        targets, [&](const auto& visit) { own->walk(parts_[part], visit); },
        [&](std::int64_t place, std::int64_t hits) {
          out = own->fill(own->walk.cell(place), hits, random, out);
        });
  }

 private:
  struct Tools {
    CellFill<Scalar> fill;
    PartWalk walk;
  };

  const DensityGrid& grid_;
  const Eigen::VectorXd& origin_;
  const CellDensities& densities_;
  const DensityParts& parts_;
  std::uint64_t seed_;
  bool stratified_;
  PerWorker<std::optional<Tools>> tools_;
};

}  // namespace ccvt
