#include "exact/pricing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "exact/packs.h"
#include "geometry/squares.h"
#include "kernels/nearest.h"
#include "kernels/products.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// Points of a block, and sites of a chunk: a block's costs stay in cache.
constexpr std::size_t kBlockPoints = 64;
constexpr Index kChunkSites = 1020;
/// A cell with more points is priced in parts of so many.
constexpr std::size_t kPartPoints = 2048;
static_assert(kChunkSites % kernels::kCostSites == 0);

/// An exponent of two; at most half of double's.
constexpr double kMostScale = 500;

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Choice {
  SiteNumber site;
  double cost;  ///< squared distance
  double reduced;
};

/// A cell, or a part of one.
struct Part {
  SiteNumber site;
  std::span<const PointNumber> members;
};

/// The cells, in parts.
std::vector<Part> parts_of(const Grouping& groups) {
  std::vector<Part> parts;
  for (const SiteNumber s : sites_below(groups.count())) {
    for (auto rest = groups.of(s); !rest.empty();) {
      const std::size_t size = std::min(rest.size(), kPartPoints);
      parts.push_back({s, rest.first(size)});
      rest = rest.subspan(size);
    }
  }
  return parts;
}

}  // namespace

/// What is asked of a pricing.
template <class Scalar>
struct Pricer<Scalar>::Task {
  WeightedSites sites;
  std::vector<Index>& owners;
  std::vector<double> packs;  ///< the sites' positions, for the kernels

  [[nodiscard]] double weight(SiteNumber site) const { return sites.weight[site]; }
};

/// What pricing one cell finds; cells are merged in their order.
template <class Scalar>
struct Pricer<Scalar>::Cell {
  double gap = 0;
  double worst = 0;
  double energy = 0;
  double saved = 0;
  std::int64_t moved = 0;
};

template <class Scalar>
struct Pricer<Scalar>::Scratch {
  std::vector<double> squared;   ///< of the distance between the cell's site and each site
  std::vector<double> least;     ///< of each site, what it costs the cell's points at least
  std::vector<SiteNumber> near;  ///< the sites that can be cheapest
  std::vector<double> constant;  ///< of each: L^2 + w_i - w_j
  std::vector<double> x;         ///< the cell's points relative to its site, one after the other
  double scale = 1;              ///< brings the cell into the range of float
  double margin = 0;             ///< bounds the error of scaled costs
  std::vector<float> v;          ///< of each: 2 (s_j - s_i), scaled, padded to whole tiles
  std::vector<float> c;          ///< constant, scaled, padded
  std::vector<float> block;
  std::vector<float> cost;
  std::vector<float> lowest;
  std::vector<float> limit;
  std::vector<Index> place;
  std::vector<std::vector<SiteNumber>> found;  ///< for each point of the block, those of `near`
};

template <class Scalar>
Pricer<Scalar>::Pricer(const Metric& metric, PointsView<Scalar> points, const Arena& arena)
    : metric_(metric), points_(points), arena_(arena) {}

/// In parallel; the result is in the order of cells, and within them of points.
template <class Scalar>
auto Pricer<Scalar>::price_cells(const Task& task, const Grouping& groups) const
    -> std::vector<Cell> {
  const auto parts = parts_of(groups);
  std::vector<Cell> cells(parts.size());
  PerWorker<Scratch> scratch(arena_);
  arena_.for_ranges(parts.size(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t k = begin; k < end; ++k) {
      arena_.check();
      price_cell(task, parts[k].members, parts[k].site, scratch[worker], cells[k]);
    }
  });
  return cells;
}

template <class Scalar>
Prices Pricer<Scalar>::price(const WeightedSites& sites, std::vector<Index>& owners) const {
  const Grouping groups(owners, sites.count());
  const Task task{sites, owners, packs_of(sites.position, sites.dimension)};
  const std::vector<Cell> cells = price_cells(task, groups);
  Prices prices;
  double saved = 0;
  for (const Cell& cell : cells) {
    prices.gap += cell.gap;
    prices.worst = std::max(prices.worst, cell.worst);
    prices.energy += cell.energy;
    saved += cell.saved;
    prices.moved += cell.moved;
  }
  prices.cheapest_energy = prices.energy - saved;
  return prices;
}

template <class Scalar>
std::vector<Index> Pricer<Scalar>::cheapest(const WeightedSites& sites) const {
  std::vector<Index> owners(static_cast<std::size_t>(points_.count), 0);
  price(sites, owners);
  return owners;
}

/// Fills `near` and `constant` with the sites that some point within `radius` of `site` may prefer.
template <class Scalar>
void Pricer<Scalar>::select_sites(const Task& task, SiteNumber site, double radius,
                                  Scratch& scratch) const {
  const WeightedSites& sites = task.sites;
  const int dimension = points_.dimension;
  scratch.squared.resize(task.packs.size() / sites.dimension);
  scratch.least.resize(sites.count());
  kernels::squared_distances(sites.at(site), task.packs.data(),
                             static_cast<Index>(scratch.squared.size()) / kernels::kPack, dimension,
                             metric_.periodic() ? metric_.extent() : nullptr,
                             scratch.squared.data());
  // What the farthest point pays at most for its cheapest site, and what others cost at least; a
  // little more and less than that, for the rounding of these terms.
  const double relative = 1e-14 * (1 + dimension / 64.0);
  const double underflow = dimension * std::numeric_limits<double>::min();
  const double own_weight = task.weight(site);
  double ceiling = kNever;
  for (const SiteNumber j : sites_below(sites.count())) {
    const double squared = scratch.squared[j];
    const double constant = squared + own_weight - task.weight(j);
    const double reach = 2 * radius * std::sqrt(squared);
    const double rounding =
        relative * (squared + reach + std::abs(own_weight) + std::abs(task.weight(j))) + underflow;
    scratch.least[j] = constant - reach - rounding;
    ceiling = std::min(ceiling, constant + reach + rounding);
  }
  scratch.near.clear();
  scratch.constant.clear();
  for (const SiteNumber j : sites_below(sites.count())) {
    if (scratch.least[j] > ceiling) continue;
    scratch.near.push_back(j);
    scratch.constant.push_back(scratch.squared[j] + own_weight - task.weight(j));
  }
}

template <class Scalar>
void Pricer<Scalar>::price_cell(const Task& task, std::span<const PointNumber> members,
                                SiteNumber site, Scratch& scratch, Cell& result) const {
  const std::size_t dimension = task.sites.dimension;
  const double* own = task.sites.at(site);
  scratch.x.resize(members.size() * dimension);
  double farthest = 0;
  double* x = scratch.x.data();
  for (const PointNumber p : members) {
    const Scalar* from = points_[p.index()];
    double squared = 0;
    for (std::size_t d = 0; d < dimension; ++d) {
      x[d] = metric_.wrap(from[d] - own[d], d);
      squared += x[d] * x[d];
    }
    result.energy += squared;
    farthest = std::max(farthest, squared);
    x += dimension;
  }
  const double radius = std::sqrt(farthest) * (1 + 1e-14 * points_.dimension);
  select_sites(task, site, radius, scratch);
  if (scratch.near.size() == 1 && scratch.near[0] == site) return;
  if (metric_.periodic()) {
    for (const PointNumber p : members) decide(task, p, site, scratch.near, result);
    return;
  }
  prepare_product(task, site, radius, scratch);
  for (std::size_t first = 0; first < members.size(); first += kBlockPoints) {
    arena_.check();
    const std::size_t count = std::min(kBlockPoints, members.size() - first);
    price_block(task, members.subspan(first, count), scratch.x.data() + first * dimension, site,
                scratch, result);
  }
}

/// Sets up float costs for the sites selected: |p - s_j|^2 - w_j less the same for the cell's site
/// is constant_j - x . 2 (s_j - s_i), with x = p - s_i. In units in which no term is large.
template <class Scalar>
void Pricer<Scalar>::prepare_product(const Task& task, SiteNumber site, double radius,
                                     Scratch& scratch) const {
  const std::size_t dimension = task.sites.dimension;
  const std::size_t near = scratch.near.size();
  double longest = 0;
  double largest_constant = 0;
  for (std::size_t n = 0; n < near; ++n) {
    longest = std::max(longest, scratch.squared[scratch.near[n]]);
    largest_constant = std::max(largest_constant, std::abs(scratch.constant[n]));
  }
  const double largest = std::max({radius * radius, longest, largest_constant});
  // No more than what still has a square.
  scratch.scale =
      largest > 0 ? std::exp2(std::min(kMostScale, -std::ceil(std::log2(largest) / 2))) : 1;
  const double squared_scale = scratch.scale * scratch.scale;
  const std::size_t tile = kernels::kCostSites;
  const std::size_t padded = (near + tile - 1) / tile * tile;
  scratch.v.resize(padded * dimension);
  scratch.c.resize(padded);
  float* v = scratch.v.data();
  const double* own = task.sites.at(site);
  for (std::size_t n = 0; n < padded; ++n) {
    const double* other = task.sites.at(scratch.near[std::min(n, near - 1)]);
    for (std::size_t d = 0; d < dimension; ++d) {
      *v++ = static_cast<float>(2 * scratch.scale * (other[d] - own[d]));
    }
    scratch.c[n] = n < near ? static_cast<float>(scratch.constant[n] * squared_scale)
                            : std::numeric_limits<float>::max();
  }
  // Rounding of x, v and the constant, and of a sum of dimension + 1 terms; and underflow, of v
  // times an x of at most 1.
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  constexpr double kLeast = std::numeric_limits<float>::min();
  scratch.margin =
      (points_.dimension + 6) *
      (kEpsilon * (2 * radius * std::sqrt(longest) + largest_constant) * squared_scale + kLeast);
}

/// `x`: the members relative to the cell's site, one after the other.
template <class Scalar>
void Pricer<Scalar>::price_block(const Task& task, std::span<const PointNumber> members,
                                 const double* x, SiteNumber site, Scratch& scratch,
                                 Cell& result) const {
  const std::ptrdiff_t dimension = points_.dimension;
  const auto count = static_cast<Index>(members.size());
  const Index step = kernels::product_points();
  const Index stride = (count + step - 1) / step * step;
  const auto wide = static_cast<std::size_t>(stride);
  scratch.block.resize(wide * task.sites.dimension);
  for (Index k = 0; k < count; ++k) {
    float* to = scratch.block.data() + k;
    for (std::ptrdiff_t d = 0; d < dimension; ++d, to += stride) {
      *to = static_cast<float>(*x++ * scratch.scale);
    }
  }
  float* stream = scratch.block.data();
  for (std::ptrdiff_t d = 0; d < dimension; ++d, stream += stride) {
    std::fill(stream + count, stream + stride, stream[count - 1]);
  }

  const auto near = static_cast<Index>(scratch.near.size());
  const auto padded = static_cast<Index>(scratch.c.size());
  scratch.lowest.assign(wide, std::numeric_limits<float>::max());
  scratch.limit.assign(wide, std::numeric_limits<float>::lowest());
  scratch.cost.resize(wide * static_cast<std::size_t>(std::min(padded, kChunkSites)));
  scratch.place.resize(scratch.cost.size());
  scratch.found.resize(kBlockPoints);
  for (auto& list : scratch.found) list.clear();
  const double allowance = 2 * scratch.margin;
  for (Index begin = 0; begin < near; begin += kChunkSites) {
    const Index rows = std::min(kChunkSites, padded - begin);
    kernels::site_costs(scratch.block.data(), stride, points_.dimension,
                        scratch.v.data() + begin * dimension, scratch.c.data() + begin, rows,
                        scratch.cost.data(), scratch.lowest.data());
    for (std::size_t k = 0; k < members.size(); ++k) {
      const double limit = scratch.lowest[k] + allowance;
      scratch.limit[k] =
          std::nextafter(static_cast<float>(limit), std::numeric_limits<float>::infinity());
    }
    const Index found =
        kernels::costs_within(scratch.cost.data(), stride, std::min(rows, near - begin),
                              scratch.limit.data(), scratch.place.data());
    const SiteNumber* chunk = scratch.near.data() + begin;
    const Index* place = scratch.place.data();
    for (const Index* const end = place + found; place < end; ++place) {
      scratch.found.data()[*place % stride].push_back(chunk[*place / stride]);
    }
  }
  for (std::size_t k = 0; k < members.size(); ++k) {
    const std::vector<SiteNumber>& found = scratch.found[k];
    if (found.size() == 1 && found[0] == site) continue;
    decide(task, members[k], site, found, result);
  }
}

/// Evaluates the sites found for a point in double.
template <class Scalar>
void Pricer<Scalar>::decide(const Task& task, PointNumber point, SiteNumber site,
                            std::span<const SiteNumber> found, Cell& result) const {
  const Scalar* x = points_[point.index()];
  const auto choice_of = [&](SiteNumber j) {
    const double cost = metric_.periodic()
                            ? metric_.squared_distance(x, task.sites.at(j))
                            : squared_difference(x, task.sites.at(j), points_.dimension);
    return Choice{j, cost, cost - task.weight(j)};
  };
  // Ties go round robin, so that points in one place spread over the sites in one place.
  const auto turn = [&](SiteNumber j) {
    const std::size_t n = task.sites.count();
    return (j + n - point % n) % n;
  };
  const Choice own = choice_of(site);
  Choice cheapest{site, own.cost, kNever};
  for (const SiteNumber j : found) {
    const Choice choice = j == site ? own : choice_of(j);
    if (choice.reduced < cheapest.reduced ||
        (choice.reduced == cheapest.reduced && turn(j) < turn(cheapest.site))) {
      cheapest = choice;
    }
  }
  if (!(cheapest.reduced < own.reduced)) return;
  result.gap += own.reduced - cheapest.reduced;
  result.worst = std::max(result.worst, own.reduced - cheapest.reduced);
  result.saved += own.cost - cheapest.cost;
  ++result.moved;
  task.owners[point] = cheapest.site.index();
}

template class Pricer<float>;
template class Pricer<double>;

}  // namespace ccvt
