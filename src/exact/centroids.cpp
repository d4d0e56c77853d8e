#include "exact/centroids.h"

#include <algorithm>
#include <utility>

#include "exact/distances.h"
#include "geometry/coordinate_range.h"
#include "geometry/range_of_ranks.h"
#include "parallel/rank_turns.h"
#include "parallel/together.h"
#include "relax/nearest_sites.h"

namespace ccvt {
namespace {

/// With more sites than this, in few dimensions, trees beat products over all sites.
constexpr std::size_t kProductSites = 256;
constexpr int kTreeDimensions = 3;
/// Runs of cells for each rank.
constexpr std::size_t kRunsPerRank = 8;
constexpr std::size_t kPointsPerGrain = 1024;

/// Sums over the points of cells, and how many these are.
template <class Scalar>
class CellSums {
 public:
  CellSums(const Metric& metric, PointsView<Scalar> points, const Grouping& groups,
           const Arena& arena, const std::vector<double>& sites)
      : metric_(metric), points_(points), groups_(groups), arena_(arena), sites_(sites) {}

  /// Of a cell: a sum for each dimension, relative to the site, and the number of points.
  [[nodiscard]] std::size_t width() const { return sites_.size() / groups_.count() + 1; }

  /// Adds points of `cells`, in their order, to what there is.
  void add(std::span<const SiteNumber> cells, std::span<double> sums) const {
    arena_.for_ranges(cells.size(), 8, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) add(cells[k], sums.data() + k * width());
    });
  }

 private:
  void add(SiteNumber cell, double* sum) const {
    const std::size_t dimension = width() - 1;
    const double* const site = sites_.data() + cell * dimension;
    const auto members = groups_.of(cell);
    if (metric_.periodic()) {
      for (const PointNumber p : members) {
        const Scalar* x = points_[p.index()];
        for (std::size_t d = 0; d < dimension; ++d) sum[d] += metric_.wrap(x[d] - site[d], d);
      }
    } else {
      add_points(points_, members, site, sum);
    }
    sum[dimension] += static_cast<double>(members.size());
  }

  const Metric& metric_;
  PointsView<Scalar> points_;
  const Grouping& groups_;
  const Arena& arena_;
  const std::vector<double>& sites_;
};

/// The sums over the points of all ranks, as one process adds them; `sums` are zeros.
template <class Scalar>
std::vector<double> sums_of_ranks(Ranks& ranks, const CellSums<Scalar>& own,
                                  std::span<const SiteNumber> cells, std::vector<double> sums) {
  const std::size_t runs = kRunsPerRank * static_cast<std::size_t>(ranks.count());
  const bool last = ranks.rank() + 1 == ranks.count();
  for (std::size_t run = 0; run < runs; ++run) {
    const std::size_t begin = cells.size() * run / runs;
    const std::size_t end = cells.size() * (run + 1) / runs;
    if (begin == end) continue;
    const auto here = std::span(sums).subspan(begin * own.width(), (end - begin) * own.width());
    if (ranks.rank() > 0) {
      const Ranks::Bytes come = ranks.receive(ranks.rank() - 1);
      ByteReader(come).get(here);
    }
    own.add(cells.subspan(begin, end - begin), here);
    if (last) continue;
    const std::span<const std::byte> bytes = std::as_bytes(here);
    ranks.send(ranks.rank() + 1, Ranks::Bytes(bytes.begin(), bytes.end()));
  }
  if (!last) sums.clear();
  return joined(&ranks, std::move(sums));
}

/// The same where all ranks have all points: each adds those of some cells.
template <class Scalar>
std::vector<double> sums_in_turns(Ranks& ranks, const CellSums<Scalar>& own,
                                  std::span<const SiteNumber> cells) {
  const RankTurns turns(&ranks);
  std::vector<SiteNumber> mine;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (turns.own(k)) mine.push_back(cells[k]);
  }
  const std::size_t width = own.width();
  std::vector<double> sums(mine.size() * width, 0.0);
  own.add(mine, sums);
  std::vector<double> all(cells.size() * width);
  read_in_turns(ranks, std::as_bytes(std::span(sums)), cells.size(),
                [&](std::size_t k, ByteReader& reader) {
                  reader.get(std::span(all).subspan(k * width, width));
                });
  return all;
}

}  // namespace

std::vector<std::uint8_t> changed_cells(std::span<const Index> before, std::span<const Index> after,
                                        std::size_t cells, Ranks* ranks) {
  std::vector<std::uint8_t> changed(cells, 0);
  for (std::size_t p = 0; p < before.size(); ++p) {
    if (before[p] == after[p]) continue;
    changed[SiteNumber(before[p])] = changed[SiteNumber(after[p])] = 1;
  }
  if (ranks == nullptr) return changed;
  std::vector<std::uint8_t> all(cells, 0);
  const std::vector<std::uint8_t> of_ranks = joined(ranks, std::move(changed));
  for (std::size_t k = 0; k < of_ranks.size(); ++k) all[k % cells] |= of_ranks[k];
  return all;
}

template <class Scalar>
void move_to_centroids(const Metric& metric, PointsView<Scalar> points, const Grouping& groups,
                       const Arena& arena, std::vector<double>& sites,
                       std::span<const std::uint8_t> changed, Ranks* ranks) {
  const CellSums<Scalar> sums(metric, points, groups, arena, sites);
  std::vector<SiteNumber> looked;
  for (const SiteNumber s : sites_below(groups.count())) {
    if (changed.empty() || changed[s] != 0) looked.push_back(s);
  }
  std::vector<double> all(looked.size() * sums.width(), 0.0);
  if (ranks != nullptr) {
    all = sums_of_ranks(*ranks, sums, looked, std::move(all));
  } else if (arena.ranks() != nullptr) {
    all = sums_in_turns(*arena.ranks(), sums, looked);
  } else {
    sums.add(looked, all);
  }
  const std::size_t dimension = sums.width() - 1;
  for (std::size_t k = 0; k < looked.size(); ++k) {
    const double* const sum = all.data() + k * sums.width();
    const double size = sum[dimension];
    if (size == 0) continue;
    double* const site = sites.data() + looked[k] * dimension;
    for (std::size_t d = 0; d < dimension; ++d) {
      site[d] = metric.into_box(site[d] + sum[d] / size, d);
    }
  }
}

template <class Scalar>
std::vector<Index> nearest_owners(const Metric& metric, PointsView<Scalar> points,
                                  const std::vector<double>& sites, const Arena& arena,
                                  const RankPart& part) {
  const std::vector<double> weights = no_weights(sites, points.dimension);
  if (points.dimension <= kTreeDimensions && weights.size() > kProductSites) {
    SiteState state(points.dimension, static_cast<Index>(weights.size()));
    state.position = sites;
    const Box box =
        part.ranks == nullptr ? box_around(points, arena) : box_of_all(*part.ranks, points, arena);
    if (points.count == 0) return {};
    std::vector<Index> owners(static_cast<std::size_t>(points.count));
    Ranks* const ranks = sharing(arena, part);
    const RankRange here(ranks, owners.size(), kPointsPerGrain);
    points.data += static_cast<std::ptrdiff_t>(here.begin) * points.stride;
    points.count = static_cast<Index>(here.end - here.begin);
    const auto nearest = NearestSites<Scalar>(metric, state, box, arena).owners(points, arena);
    for (std::size_t k = 0; k < nearest.size(); ++k) owners[here.begin + k] = nearest[k].index();
    if (ranks != nullptr) share_ranges(arena, std::span(owners), kPointsPerGrain);
    return owners;
  }
  return Pricer<Scalar>(metric, points, arena, part).cheapest({sites, weights});
}

template void move_to_centroids(const Metric&, PointsView<float>, const Grouping&, const Arena&,
                                std::vector<double>&, std::span<const std::uint8_t>, Ranks*);
template void move_to_centroids(const Metric&, PointsView<double>, const Grouping&, const Arena&,
                                std::vector<double>&, std::span<const std::uint8_t>, Ranks*);
template std::vector<Index> nearest_owners(const Metric&, PointsView<float>,
                                           const std::vector<double>&, const Arena&,
                                           const RankPart&);
template std::vector<Index> nearest_owners(const Metric&, PointsView<double>,
                                           const std::vector<double>&, const Arena&,
                                           const RankPart&);

}  // namespace ccvt
