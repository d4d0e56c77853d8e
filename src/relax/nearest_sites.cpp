#include "relax/nearest_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
constexpr std::size_t kBinsPerGrain = 64;
constexpr std::size_t kPointsPerGrain = 4096;
/// Points whose coordinates are fetched ahead: those of few among many lie here and there.
constexpr std::size_t kPointsAhead = 32;

/// Of the sites that may be nearest to some points.
using CandidateNumber = Number<struct OfCandidates>;

}  // namespace

/// Sites by their offset from the centre of a bin.
template <class Scalar>
struct NearestSites<Scalar>::Around {
  std::size_t count = 0;
  std::array<SiteNumber, kMostAround> site;
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
NearestSites<Scalar>::NearestSites(const Metric& metric, const SiteState& sites, const Box& box,
                                   const Arena& arena)
    : metric_(metric),
      sites_(sites),
      dimension_(sites.dimension),
      bins_(SiteBins::sort(metric, sites.position, box.lower.data(), box.upper.data(), arena)) {
  // Cells are numbered like sites.
  constexpr std::size_t kMostCells = std::numeric_limits<Index>::max();
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
std::size_t NearestSites<Scalar>::cell_of(const Scalar* position) const {
  std::size_t bin = 0;
  std::size_t child = 0;
  for (std::size_t d = Dimension; d-- > 0;) {
    const double along = (position[d] - lower_[d]) * inverse_width_[d];
    const auto k = static_cast<std::uint32_t>(std::clamp(along, 0.0, last_[d]));
    bin = bin * bins_->bins(d) + k / 2;
    child = 2 * child + k % 2;
  }
  return (bin << Dimension) + child;
}

template <class Scalar>
std::size_t NearestSites<Scalar>::cell_of(const Scalar* x) const {
  return dimension_ == 2 ? cell_of<2>(x) : cell_of<3>(x);
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
          around.site[count] = SiteNumber(bins_->site(place));
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
  const double* const nearest = std::min_element(squared.data(), squared.data() + around.count);
  const auto c = static_cast<std::size_t>(nearest - squared.data());
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
void NearestSites<Scalar>::find_among(const Around& candidates, const Vector& centre,
                                      Worker& worker,
                                      std::span<Near<Scalar, Dimension>> here) const {
  if (here.empty()) return;
  if (candidates.count == 1) {
    for (auto& near : here) near.site = candidates.site[0];
    return;
  }
  constexpr std::size_t kStep = kernels::kNearestPoints;
  const std::size_t stride = (here.size() + kStep - 1) / kStep * kStep;
  worker.coordinates.resize(stride * Dimension);
  worker.chosen.resize(stride);
  worker.positions.resize(candidates.count * Dimension);
  for (std::size_t k = 0; k < stride; ++k) {
    const auto& point = here[k < here.size() ? k : 0];
    for (std::size_t d = 0; d < Dimension; ++d) {
      worker.coordinates[d * stride + k] = point.x[d];
    }
  }
  for (std::size_t d = 0; d < Dimension; ++d) {
    for (std::size_t c = 0; c < candidates.count; ++c) {
      const double own = sites_.at(candidates.site[c])[d];
      const double offset = candidates.offset[d][c];
      // Another image of the site, or the site itself without loss of digits.
      worker.positions[c * Dimension + d] = own - centre[d] == offset ? own : centre[d] + offset;
    }
  }
  kernels::nearest_positions(worker.coordinates.data(), static_cast<Index>(stride), Dimension,
                             worker.positions.data(), static_cast<Index>(candidates.count),
                             worker.chosen.data());
  for (std::size_t k = 0; k < here.size(); ++k) {
    here[k].site = candidates.site[CandidateNumber(worker.chosen[k])];
  }
}

/// Of the points in the cells of a bin.
template <class Scalar>
template <std::size_t Dimension>
void NearestSites<Scalar>::find_in_bin(std::size_t bin, Worker& worker,
                                       Groups<Near<Scalar, Dimension>>& by_cell) const {
  constexpr std::size_t kCells = 1 << Dimension;
  const std::size_t first = bin * kCells;
  const auto here = by_cell.items.span().subspan(
      by_cell.first[first], by_cell.first[first + kCells] - by_cell.first[first]);
  if (here.empty()) return;
  const Vector centre = centre_of(bin);
  if (!gather<Dimension>(centre, worker.around)) {
    for (auto& near : here) {
      std::array<double, Dimension> query;
      std::copy(near.x.begin(), near.x.end(), query.begin());
      near.site = SiteNumber(tree().nearest(query.data()));
    }
    return;
  }
  keep_candidates<Dimension>(worker.around, {}, 1, worker.in_bin);
  if (here.size() < kPointsPerCell * kCells) {
    return find_among<Dimension>(worker.in_bin, centre, worker, here);
  }
  for (std::size_t g = 0; g < kCells; ++g) {
    Vector cell_centre{};
    for (std::size_t d = 0; d < Dimension; ++d) {
      cell_centre[d] = ((g >> d) % 2 == 0 ? -0.5 : 0.5) * half_[d];
    }
    keep_candidates<Dimension>(worker.in_bin, cell_centre, 0.5, worker.in_cell);
    find_among<Dimension>(worker.in_cell, centre, worker, by_cell[first + g]);
  }
}

template <class Scalar>
template <std::size_t Dimension>
void NearestSites<Scalar>::find(const PointsView<Scalar>& points,
                                std::span<const PointNumber> which, const Arena& arena,
                                Found<Dimension>& found) const {
  using Item = Near<Scalar, Dimension>;
  found.points.reset(which.size());
  if constexpr (Dimension == 0) {
    arena.for_ranges(which.size(), kPointsPerGrain, [&](std::size_t begin, std::size_t end, int) {
      std::vector<double> query(dimension_);
      for (std::size_t k = begin; k < end; ++k) {
        std::copy_n(points[which[k].index()], dimension_, query.begin());
        found.points[k] = {SiteNumber(tree().nearest(query.data())), which[k]};
      }
    });
  } else {
    const std::size_t bins = bins_->bin_count();
    const std::size_t last = which.size() - 1;
    auto by_cell = group_by_key(
        arena, std::move(found.points), bins << Dimension,
        [&](std::size_t k, Item& item) {
          const Scalar* x = points[which[k].index()];
          __builtin_prefetch(points[which[std::min(k + kPointsAhead, last)].index()]);
          item.site = SiteNumber(cell_of<Dimension>(x));
          item.point = which[k];
          std::copy_n(x, Dimension, item.x.begin());
        },
        [](const Item& item) { return item.site; }, found.spare);
    PerWorker<Worker> workers(arena);
    arena.for_ranges(bins, kBinsPerGrain, [&](std::size_t begin, std::size_t end, int w) {
      for (std::size_t bin = begin; bin < end; ++bin) {
        find_in_bin<Dimension>(bin, workers[w], by_cell);
      }
    });
    found.points = std::move(by_cell.items);
  }
}

template <class Scalar>
Buffer<SiteNumber> NearestSites<Scalar>::owners(const PointsView<Scalar>& points,
                                                const Arena& arena) const {
  const auto count = static_cast<std::size_t>(points.count);
  Buffer<PointNumber> all(count);
  arena.for_each(count, kPointsPerGrain, [&](std::size_t p) { all[p] = PointNumber(p); });
  Buffer<SiteNumber> owners(count);
  with_dimension(dimension_of_copies(), [&]<std::size_t Dimension>() {
    Found<Dimension> found;
    find<Dimension>(points, all, arena, found);
    arena.for_each(count, kPointsPerGrain,
                   [&](std::size_t k) { owners[found.points[k].point] = found.points[k].site; });
  });
  return owners;
}

#define CCVT_INSTANTIATE(Scalar, Dimension)                                  \
  template void NearestSites<Scalar>::find<Dimension>(                       \
      const PointsView<Scalar>&, std::span<const PointNumber>, const Arena&, \
      NearestSites<Scalar>::Found<Dimension>&) const;

CCVT_INSTANTIATE(float, 0)
CCVT_INSTANTIATE(float, 2)
CCVT_INSTANTIATE(float, 3)
CCVT_INSTANTIATE(double, 0)
CCVT_INSTANTIATE(double, 2)
CCVT_INSTANTIATE(double, 3)
#undef CCVT_INSTANTIATE

template class NearestSites<float>;
template class NearestSites<double>;

}  // namespace ccvt
