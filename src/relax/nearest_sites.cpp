#include "relax/nearest_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/nearest.h"

namespace ccvt {
namespace {

/// A bin that has more sites around it asks the tree.
constexpr std::size_t kMostAround = 512;
/// Of a bin's width: how far from its centre sites are looked for first.
constexpr double kFirstReach = 2.2;
constexpr int kTries = 3;
/// Of squared distances in and around a bin: rounding must not drop a site.
constexpr double kRounding = 1e-12;
/// With fewer points a cell, the sites that can be nearest in a bin are not told apart by cells.
constexpr std::size_t kPointsPerCell = 24;
/// Points that are on their way from memory while others are placed.
constexpr std::size_t kAhead = 24;
/// Points that are sorted, and found, at a time.
constexpr std::size_t kSlice = 1 << 16;
constexpr std::size_t kMostBuckets = 1024;

}  // namespace

/// Sites by their offset from the centre of a bin.
template <class Scalar>
struct NearestSites<Scalar>::Around {
  std::size_t count = 0;
  std::array<Index, kMostAround> site;
  std::array<std::array<double, kMostAround>, kMostDimensions> offset;
};

template <class Scalar>
struct NearestSites<Scalar>::Worker {
  Around around;
  Around in_bin;
  Around in_cell;
  std::vector<double> coordinates;   ///< of points, a stream for each dimension
  std::vector<double> positions;     ///< of candidates
  std::vector<std::int32_t> chosen;  ///< candidate of each point
};

template <class Scalar>
NearestSites<Scalar>::NearestSites(const Metric& metric, const SiteState& sites, const Box& box)
    : metric_(metric),
      sites_(sites),
      dimension_(static_cast<std::size_t>(metric.dimension())),
      bins_(SiteBins::sort(metric, sites.position, box.lower.data(), box.upper.data())) {
  // Cells have 32-bit numbers.
  constexpr std::size_t kMostCells = std::numeric_limits<std::uint32_t>::max();
  if (bins_ && bins_->bin_count() > (kMostCells >> dimension_)) bins_.reset();
  if (!bins_) return;
  for (std::size_t d = 0; d < dimension_; ++d) {
    extent_[d] = metric.periodic() ? metric.extent()[d] : std::numeric_limits<double>::infinity();
    lower_[d] = bins_->lower(d);
    inverse_width_[d] = 2 / bins_->width(d);
    last_[d] = static_cast<double>(2 * bins_->bins(d) - 1);
    half_[d] = bins_->width(d) / 2 + bins_->rounding();
  }
}

template <class Scalar>
const SiteTree& NearestSites<Scalar>::tree() const {
  std::call_once(tree_built_, [&] { tree_.emplace(metric_, sites_.position); });
  return *tree_;
}

template <class Scalar>
template <std::size_t Dimension>
std::uint32_t NearestSites<Scalar>::cell_of(const Scalar* position) const {
  std::uint32_t bin = 0;
  std::uint32_t child = 0;
  for (std::size_t d = Dimension; d-- > 0;) {
    const double along = (static_cast<double>(position[d]) - lower_[d]) * inverse_width_[d];
    const auto k = static_cast<std::uint32_t>(std::clamp(along, 0.0, last_[d]));
    bin = bin * static_cast<std::uint32_t>(bins_->bins(d)) + k / 2;
    child = 2 * child + k % 2;
  }
  return (bin << Dimension) + child;
}

/// The points of cell g become those from first[g] to first[g + 1]. They go into buckets of
/// consecutive cells first, so many that the ends of all are in the cache, and then into cells.
template <class Scalar>
void NearestSites<Scalar>::sort_by_cell(const PointsView<Scalar>& points,
                                        std::span<const Index> which, const Arena& arena,
                                        std::vector<std::size_t>& first, Found& found) const {
  const std::size_t cells = bins_->bin_count() << dimension_;
  int shift = 0;
  while ((cells - 1) >> shift >= kMostBuckets) ++shift;
  const std::size_t buckets = ((cells - 1) >> shift) + 1;
  const std::size_t slices = (which.size() + kSlice - 1) / kSlice;
  const auto for_slice = [&](std::size_t slice, auto visit) {
    const std::size_t end = std::min((slice + 1) * kSlice, which.size());
    for (std::size_t k = slice * kSlice; k < end; ++k) visit(k);
  };

  // Of the points of a slice in a bucket, the first place: by bucket, and in it by slice.
  std::vector<std::size_t> place(buckets * slices + 1, 0);
  std::vector<std::uint32_t> cell(which.size());
  arena.for_each(slices, 1, [&](std::size_t slice) {
    std::vector<std::size_t> count(buckets, 0);
    for_slice(slice, [&](std::size_t k) {
      const Scalar* position = points[which[k]];
      cell[k] = dimension_ == 2 ? cell_of<2>(position) : cell_of<3>(position);
      ++count[cell[k] >> shift];
    });
    for (std::size_t b = 0; b < buckets; ++b) place[b * slices + slice + 1] = count[b];
  });
  std::partial_sum(place.begin(), place.end(), place.begin());

  struct Placed {
    std::uint32_t cell;
    Index point;
  };
  std::vector<Placed> placed(which.size());
  arena.for_each(slices, 1, [&](std::size_t slice) {
    std::vector<std::size_t> next(buckets);
    for (std::size_t b = 0; b < buckets; ++b) next[b] = place[b * slices + slice];
    for_slice(slice, [&](std::size_t k) {
      placed[next[cell[k] >> shift]++] = {cell[k], which[k]};
    });
  });

  first.assign(cells + 1, which.size());
  arena.for_each(buckets, 1, [&](std::size_t b) {
    const std::size_t begin = place[b * slices];
    const auto here = std::span(placed).subspan(begin, place[(b + 1) * slices] - begin);
    const std::size_t first_cell = b << shift;
    std::vector<std::size_t> next(std::min(std::size_t{1} << shift, cells - first_cell) + 1, 0);
    for (const Placed& p : here) ++next[p.cell - first_cell + 1];
    next[0] = begin;
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::copy(next.begin(), next.end() - 1,
              first.begin() + static_cast<std::ptrdiff_t>(first_cell));
    for (const Placed& p : here) found.point[next[p.cell - first_cell]++] = p.point;
  });
}

template <class Scalar>
auto NearestSites<Scalar>::centre_of(std::size_t bin) const -> Vector {
  Vector centre{};
  for (std::size_t d = 0; d < dimension_; ++d) {
    const std::size_t along = bin % bins_->bins(d);
    bin /= bins_->bins(d);
    centre[d] = lower_[d] + (static_cast<double>(along) + 0.5) * bins_->width(d);
  }
  return centre;
}

/// The sites around a bin: all that can be nearest to a point of it, by their image nearest to its
/// centre. False when there are too many, or none near enough.
///
/// Let c be the site nearest to the centre, and r its distance from the corner farthest from it: a
/// site nearer than c to a point of the bin is at most r from that point.
template <class Scalar>
template <std::size_t Dimension>
bool NearestSites<Scalar>::gather(const Vector& centre, Around& around) const {
  const double widest = 2 * *std::max_element(half_.begin(), half_.end());
  // Farther away, another image of a site may be the nearer one.
  const double most = *std::min_element(extent_.begin(), extent_.begin() + Dimension) / 2;
  double reach = kFirstReach * widest;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    std::size_t count = 0;
    bool fits = true;
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t c = 0;
    bins_->for_each_offset<Dimension>(
        centre.data(), reach, [&](std::size_t place, const std::array<double, Dimension>& offset) {
          fits = fits && count < kMostAround;
          if (!fits) return;
          double squared = 0;
          for (std::size_t d = 0; d < Dimension; ++d) {
            around.offset[d][count] = offset[d];
            squared += offset[d] * offset[d];
          }
          around.site[count] = bins_->site(place);
          c = squared < nearest ? count : c;
          nearest = squared < nearest ? squared : nearest;
          ++count;
        });
    around.count = count;
    if (!fits) return false;
    if (count == 0) {
      reach *= 2;
      continue;
    }
    double to_corner = 0;
    for (std::size_t d = 0; d < Dimension; ++d) {
      to_corner += std::pow(std::abs(around.offset[d][c]) + half_[d], 2);
    }
    const double needed = (std::sqrt(to_corner) + widest / 2) * (1 + 1e-9);
    if (needed >= most) return false;
    if (needed <= reach) return true;
    reach = needed;
  }
  return false;
}

/// Of the sites around a bin, those that no other keeps from being nearest in the region of so many
/// half widths on each side of `centre` (from the bin's centre): s is out when the nearest to the
/// region's centre, c, is nearer than s in all of it, which is when it is at each of its corners,
/// as |x - s|^2 - |x - c|^2 is linear in x.
template <class Scalar>
template <std::size_t Dimension>
void NearestSites<Scalar>::keep_candidates(const Around& around, const Vector& centre,
                                           double halves, Around& candidates) const {
  std::array<double, kMostAround> squared;
  for (std::size_t k = 0; k < around.count; ++k) {
    squared[k] = 0;
    for (std::size_t d = 0; d < Dimension; ++d) {
      const double difference = around.offset[d][k] - centre[d];
      squared[k] += difference * difference;
    }
  }
  const auto c = static_cast<std::size_t>(
      std::min_element(squared.begin(),
                       squared.begin() + static_cast<std::ptrdiff_t>(around.count)) -
      squared.begin());
  Vector central{};
  for (std::size_t d = 0; d < Dimension; ++d) central[d] = around.offset[d][c];
  double room = squared[c];
  for (std::size_t d = 0; d < Dimension; ++d) room += 4 * half_[d] * half_[d];
  const double most = squared[c] + kRounding * room;
  for (std::size_t k = 0; k < around.count; ++k) {
    for (std::size_t d = 0; d < Dimension; ++d) {
      squared[k] -= 2 * halves * half_[d] * std::abs(around.offset[d][k] - central[d]);
    }
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < around.count; ++k) {
    for (std::size_t d = 0; d < Dimension; ++d) {
      candidates.offset[d][count] = around.offset[d][k];
    }
    candidates.site[count] = around.site[k];
    count += squared[k] <= most ? 1 : 0;
  }
  candidates.count = count;
}

template <class Scalar>
template <std::size_t Dimension>
void NearestSites<Scalar>::find_among(const PointsView<Scalar>& points, const Around& candidates,
                                      const Vector& centre, std::size_t begin, std::size_t end,
                                      Worker& worker, Found& found) const {
  if (begin == end) return;
  if (candidates.count == 1) {
    std::fill(&found.site[begin], &found.site[begin] + (end - begin), candidates.site[0]);
    return;
  }
  constexpr auto kStep = static_cast<std::size_t>(kernels::kNearestPoints);
  const std::size_t stride = (end - begin + kStep - 1) / kStep * kStep;
  worker.coordinates.resize(stride * Dimension);
  worker.chosen.resize(stride);
  worker.positions.resize(candidates.count * Dimension);
  for (std::size_t k = begin; k < end; ++k) {
    if (k + kAhead < found.point.size()) __builtin_prefetch(points[found.point[k + kAhead]]);
    const Scalar* point = points[found.point[k]];
    for (std::size_t d = 0; d < Dimension; ++d) {
      worker.coordinates[d * stride + k - begin] = static_cast<double>(point[d]);
    }
  }
  for (std::size_t d = 0; d < Dimension; ++d) {
    double* stream = &worker.coordinates[d * stride];
    std::fill(stream + (end - begin), stream + stride, stream[0]);
    for (std::size_t c = 0; c < candidates.count; ++c) {
      const double own = sites_.at(candidates.site[c])[d];
      const double offset = candidates.offset[d][c];
      // Another image of the site, or the site itself without loss of digits.
      worker.positions[c * Dimension + d] = own - centre[d] == offset ? own : centre[d] + offset;
    }
  }
  kernels::nearest_positions(worker.coordinates.data(), static_cast<Index>(stride), int{Dimension},
                             worker.positions.data(), static_cast<Index>(candidates.count),
                             worker.chosen.data());
  for (std::size_t k = begin; k < end; ++k) {
    found.site[k] = candidates.site[static_cast<std::size_t>(worker.chosen[k - begin])];
  }
}

template <class Scalar>
void NearestSites<Scalar>::ask_tree(const PointsView<Scalar>& points, std::size_t begin,
                                    std::size_t end, Found& found) const {
  std::vector<double> query(dimension_);
  for (std::size_t k = begin; k < end; ++k) {
    std::copy_n(points[found.point[k]], dimension_, query.begin());
    found.site[k] = tree().nearest(query.data());
  }
}

/// `first`: of the cells of the bin, and one more.
template <class Scalar>
template <std::size_t Dimension>
void NearestSites<Scalar>::find_in_bin(const PointsView<Scalar>& points,
                                       std::span<const std::size_t> first, std::size_t bin,
                                       Worker& worker, Found& found) const {
  const std::size_t begin = first.front();
  const std::size_t end = first.back();
  if (begin == end) return;
  const Vector centre = centre_of(bin);
  if (!gather<Dimension>(centre, worker.around)) return ask_tree(points, begin, end, found);
  keep_candidates<Dimension>(worker.around, {}, 1, worker.in_bin);
  const std::size_t cells = std::size_t{1} << Dimension;
  if (end - begin < kPointsPerCell * cells) {
    return find_among<Dimension>(points, worker.in_bin, centre, begin, end, worker, found);
  }
  for (std::size_t g = 0; g < cells; ++g) {
    Vector cell_centre{};
    for (std::size_t d = 0; d < Dimension; ++d) {
      cell_centre[d] = ((g >> d) % 2 == 0 ? -0.5 : 0.5) * half_[d];
    }
    keep_candidates<Dimension>(worker.in_bin, cell_centre, 0.5, worker.in_cell);
    find_among<Dimension>(points, worker.in_cell, centre, first[g], first[g + 1], worker, found);
  }
}

template <class Scalar>
void NearestSites<Scalar>::operator()(const PointsView<Scalar>& points,
                                      std::span<const Index> which, const Arena& arena,
                                      Found& found, const Taken& taken) const {
  found.point.resize(which.size());
  found.site.resize(which.size());
  if (which.empty()) return;
  if (!bins_) {
    std::copy(which.begin(), which.end(), found.point.begin());
    arena.for_ranges(which.size(), 4096, [&](std::size_t begin, std::size_t end, int) {
      ask_tree(points, begin, end, found);
    });
    if (taken) taken(0, which.size());
    return;
  }
  std::vector<std::size_t> first;
  sort_by_cell(points, which, arena, first, found);
  std::vector<std::unique_ptr<Worker>> workers(static_cast<std::size_t>(arena.threads()));
  const std::size_t cells = std::size_t{1} << dimension_;
  std::size_t from = 0;
  while (from < bins_->bin_count()) {
    const auto next = std::upper_bound(first.begin(), first.end(), first[from * cells] + kSlice);
    const auto cell = static_cast<std::size_t>(next - first.begin());
    const std::size_t to = std::clamp((cell - 1) / cells, from + 1, bins_->bin_count());
    arena.for_ranges(to - from, 16, [&](std::size_t begin, std::size_t end, int w) {
      auto& worker = workers[static_cast<std::size_t>(w)];
      if (!worker) worker = std::make_unique<Worker>();
      for (std::size_t bin = from + begin; bin < from + end; ++bin) {
        const auto here = std::span(first).subspan(bin * cells, cells + 1);
        if (dimension_ == 2) {
          find_in_bin<2>(points, here, bin, *worker, found);
        } else {
          find_in_bin<3>(points, here, bin, *worker, found);
        }
      }
    });
    if (taken) taken(first[from * cells], first[to * cells]);
    from = to;
  }
}

template class NearestSites<float>;
template class NearestSites<double>;

}  // namespace ccvt
