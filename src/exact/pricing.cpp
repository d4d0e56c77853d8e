#include "exact/pricing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "exact/distances.h"
#include "exact/packs.h"
#include "exact/pricing_parts.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// A cell with more points is priced in parts of so many.
constexpr std::size_t kPartPoints = 2048;
/// With so many sites or more, and fewer points each than this, cells near each other are priced
/// together, about so many points at a time: looking at all sites for each cell would take longer
/// than what it saves.
constexpr std::size_t kManySites = 512;
constexpr std::size_t kFewPoints = 64;
constexpr std::size_t kRegionPoints = 512;
/// With fewer sites than this, the products of all points with all sites take no longer than what
/// finds out which are needed.
constexpr std::size_t kManyGroups = 2048;

struct Choice {
  SiteNumber site;
  double cost;  ///< squared distance
  double reduced;
};

}  // namespace

template <class Scalar>
Pricer<Scalar>::Pricer(const Metric& metric, PointsView<Scalar> points, const Arena& arena,
                       const RankPart& part)
    : metric_(metric), points_(points), arena_(arena), part_(part) {}

/// The cells, in parts, as far as it is this rank's turn; but for those of which bounds say that no
/// point costs less elsewhere.
template <class Scalar>
auto Pricer<Scalar>::parts_of(Task& task, const Grouping& groups) const -> std::vector<Part> {
  const std::size_t n = task.sites.count();
  const RankTurns turns(sharing());
  std::vector<std::uint8_t> settled(n, 0);
  if (task.covered) {
    arena_.for_each(n, 16, [&](std::size_t k) {
      const SiteNumber s(k);
      if (turns.own(s)) settled[s] = task.kept->any_near(s, task.sites.weight) ? 0 : 1;
    });
  }
  std::vector<Part> parts;
  // A row of bounds for each part takes 8 bytes a point at most.
  const std::size_t part_points = task.kept == nullptr ? kPartPoints : std::max(kPartPoints, n);
  for (const SiteNumber s : sites_below(n)) {
    if (settled[s] != 0 || !turns.own(s)) continue;
    for (auto rest = groups.of(s); !rest.empty();) {
      const std::size_t size = std::min(rest.size(), part_points);
      parts.push_back({s, task.sites.at(s), task.weight(s), rest.first(size)});
      rest = rest.subspan(size);
    }
  }
  if (task.kept == nullptr) return parts;
  std::vector<Part*> shared;  // by other parts of the same cell
  for (Part& part : parts) {
    part.bounds = task.kept->of(part.site);
    if (part.members.size() < groups.of(part.site).size()) shared.push_back(&part);
  }
  task.rows.resize(shared.size() * n);
  auto rows = std::span(task.rows);
  for (Part* const part : shared) {
    std::copy(part->bounds.begin(), part->bounds.end(), rows.begin());
    part->bounds = rows.first(n);
    rows = rows.subspan(n);
  }
  return parts;
}

/// Parts of so many points at most that have one centre, as far as it is this rank's turn.
template <class Scalar>
auto Pricer<Scalar>::parts_around(std::span<const double> centres, const Grouping& groups) const
    -> std::vector<Part> {
  const std::size_t dimension = centres.size() / groups.count();
  const RankTurns turns(sharing());
  std::size_t number = 0;
  std::vector<Part> parts;
  for (const SiteNumber g : sites_below(groups.count())) {
    for (auto rest = groups.of(g); !rest.empty();) {
      const std::size_t size = std::min(rest.size(), kPartPoints);
      if (turns.own(number++)) {
        parts.push_back({.site = SiteNumber::none(),
                         .centre = centres.data() + g * dimension,
                         .weight = 0.0,
                         .members = rest.first(size),
                         .group = static_cast<std::size_t>(g.index())});
      }
      rest = rest.subspan(size);
    }
  }
  return parts;
}

template <class Scalar>
auto Pricer<Scalar>::price_parts(const Task& task, std::vector<Part>& parts) const -> PriceSums {
  std::vector<Index> given;
  if (sharing() != nullptr) given = task.owners;
  const auto centre = [](const Part& part) { return part.centre; };
  const double* const extent = metric_.periodic() ? metric_.extent() : nullptr;
  PerWorker<Scratch> scratch(arena_);
  arena_.for_ranges(parts.size(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    const auto some = std::span(parts).subspan(begin, end - begin);
    scratch[worker].distances.for_each(some, centre, task.packs, points_.dimension, extent,
                                       [&](Part& part, std::span<const double> apart) {
                                         arena_.check();
                                         price_part(task, part, apart, scratch[worker]);
                                       });
  });
  PriceSums sums;
  for (int worker = 0; worker < arena_.threads(); ++worker) sums.add(scratch[worker].sums);
  if (sharing() != nullptr) share_owners(given, task.owners);
  return sums;
}

/// Each rank has given points of its parts other owners.
template <class Scalar>
void Pricer<Scalar>::share_owners(std::span<const Index> given, std::vector<Index>& owners) const {
  std::vector<Index> found;  // points, each with its owner
  for (const PointNumber p : points_below(owners.size())) {
    if (owners[p] != given[p]) found.insert(found.end(), {p.index(), owners[p]});
  }
  found = joined(sharing(), std::move(found));
  for (std::size_t k = 0; k < found.size(); k += 2) owners[PointNumber(found[k])] = found[k + 1];
}

/// A cell's bounds are the least of its parts'.
template <class Scalar>
void Pricer<Scalar>::keep(CellBounds& kept, const std::vector<Part>& parts) {
  const Part* before = nullptr;
  for (const Part& part : parts) {
    double& radius = kept.radius(part.site);
    const std::span<double> bounds = kept.of(part.site);
    if (before == nullptr || before->site != part.site) {
      radius = part.radius;
      if (bounds.data() != part.bounds.data()) {
        std::copy(part.bounds.begin(), part.bounds.end(), bounds.begin());
      }
    } else {
      std::transform(bounds.begin(), bounds.end(), part.bounds.begin(), bounds.begin(),
                     [](double a, double b) { return std::min(a, b); });
    }
    radius = std::max(radius, part.radius);
    before = &part;
  }
}

/// Of all ranks.
template <class Scalar>
Prices Pricer<Scalar>::total(PriceSums own) const {
  if (Ranks* const ranks = part_.ranks != nullptr ? part_.ranks : sharing(); ranks != nullptr) {
    own.add_ranks(*ranks);
  }
  return {own.gap.value(), own.worst, own.moved, own.energy.value(),
          own.energy.less(own.saved).value()};
}

template <class Scalar>
Prices Pricer<Scalar>::price(const WeightedSites& sites, std::vector<Index>& owners,
                             CellBounds* kept) const {
  if (owners.empty()) return total({});
  const std::size_t n = sites.count();
  const bool few = owners.size() < kFewPoints * n;
  if (kept == nullptr && few && n >= kManySites && !metric_.periodic()) {
    return total(price_together(sites, owners));
  }
  return total(price_cells(sites, owners, kept));
}

/// Cell by cell.
template <class Scalar>
auto Pricer<Scalar>::price_cells(const WeightedSites& sites, std::vector<Index>& owners,
                                 CellBounds* kept) const -> PriceSums {
  const std::size_t n = sites.count();
  const Grouping groups(owners, n, arena_);
  Task task{sites, owners, kept, kept != nullptr && kept->cover(owners)};
  if (!task.covered) task.packs = packs_of(sites.position, sites.dimension);
  std::vector<Index> given;
  if (kept != nullptr) given = owners;
  if (task.covered) {
    kept->follow(sites.position, groups, points_, arena_);
  } else if (kept != nullptr) {
    kept->forget(sites.position);
  }
  std::vector<Part> parts = parts_of(task, groups);
  PriceSums sums = price_parts(task, parts);
  if (kept != nullptr) {
    keep(*kept, parts);
    kept->set_covered(std::move(given));
    for (const SiteNumber s : sites_below(n)) {  // what others have is added by them
      if (kept->has(s)) continue;
      for (const PointNumber p : groups.of(s)) kept->own_costs()[p] = 0;
    }
    sums.energy = exact_sum_of(arena_, std::span<const double>(kept->own_costs()));
  }
  return sums;
}

/// Cells near each other at a time.
template <class Scalar>
auto Pricer<Scalar>::price_together(const WeightedSites& sites, std::vector<Index>& owners) const
    -> PriceSums {
  const std::size_t most = std::max<std::size_t>(1, kRegionPoints * sites.count() / owners.size());
  const SiteGroups groups(sites, most, arena_);
  const std::vector<Index> group = groups.near.groups();
  std::vector<Index> region(owners.size());
  for (std::size_t p = 0; p < region.size(); ++p) region[p] = group[SiteNumber(owners[p])];
  return price_regions({.sites = sites, .owners = owners, .groups = &groups}, region,
                       groups.centres);
}

/// Points by the centre that they are near.
template <class Scalar>
auto Pricer<Scalar>::price_regions(const Task& task, std::span<const Index> region,
                                   std::span<const double> centres) const -> PriceSums {
  const Grouping regions(region, centres.size() / task.sites.dimension, arena_);
  std::vector<Part> parts = parts_around(centres, regions);
  return price_parts(task, parts);
}

template <class Scalar>
std::vector<Index> Pricer<Scalar>::cheapest(const WeightedSites& sites, Ties ties) const {
  const std::size_t n = sites.count();
  std::vector<Index> owners(static_cast<std::size_t>(points_.count));
  if (n >= kManyGroups && !metric_.periodic() && cheapest_by_groups(sites, ties, owners)) {
    return owners;
  }
  const std::vector<double> centre(sites.at(SiteNumber(0)), sites.at(SiteNumber(1)));
  price_regions({.sites = sites,
                 .owners = owners,
                 .first = true,
                 .ties = ties,
                 .packs = packs_of(sites.position, sites.dimension)},
                std::vector<Index>(owners.size(), 0), centre);
  return owners;
}

/// Of the sites near the centre that is nearest; then of those that may be cheaper. False, and
/// nothing is done, where most sites are groups of their own, as where they lie along a line.
template <class Scalar>
bool Pricer<Scalar>::cheapest_by_groups(const WeightedSites& sites, Ties ties,
                                        std::vector<Index>& owners) const {
  const auto most = static_cast<std::size_t>(std::sqrt(static_cast<double>(sites.count())));
  const SiteGroups groups(sites, most, arena_);
  if (2 * groups.count() > sites.count()) return false;
  const std::vector<double> none(groups.count(), 0.0);
  const std::vector<Index> region = cheapest({groups.centres, none}, ties);
  for (const bool first : {true, false}) {
    price_regions(
        {.sites = sites, .owners = owners, .first = first, .ties = ties, .groups = &groups}, region,
        groups.centres);
  }
  return true;
}

/// What a part costs now, and how far it reaches.
template <class Scalar>
void Pricer<Scalar>::survey(const Task& task, Part& part, Scratch& scratch) const {
  std::vector<double>& squared = scratch.own;
  squared_distances(metric_, points_, part.members, part.centre, squared);
  double farthest = 0;
  const bool together = part.site == SiteNumber::none();
  scratch.rivals.clear();
  for (std::size_t k = 0; k < squared.size(); ++k) {
    if (together && !task.first) {
      const SiteNumber owner(task.owners[part.members[k]]);
      const double cost = cost_of(part.members[k], task, owner);
      scratch.sums.energy.add(cost);
      scratch.rivals.add(squared[k], cost, task.weight(owner));
    } else if (!together && task.kept == nullptr) {
      scratch.sums.energy.add(squared[k]);
    }
    farthest = std::max(farthest, squared[k]);
    if (task.kept != nullptr) task.kept->own_costs()[part.members[k]] = squared[k];
  }
  part.radius = std::sqrt(farthest + underflow_of(points_.dimension)) *
                (1 + rounding_share(points_.dimension));
}

/// `apart`: squared distances between the centre and each site, where sites are looked at one by
/// one.
template <class Scalar>
void Pricer<Scalar>::price_part(const Task& task, Part& part, std::span<const double> apart,
                                Scratch& scratch) const {
  const std::span<const PointNumber> members = part.members;
  if (task.covered) {
    part.radius = task.kept->radius(part.site);
    select_known(task, part, scratch);
  } else {
    survey(task, part, scratch);
    if (task.groups != nullptr) {
      select_by_groups(task, part, scratch);
    } else {
      select_sites(task, part, apart, scratch);
    }
  }
  CellProduct& product = scratch.product;
  if (product.near().size() == 1 && product.near()[0] == part.site) return;
  if (metric_.periodic()) {
    for (const PointNumber p : members) decide(task, p, product.near(), scratch.sums);
    return;
  }
  product.prepare(task.sites, part.centre, part.radius);
  for (auto rest = members; !rest.empty();) {
    arena_.check();
    const auto some = rest.first(std::min(CellProduct::kPoints, rest.size()));
    product.multiply(points_, some);
    for (std::size_t k = 0; k < some.size(); ++k) {
      const std::vector<SiteNumber>& found = product.cheapest(k);
      if (!task.first && found.size() == 1 && found[0].index() == task.owners[some[k]]) continue;
      decide(task, some[k], found, scratch.sums);
    }
    rest = rest.subspan(some.size());
  }
  if (!part.bounds.empty()) raise_bounds(task, part, product);
}

template <class Scalar>
double Pricer<Scalar>::cost_of(PointNumber point, const Task& task, SiteNumber site) const {
  const Scalar* const x = points_[point.index()];
  const double* const s = task.sites.at(site);
  return metric_.periodic() ? metric_.squared_distance(x, s)
                            : squared_distance(x, s, points_.dimension);
}

/// Evaluates the sites found for a point in double.
template <class Scalar>
void Pricer<Scalar>::decide(const Task& task, PointNumber point, std::span<const SiteNumber> found,
                            PriceSums& sums) const {
  const auto choice_of = [&](SiteNumber j) {
    const double cost = cost_of(point, task, j);
    return Choice{j, cost, cost - task.weight(j)};
  };
  const auto turn = [&](SiteNumber j) -> std::size_t {
    if (task.ties == Ties::by_place) return j;
    const std::size_t n = task.sites.count();
    return (j + n - (static_cast<std::size_t>(part_.first) + point) % n) % n;
  };
  const SiteNumber owner(task.owners[point]);
  const Choice own = task.first ? Choice{owner, kNever, kNever} : choice_of(owner);
  Choice cheapest{owner, own.cost, kNever};
  for (const SiteNumber j : found) {
    const Choice choice = j == owner && !task.first ? own : choice_of(j);
    if (choice.reduced < cheapest.reduced ||
        (choice.reduced == cheapest.reduced && turn(j) < turn(cheapest.site))) {
      cheapest = choice;
    }
  }
  if (!(cheapest.reduced < own.reduced)) return;
  if (!task.first) {
    sums.gap.add(own.reduced - cheapest.reduced);
    sums.worst = std::max(sums.worst, own.reduced - cheapest.reduced);
    sums.saved.add(own.cost - cheapest.cost);
    ++sums.moved;
  }
  task.owners[point] = cheapest.site.index();
}

template class Pricer<float>;
template class Pricer<double>;

}  // namespace ccvt
