#include "relax/along_curve.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "parallel/together.h"

namespace ccvt {
namespace {

/// So that subsets of a quarter tell bins apart; of more, the table of bins leaves the cache.
constexpr std::size_t kPointsPerBin = 4;
constexpr std::size_t kMostBins = 1 << 18;

/// In the box, for so many points.
CurveGrid bins_in(const Box& box, std::size_t points) {
  const std::size_t bins = (points + kPointsPerBin - 1) / kPointsPerBin;
  return {{box.lower.data(), box.lower.data() + box.dimension()},
          {box.upper.data(), box.upper.data() + box.dimension()},
          std::min(bins, kMostBins)};
}

}  // namespace

template <class Scalar>
PointsAlongCurve<Scalar>::PointsAlongCurve(const OwnPoints<Scalar>& points,
                                           std::int64_t points_of_all, const Box& box,
                                           const Arena& arena)
    : points_(points),
      count_(static_cast<std::size_t>(points_of_all)),
      grid_(bins_in(box, count_)),
      runs_(std::clamp<std::size_t>(4 * own_count() / grid_.count(), 1, arena.workers_in_mind())),
      of_cells_(runs_ * grid_.count()) {
  arena.for_each(runs_, 1, [&](std::size_t run) {
    std::fill_n(of_cells(run), grid_.count(), 0U);
    visit_cells(arena, run, [](PointNumber, std::size_t, std::uint32_t& count) { ++count; });
  });
  // In a cell, from run to run; then from bin to bin along the curve.
  std::vector<std::uint32_t> before(grid_.count());
  constexpr std::size_t kCellsPerGrain = 1 << 12;
  const auto for_cells = [&](const auto& change) {
    arena.for_ranges(before.size(), kCellsPerGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t run = 0; run < runs_; ++run) {
        for (std::size_t cell = begin; cell < end; ++cell) change(of_cells(run)[cell], cell);
      }
    });
  };
  for_cells([&](std::uint32_t& of_run, std::size_t cell) {
    before[cell] += std::exchange(of_run, before[cell]);
  });
  if (arena.ranks() != nullptr) {
    std::vector<std::uint32_t> sizes;
    sizes.reserve(before.size());
    grid_.visit_along_curve([&](std::size_t cell) { sizes.push_back(before[cell]); });
    count_before(*arena.ranks(), sizes);
    return;
  }
  std::uint32_t sum = 0;
  grid_.visit_along_curve([&](std::size_t cell) { sum += std::exchange(before[cell], sum); });
  for_cells([&](std::uint32_t& of_run, std::size_t cell) { of_run += before[cell]; });
}

/// Each rank finds it out for some of the bins, from what all have in these: `sizes`, of this one.
template <class Scalar>
void PointsAlongCurve<Scalar>::count_before(Ranks& ranks, const std::vector<std::uint32_t>& sizes) {
  const auto all = static_cast<std::size_t>(ranks.count());
  const std::size_t bins = sizes.size();
  const auto begin_of = [&](std::size_t rank) { return rank * bins / all; };
  std::vector<ByteWriter> counts(all);
  for (std::size_t r = 0; r < all; ++r) {
    counts[r].put(std::span(sizes).subspan(begin_of(r), begin_of(r + 1) - begin_of(r)));
  }
  const std::vector<Ranks::Bytes> come = exchanged(ranks, std::move(counts));
  std::vector<ByteReader> readers(come.begin(), come.end());
  const auto own = static_cast<std::size_t>(ranks.rank());
  const std::size_t own_bins = begin_of(own + 1) - begin_of(own);
  std::vector<std::size_t> before(own_bins * all);  // in a bin, first of these
  std::size_t sum = 0;
  for (std::size_t b = 0; b < own_bins; ++b) {
    for (std::size_t r = 0; r < all; ++r) {
      before[r * own_bins + b] = sum;
      sum += readers[r].template get<std::uint32_t>();
    }
  }
  std::size_t in_bins_before = 0;
  const std::vector<std::size_t> sums = of_all(&ranks, sum);
  for (std::size_t r = 0; r < own; ++r) in_bins_before += sums[r];
  for (std::size_t& places : before) places += in_bins_before;
  std::vector<ByteWriter> places(all);
  for (std::size_t r = 0; r < all; ++r) {
    places[r].put(std::span(std::as_const(before)).subspan(r * own_bins, own_bins));
  }
  std::vector<std::size_t> before_bin;
  for (const Ranks::Bytes& of_bins : exchanged(ranks, std::move(places))) {
    ByteReader reader(of_bins);
    while (!reader.done()) before_bin.push_back(reader.template get<std::size_t>());
  }
  before_cell_.resize(bins);
  auto next = before_bin.begin();
  grid_.visit_along_curve([&](std::size_t cell) { before_cell_[cell] = *next++; });
}

template class PointsAlongCurve<float>;
template class PointsAlongCurve<double>;

}  // namespace ccvt
