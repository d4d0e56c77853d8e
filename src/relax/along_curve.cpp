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
      grid_(bins_in(box, count_)) {
  const bool alone = !arena.prepares();
  if (alone) {
    count_in_cells();
  } else {
    group(arena);
  }
  if (arena.ranks() == nullptr) return;
  std::vector<std::uint32_t> sizes;
  sizes.reserve(grid_.count());
  if (alone) {
    std::vector<std::uint32_t> ends;
    grid_.visit_along_curve([&](std::size_t cell) { ends.push_back(first_in_cell_[cell]); });
    ends.push_back(static_cast<std::uint32_t>(own_count()));
    for (std::size_t b = 0; b < grid_.count(); ++b) sizes.push_back(ends[b + 1] - ends[b]);
  } else {
    for (std::size_t b = 0; b < grid_.count(); ++b) {
      sizes.push_back(static_cast<std::uint32_t>(by_bin_[b].size()));
    }
  }
  count_before(*arena.ranks(), sizes);
}

template <class Scalar>
void PointsAlongCurve<Scalar>::count_in_cells() {
  first_in_cell_.assign(grid_.count(), 0);
  visit_cells(first_in_cell_, [](PointNumber, std::uint32_t& count) { ++count; });
  std::uint32_t before = 0;
  grid_.visit_along_curve(
      [&](std::size_t cell) { before += std::exchange(first_in_cell_[cell], before); });
}

template <class Scalar>
void PointsAlongCurve<Scalar>::group(const Arena& arena) {
  Buffer<std::uint32_t> number(grid_.count());
  std::uint32_t next = 0;
  grid_.visit_along_curve([&](std::size_t cell) { number[cell] = next++; });
  by_bin_ = group_by_key<Binned>(
      arena, own_count(), grid_.count(),
      [&](std::size_t p) {
        return Binned{PointNumber(p), number[cell_of(PointNumber(p))]};
      },
      [](const Binned& item) { return item.bin; });
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
  for (const Ranks::Bytes& of_bins : exchanged(ranks, std::move(places))) {
    ByteReader reader(of_bins);
    while (!reader.done()) before_.push_back(reader.template get<std::size_t>());
  }
}

template class PointsAlongCurve<float>;
template class PointsAlongCurve<double>;

}  // namespace ccvt
