// Points of a density of which each of several ranks has some layers.
#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "ccvt/density.h"
#include "checks.h"
#include "number_text.h"
#include "parallel/together.h"
#include "sampling/cell_densities.h"
#include "sampling/density_mass.h"
#include "sampling/density_parts.h"
#include "sampling/draw_parts.h"
#include "sampling/grid_world.h"
#include "sampling/mass.h"
#include "thread_count.h"

namespace ccvt {
namespace {

/// Points that a rank draws before it sends them: about as many.
constexpr double kPointsAtOnce = 1 << 20;

/// Consecutive points that have been drawn.
template <class Scalar>
struct Drawn {
  std::int64_t first = 0;
  std::vector<Scalar> coordinates;
};

CellDensities densities_here(const DensityGrid& grid, const LayerRange& layers) {
  return CellDensities(grid, layers.begin * GridLayers(grid.shape, 0).cells);
}

/// Parts of this rank from `begin` on that have about kPointsAtOnce of `count` points.
std::span<const std::size_t> next_parts(const DensityParts& parts, std::size_t begin,
                                        std::span<const double> masses, double total,
                                        std::int64_t count) {
  const std::span<const std::size_t> left = parts.own().subspan(begin);
  double expected = 0;
  std::size_t taken = 0;
  for (; taken < left.size() && expected < kPointsAtOnce; ++taken) {
    expected += masses[left[taken]] / total * static_cast<double>(count);
  }
  return left.first(taken);
}

/// Sends points to their ranks, and takes those of this one.
template <class Scalar>
void send_to_ranks(Ranks& ranks, const std::vector<Drawn<Scalar>>& drawn, std::size_t dimension,
                   std::int64_t count, std::span<Scalar> own) {
  const auto first_of = [&](int rank) { return detail::first_of_rank(count, rank, ranks.count()); };
  std::vector<ByteWriter> to(static_cast<std::size_t>(ranks.count()));
  int rank = 0;
  for (const Drawn<Scalar>& run : drawn) {
    const auto points = static_cast<std::int64_t>(run.coordinates.size() / dimension);
    if (points == 0) continue;
    // Points of parts ascend with these.
    while (first_of(rank + 1) <= run.first) ++rank;
    std::int64_t done = 0;
    for (int r = rank; done < points; ++r) {
      const std::int64_t part = std::min(points - done, first_of(r + 1) - run.first - done);
      if (part == 0) continue;
      ByteWriter& message = to[static_cast<std::size_t>(r)];
      message.put(run.first + done);
      message.put(part);
      message.put(std::span(run.coordinates)
                      .subspan(static_cast<std::size_t>(done) * dimension,
                               static_cast<std::size_t>(part) * dimension));
      done += part;
    }
  }
  for (const Ranks::Bytes& bytes : exchanged(ranks, std::move(to))) {
    ByteReader message(bytes);
    while (!message.done()) {
      const auto place =
          static_cast<std::size_t>(message.get<std::int64_t>() - first_of(ranks.rank()));
      const auto points = static_cast<std::size_t>(message.get<std::int64_t>());
      message.get(own.subspan(place * dimension, points * dimension));
    }
  }
}

template <class Scalar>
void fill(Ranks& ranks, const LocalDensity& local, const LayerRange& layers, std::int64_t count,
          std::uint64_t seed, DensitySampling sampling, int threads, std::span<Scalar> own) {
  agree(&ranks, [&] {
    require_threads(threads);
    require_enumerator("sampling", sampling, DensitySampling::stratified);
  });
  const DensityGrid& grid = local.grid;
  const std::size_t dimension = grid.shape.size();
  const Arena arena(threads);
  const CellDensities densities = densities_here(grid, layers);
  const DensityParts parts(grid.shape, ranks);
  const std::vector<double> masses = parts.masses(grid, densities, arena, &ranks);
  const Shares shares(masses);
  DrawParts<Scalar> draw(grid, local.origin, densities, parts, seed, sampling, arena);
  const auto draw_from_parts = [&](const auto& draws) {
    std::size_t done = 0;
    while (any(&ranks, done < parts.own().size())) {
      const auto now = next_parts(parts, done, masses, shares.total(), count);
      done += now.size();
      std::vector<Drawn<Scalar>> drawn(now.size());
      deal(shares, now, draws, arena,
           [&](std::size_t part, int worker, std::int64_t first, std::span<const double> targets) {
             const auto at = std::lower_bound(now.begin(), now.end(), part) - now.begin();
             Drawn<Scalar>& run = drawn[static_cast<std::size_t>(at)];
             run.first = first;
             run.coordinates.resize(targets.size() * dimension);
             draw(part, worker, targets, run.coordinates.data());
           });
      send_to_ranks(ranks, drawn, dimension, count, own);
    }
  };
  if (sampling == DensitySampling::stratified) {
    draw_from_parts(StratifiedDraws(seed, count));
  } else {
    draw_from_parts(SortedDraws(seed, count, arena));
  }
}

template <class Scalar>
void fill_in_place(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                   std::uint64_t seed, DensitySampling sampling, int threads,
                   std::span<Scalar> own) {
  fill(ranks, {density.grid, Eigen::VectorXd::Zero(density.grid.box.dimension())}, density.layers,
       count, seed, sampling, threads, own);
}

}  // namespace

LayerRange layers_of_rank(std::span<const std::int64_t> shape, int rank, int ranks) {
  if (rank < 0 || rank >= ranks) {
    throw InvalidInput(
        concat("rank: is ", rank, " of ", ranks, ": it must hold that 0 <= rank < ", ranks));
  }
  std::int64_t cells = 1;
  for (const std::int64_t along : shape) {
    if (along < 1) throw InvalidInput(concat("shape: is ", shape, ": no entry may be below 1"));
    if (__builtin_mul_overflow(cells, along, &cells)) {
      throw InvalidInput(concat("shape: is ", shape, ": has 2^63 cells or more"));
    }
  }
  return GridLayers(shape, level_of_parts(shape)).around(rank, ranks);
}

double density_mass(Ranks& ranks, const DensityLayers& density, const Arena& arena) {
  const DensityGrid& grid = density.grid;
  return integral(grid, DensityParts(grid.shape, ranks)
                            .masses(grid, densities_here(grid, density.layers), arena, &ranks));
}

template <class Scalar>
Points<Scalar> sample_local_density(Ranks& ranks, const LocalDensity& local,
                                    const LayerRange& layers, std::int64_t count,
                                    std::uint64_t seed, DensitySampling sampling, int threads) {
  const auto first_of = [&](int rank) { return detail::first_of_rank(count, rank, ranks.count()); };
  Points<Scalar> points(local.grid.box.dimension(),
                        first_of(ranks.rank() + 1) - first_of(ranks.rank()));
  fill(ranks, local, layers, count, seed, sampling, threads,
       std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())));
  return points;
}

template Points<float> sample_local_density(Ranks&, const LocalDensity&, const LayerRange&,
                                            std::int64_t, std::uint64_t, DensitySampling, int);
template Points<double> sample_local_density(Ranks&, const LocalDensity&, const LayerRange&,
                                             std::int64_t, std::uint64_t, DensitySampling, int);

namespace detail {

void fill_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                  std::uint64_t seed, DensitySampling sampling, int threads,
                  std::span<float> coordinates) {
  fill_in_place(ranks, density, count, seed, sampling, threads, coordinates);
}

void fill_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                  std::uint64_t seed, DensitySampling sampling, int threads,
                  std::span<double> coordinates) {
  fill_in_place(ranks, density, count, seed, sampling, threads, coordinates);
}

}  // namespace detail
}  // namespace ccvt
