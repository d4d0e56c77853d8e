#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "exact/cell_bounds.h"
#include "exact/cell_product.h"
#include "exact/packs.h"
#include "exact/price_sums.h"
#include "exact/pricing.h"
#include "exact/rivals.h"
#include "exact/site_groups.h"

/// What Pricer's functions hand each other.
namespace ccvt {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// What is asked of a pricing.
template <class Scalar>
struct Pricer<Scalar>::Task {
  WeightedSites sites;
  std::vector<Index>& owners;
  CellBounds* kept = nullptr;
  bool covered = false;  ///< by the bounds kept
  /// No point has an owner yet: those of its part's group are looked at, or all without groups.
  bool first = false;
  Ties ties = Ties::in_turn;
  const SiteGroups* groups = nullptr;  ///< where cells are taken together
  std::vector<double> packs = {};      ///< the sites' positions, for the kernels
  std::vector<double> rows = {};       ///< bounds of the parts of cells that have several

  [[nodiscard]] double weight(SiteNumber site) const { return sites.weight[site]; }
};

/// A cell, cells near each other, or a part of these.
template <class Scalar>
struct Pricer<Scalar>::Part {
  SiteNumber site;       ///< of the cell; none where there are several
  const double* centre;  ///< the site's position, or about where the cells' are
  double weight;         ///< the site's, or 0
  std::span<const PointNumber> members;
  std::size_t group = 0;          ///< where there are several
  std::span<double> bounds = {};  ///< those of CellBounds, if any are kept
  double radius = 0;              ///< around the centre
};

template <class Scalar>
struct Pricer<Scalar>::Scratch {
  PackedDistances distances;
  std::vector<double> least;  ///< of each site, what it costs the cell's points at least
  std::vector<double> own;    ///< of each point, the squared distance to the centre
  Rivals rivals;              ///< where cells are taken together
  std::vector<SiteNumber> near;
  CellProduct product;
  PriceSums sums;
};

}  // namespace ccvt
