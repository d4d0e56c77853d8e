#include "exact/pricing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/squares.h"
#include "kernels/products.h"

namespace ccvt {
namespace {

/// Points of a block, and sites of a chunk: a block's costs stay in cache.
constexpr Index kBlockPoints = 64;
constexpr Index kChunkSites = 1020;
/// A cell with more points is priced in parts of so many.
constexpr Index kPartPoints = 2048;
static_assert(kChunkSites % kernels::kCostSites == 0);

/// An exponent of two; at most half of double's.
constexpr double kMostScale = 500;

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Choice {
  Index site;
  double cost;  ///< squared distance
  double reduced;
};

/// The cells, in parts.
std::vector<std::pair<Index, std::span<const Index>>> parts_of(
    const Grouping& groups, std::span<const std::uint8_t> wanted) {
  std::vector<std::pair<Index, std::span<const Index>>> parts;
  for (Index s = 0; s < groups.count(); ++s) {
    if (!wanted.empty() && wanted[static_cast<std::size_t>(s)] == 0) continue;
    for (auto rest = groups.of(s); !rest.empty();) {
      const std::size_t size = std::min<std::size_t>(rest.size(), kPartPoints);
      parts.emplace_back(s, rest.first(size));
      rest = rest.subspan(size);
    }
  }
  return parts;
}

}  // namespace

Grouping::Grouping(std::span<const Index> owners, Index sites)
    : order(owners.size()), offset(static_cast<std::size_t>(sites) + 1, 0) {
  for (const Index owner : owners) ++offset[static_cast<std::size_t>(owner) + 1];
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  std::vector<Index> next(offset.begin(), offset.end() - 1);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    order[static_cast<std::size_t>(next[static_cast<std::size_t>(owners[p])]++)] =
        static_cast<Index>(p);
  }
}

/// What is asked of a pricing.
template <class Scalar>
struct Pricer<Scalar>::Task {
  WeightedSites sites;
  double slack = 0;
  int most_offers = 0;
  std::span<const std::uint8_t> inside;  ///< not empty: only sites outside are looked at
  std::vector<Index>* owners = nullptr;  ///< null: they stay

  [[nodiscard]] double weight(Index site) const {
    return sites.weight[static_cast<std::size_t>(site)];
  }
  [[nodiscard]] bool excluded(Index site) const {
    return !inside.empty() && inside[static_cast<std::size_t>(site)] != 0;
  }
};

/// What pricing one cell finds; cells are merged in their order.
template <class Scalar>
struct Pricer<Scalar>::Cell {
  double gap = 0;
  double worst = 0;
  double energy = 0;
  double saved = 0;
  std::int64_t moved = 0;
  std::vector<Offer> offers;
};

template <class Scalar>
struct Pricer<Scalar>::Scratch {
  std::vector<double> squared;   ///< of the distance between the cell's site and each site
  std::vector<Index> near;       ///< the sites that can be cheapest, or within the slack
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
  std::vector<std::vector<Index>> found;  ///< for each point of the block, places in `near`
  std::vector<Choice> choices;
};

template <class Scalar>
Pricer<Scalar>::Pricer(const Metric& metric, PointsView<Scalar> points, const Arena& arena)
    : metric_(metric), points_(points), arena_(arena) {}

/// In parallel; the result is in the order of cells, and within them of points.
template <class Scalar>
auto Pricer<Scalar>::price_cells(const Task& task, const Grouping& groups) const
    -> std::vector<Cell> {
  const auto parts = parts_of(groups, task.inside);
  std::vector<Cell> cells(parts.size());
  std::vector<Scratch> scratch(static_cast<std::size_t>(arena_.threads()));
  arena_.for_ranges(parts.size(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t k = begin; k < end; ++k) {
      arena_.check();
      price_cell(task, parts[k].second, parts[k].first, scratch[static_cast<std::size_t>(worker)],
                 cells[k]);
    }
  });
  return cells;
}

template <class Scalar>
Prices Pricer<Scalar>::price(const WeightedSites& sites, double slack, int most_offers,
                             std::vector<Index>& owners) const {
  const Grouping groups(owners, sites.count());
  const Task task{sites, slack, most_offers, {}, &owners};
  const std::vector<Cell> cells = price_cells(task, groups);
  Prices prices;
  std::size_t offers = 0;
  for (const Cell& cell : cells) offers += cell.offers.size();
  prices.offers.reserve(offers);
  double saved = 0;
  for (const Cell& cell : cells) {
    prices.gap += cell.gap;
    prices.worst = std::max(prices.worst, cell.worst);
    prices.energy += cell.energy;
    saved += cell.saved;
    prices.moved += cell.moved;
    prices.offers.insert(prices.offers.end(), cell.offers.begin(), cell.offers.end());
  }
  prices.cheapest_energy = prices.energy - saved;
  return prices;
}

template <class Scalar>
std::vector<Offer> Pricer<Scalar>::offers_outside(const WeightedSites& sites, double slack,
                                                  std::span<const std::uint8_t> inside,
                                                  const std::vector<Index>& owners) const {
  const Grouping groups(owners, sites.count());
  const Task task{sites, slack, 1, inside, nullptr};
  std::vector<Offer> offers;
  for (const Cell& cell : price_cells(task, groups)) {
    offers.insert(offers.end(), cell.offers.begin(), cell.offers.end());
  }
  return offers;
}

/// Fills `near` and `constant` with the sites that some point within `radius` of `site` may prefer,
/// or have within the slack.
template <class Scalar>
void Pricer<Scalar>::select_sites(const Task& task, Index site, double radius,
                                  Scratch& scratch) const {
  const WeightedSites& sites = task.sites;
  const double* own = sites.at(site);
  const Index count = sites.count();
  scratch.squared.resize(static_cast<std::size_t>(count));
  // What the farthest point pays at most for its cheapest site, and then what others cost at least;
  // a little more and less than that, for the rounding of these terms.
  double ceiling = kNever;
  const auto bounds = [&](Index j) {
    const double squared = scratch.squared[static_cast<std::size_t>(j)];
    const double constant = squared + task.weight(site) - task.weight(j);
    const double reach = 2 * radius * std::sqrt(squared);
    const double rounding =
        1e-14 * (1 + sites.dimension / 64.0) *
            (squared + reach + std::abs(task.weight(site)) + std::abs(task.weight(j))) +
        sites.dimension * std::numeric_limits<double>::min();
    return std::pair(constant - reach - rounding, constant + reach + rounding);
  };
  for (Index j = 0; j < count; ++j) {
    scratch.squared[static_cast<std::size_t>(j)] =
        metric_.periodic() ? metric_.squared_distance(sites.at(j), own)
                           : squared_difference(sites.at(j), own, sites.dimension);
    if (!task.excluded(j)) ceiling = std::min(ceiling, bounds(j).second);
  }
  ceiling += task.slack;
  scratch.near.clear();
  scratch.constant.clear();
  for (Index j = 0; j < count; ++j) {
    if (task.excluded(j) || bounds(j).first > ceiling) continue;
    scratch.near.push_back(j);
    scratch.constant.push_back(scratch.squared[static_cast<std::size_t>(j)] + task.weight(site) -
                               task.weight(j));
  }
}

template <class Scalar>
void Pricer<Scalar>::price_cell(const Task& task, std::span<const Index> members, Index site,
                                Scratch& scratch, Cell& result) const {
  const auto dimension = static_cast<std::size_t>(task.sites.dimension);
  const double* own = task.sites.at(site);
  scratch.x.resize(members.size() * dimension);
  double farthest = 0;
  double* x = scratch.x.data();
  for (const Index p : members) {
    const Scalar* from = points_[p];
    double squared = 0;
    for (std::size_t d = 0; d < dimension; ++d) {
      x[d] = metric_.wrap(static_cast<double>(from[d]) - own[d], static_cast<int>(d));
      squared += x[d] * x[d];
    }
    result.energy += squared;
    farthest = std::max(farthest, squared);
    x += dimension;
  }
  const double radius = std::sqrt(farthest) * (1 + 1e-14 * static_cast<double>(dimension));
  select_sites(task, site, radius, scratch);
  if (scratch.near.size() == 1 && scratch.near[0] == site) return;
  if (metric_.periodic()) {
    std::vector<Index> all(scratch.near.size());
    std::iota(all.begin(), all.end(), 0);
    for (const Index p : members) decide(task, p, site, all, scratch, result);
    return;
  }
  prepare_product(task, site, radius, scratch);
  for (Index first = 0; first < static_cast<Index>(members.size()); first += kBlockPoints) {
    arena_.check();
    price_block(task, members, first, site, scratch, result);
  }
}

/// Sets up float costs for the sites selected: |p - s_j|^2 - w_j less the same for the cell's site
/// is constant_j - x . 2 (s_j - s_i), with x = p - s_i. In units in which no term is large.
template <class Scalar>
void Pricer<Scalar>::prepare_product(const Task& task, Index site, double radius,
                                     Scratch& scratch) const {
  const auto dimension = static_cast<std::size_t>(task.sites.dimension);
  const std::size_t near = scratch.near.size();
  double longest = 0;
  double largest_constant = 0;
  for (std::size_t n = 0; n < near; ++n) {
    longest = std::max(longest, scratch.squared[static_cast<std::size_t>(scratch.near[n])]);
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
  scratch.margin = (task.sites.dimension + 6) *
                   (static_cast<double>(std::numeric_limits<float>::epsilon()) *
                        (2 * radius * std::sqrt(longest) + largest_constant) * squared_scale +
                    static_cast<double>(std::numeric_limits<float>::min()));
}

template <class Scalar>
void Pricer<Scalar>::price_block(const Task& task, std::span<const Index> members, Index first,
                                 Index site, Scratch& scratch, Cell& result) const {
  const int dimension = task.sites.dimension;
  const Index count = std::min(kBlockPoints, static_cast<Index>(members.size()) - first);
  const Index step = kernels::product_points();
  const Index stride = (count + step - 1) / step * step;
  const auto wide = static_cast<std::size_t>(stride);
  scratch.block.resize(wide * static_cast<std::size_t>(dimension));
  const double* x = scratch.x.data() + static_cast<std::ptrdiff_t>(first) * dimension;
  for (Index k = 0; k < count; ++k) {
    float* to = scratch.block.data() + k;
    for (int d = 0; d < dimension; ++d, to += stride) {
      *to = static_cast<float>(*x++ * scratch.scale);
    }
  }
  for (int d = 0; d < dimension; ++d) {
    float* stream = scratch.block.data() + static_cast<std::size_t>(d) * wide;
    std::fill(stream + count, stream + stride, stream[count - 1]);
  }

  const auto near = static_cast<Index>(scratch.near.size());
  const auto padded = static_cast<Index>(scratch.c.size());
  scratch.lowest.assign(wide, std::numeric_limits<float>::max());
  scratch.limit.resize(wide);
  scratch.cost.resize(wide * static_cast<std::size_t>(std::min(padded, kChunkSites)));
  scratch.place.resize(scratch.cost.size());
  scratch.found.resize(kBlockPoints);
  for (auto& list : scratch.found) list.clear();
  const double allowance = task.slack * scratch.scale * scratch.scale + 2 * scratch.margin;
  for (Index begin = 0; begin < near; begin += kChunkSites) {
    const Index rows = std::min(kChunkSites, padded - begin);
    kernels::site_costs(scratch.block.data(), stride, dimension,
                        scratch.v.data() + static_cast<std::ptrdiff_t>(begin) * dimension,
                        scratch.c.data() + begin, rows, scratch.cost.data(), scratch.lowest.data());
    for (std::size_t k = 0; k < wide; ++k) {
      const double limit = static_cast<double>(scratch.lowest[k]) + allowance;
      scratch.limit[k] =
          static_cast<Index>(k) < count
              ? std::nextafter(static_cast<float>(limit), std::numeric_limits<float>::infinity())
              : std::numeric_limits<float>::lowest();
    }
    const Index found =
        kernels::costs_within(scratch.cost.data(), stride, std::min(rows, near - begin),
                              scratch.limit.data(), scratch.place.data());
    for (Index f = 0; f < found; ++f) {
      const Index place = scratch.place[static_cast<std::size_t>(f)];
      scratch.found[static_cast<std::size_t>(place % stride)].push_back(begin + place / stride);
    }
  }
  for (Index k = 0; k < count; ++k) {
    const std::vector<Index>& found = scratch.found[static_cast<std::size_t>(k)];
    if (found.size() == 1 && scratch.near[static_cast<std::size_t>(found[0])] == site) continue;
    decide(task, members[static_cast<std::size_t>(first) + static_cast<std::size_t>(k)], site,
           found, scratch, result);
  }
}

/// Evaluates the sites found for a point, places in `near`, in double.
template <class Scalar>
void Pricer<Scalar>::decide(const Task& task, Index point, Index site, std::span<const Index> found,
                            Scratch& scratch, Cell& result) const {
  const auto choice_of = [&](Index j) {
    const double cost =
        metric_.periodic()
            ? metric_.squared_distance(points_[point], task.sites.at(j))
            : squared_difference(points_[point], task.sites.at(j), task.sites.dimension);
    return Choice{j, cost, cost - task.weight(j)};
  };
  std::vector<Choice>& choices = scratch.choices;
  choices.clear();
  const Choice own = choice_of(site);
  for (const Index n : found) {
    const Index j = scratch.near[static_cast<std::size_t>(n)];
    choices.push_back(j == site ? own : choice_of(j));
  }
  // Ties go round robin, so that points in one place spread over the sites in one place.
  const auto turn = [&](Index j) {
    const auto n = static_cast<std::uint64_t>(task.sites.count());
    return (static_cast<std::uint64_t>(j) + n - static_cast<std::uint64_t>(point) % n) % n;
  };
  const auto less = [&](const Choice& a, const Choice& b) {
    return a.reduced != b.reduced ? a.reduced < b.reduced : turn(a.site) < turn(b.site);
  };
  const Choice cheapest = *std::min_element(choices.begin(), choices.end(), less);
  Choice owner = own;
  const double limit = cheapest.reduced + task.slack;
  if (task.owners != nullptr) {
    if (cheapest.reduced < own.reduced) {
      owner = cheapest;
      result.gap += own.reduced - owner.reduced;
      result.worst = std::max(result.worst, own.reduced - owner.reduced);
      result.saved += own.cost - owner.cost;
      ++result.moved;
      (*task.owners)[static_cast<std::size_t>(point)] = owner.site;
    }
  }
  if (task.most_offers == 0) return;
  std::erase_if(choices,
                [&](const Choice& c) { return c.reduced > limit || c.site == owner.site; });
  if (choices.size() > static_cast<std::size_t>(task.most_offers)) {
    std::nth_element(choices.begin(), choices.begin() + task.most_offers, choices.end(), less);
    choices.resize(static_cast<std::size_t>(task.most_offers));
  }
  for (const Choice& c : choices) {
    result.offers.push_back({point, owner.site, c.site, c.cost - owner.cost});
  }
}

template class Pricer<float>;
template class Pricer<double>;

}  // namespace ccvt
