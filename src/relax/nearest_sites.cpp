#include "relax/nearest_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ccvt {
namespace {

constexpr double kCellsPerSite = 4;
/// A grid cell with more sites near it than this asks the tree, and so does one that finds none
/// within so many rings of cells.
constexpr std::size_t kMostCandidates = 16;
constexpr Index kMostRings = 5;

}  // namespace

template <class Scalar>
NearestSites<Scalar>::NearestSites(const Metric& metric, const SiteState& sites, const Box& box,
                                   std::size_t queries, const Arena& arena)
    : metric_(metric), sites_(sites), tree_(metric, sites.position) {
  const bool pays = static_cast<double>(queries) > 2 * kCellsPerSite * sites.count();
  const bool flat = metric.dimension() == 2 || metric.dimension() == 3;
  if (flat && pays && box.extent().minCoeff() > 0) make_grid(box, arena);
}

template <class Scalar>
std::size_t NearestSites<Scalar>::cell_of(const double* position) const {
  std::size_t cell = 0;
  for (std::size_t d = resolution_.size(); d-- > 0;) {
    const auto k = static_cast<Index>(std::clamp((position[d] - lower_[d]) * inverse_width_[d], 0.0,
                                                 static_cast<double>(resolution_[d] - 1)));
    cell = cell * static_cast<std::size_t>(resolution_[d]) + static_cast<std::size_t>(k);
  }
  return cell;
}

/// Visits the cells whose largest offset from `centre` along any dimension is `ring`.
template <class Scalar>
template <class Visit>
void NearestSites<Scalar>::for_ring(const std::vector<Index>& centre, Index ring,
                                    Visit visit) const {
  const auto recurse = [&](auto& self, std::size_t d, std::size_t cell, bool on_ring) -> void {
    const Index count = resolution_[d];
    // Only the two ends reach the ring when no other dimension can.
    const Index step = d == 0 && !on_ring && ring > 0 ? 2 * ring : 1;
    for (Index offset = -ring; offset <= ring; offset += step) {
      Index k = centre[d] + offset;
      if (metric_.periodic()) {
        k = (k + count) % count;
      } else if (k < 0 || k >= count) {
        continue;
      }
      const bool reaches = on_ring || offset == ring || offset == -ring;
      const std::size_t next = cell * static_cast<std::size_t>(count) + static_cast<std::size_t>(k);
      if (d > 0) {
        self(self, d - 1, next, reaches);
      } else if (reaches) {
        visit(next);
      }
    }
  };
  recurse(recurse, resolution_.size() - 1, 0, false);
}

/// The sites that can be nearest to a point of a grid cell: with the nearest to its centre at
/// distance r, those within r and the cell's diagonal. None when there are too many or too far.
template <class Scalar>
void NearestSites<Scalar>::sites_near(const std::vector<std::size_t>& first,
                                      const std::vector<Index>& by_cell, std::size_t cell,
                                      std::vector<Index>& near) const {
  const std::size_t dimension = resolution_.size();
  std::vector<Index> place(dimension);
  std::vector<double> centre(dimension);
  double diagonal = 0;
  std::size_t rest = cell;
  for (std::size_t d = 0; d < dimension; ++d) {
    const auto count = static_cast<std::size_t>(resolution_[d]);
    place[d] = static_cast<Index>(rest % count);
    centre[d] = lower_[d] + (static_cast<double>(place[d]) + 0.5) * width_[d];
    rest /= count;
    diagonal += width_[d] * width_[d];
  }
  // Rounding may put a point into the cell next to its own.
  double farthest = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    farthest =
        std::max({farthest, std::abs(lower_[d]), std::abs(lower_[d] + width_[d] * resolution_[d])});
  }
  diagonal = std::sqrt(diagonal) * (1 + 1e-12) + 1e-15 * farthest;
  const double width = *std::min_element(width_.begin(), width_.end());

  struct Found {
    Index site;
    double distance;
  };
  std::vector<Found> found;
  double nearest = std::numeric_limits<double>::infinity();
  for (Index ring = 0; ring <= kMostRings; ++ring) {
    for_ring(place, ring, [&](std::size_t other) {
      for (std::size_t k = first[other]; k < first[other + 1]; ++k) {
        const double distance =
            std::sqrt(metric_.squared_distance(centre.data(), sites_.at(by_cell[k])));
        nearest = std::min(nearest, distance);
        found.push_back({by_cell[k], distance});
      }
    });
    if (found.size() > 4 * kMostCandidates) return;
    if ((static_cast<double>(ring) + 0.5) * width < nearest + diagonal) continue;
    for (const Found& f : found) {
      if (f.distance <= nearest + diagonal) near.push_back(f.site);
    }
    if (near.size() > kMostCandidates) near.clear();
    return;
  }
}

template <class Scalar>
void NearestSites<Scalar>::make_grid(const Box& box, const Arena& arena) {
  const Eigen::VectorXd extent = box.extent();
  const double most = kCellsPerSite * sites_.count();
  const double width = std::pow(box.volume() / most, 1.0 / metric_.dimension());
  std::size_t cells = 1;
  for (int d = 0; d < metric_.dimension(); ++d) {
    const double count = std::clamp(std::round(extent[d] / width), 1.0, most);
    resolution_.push_back(static_cast<Index>(count));
    lower_.push_back(box.lower[d]);
    width_.push_back(extent[d] / count);
    inverse_width_.push_back(count / extent[d]);
    cells *= static_cast<std::size_t>(count);
    // Rings that wrap around onto themselves would find sites twice.
    if ((metric_.periodic() && count < 2 * kMostRings + 1) ||
        static_cast<double>(cells) > 4 * most) {
      resolution_.clear();
      return;
    }
  }

  std::vector<std::size_t> first(cells + 1, 0);
  std::vector<std::size_t> cell_of_site(static_cast<std::size_t>(sites_.count()));
  for (Index s = 0; s < sites_.count(); ++s) {
    cell_of_site[static_cast<std::size_t>(s)] = cell_of(sites_.at(s));
    ++first[cell_of_site[static_cast<std::size_t>(s)] + 1];
  }
  for (std::size_t g = 0; g < cells; ++g) first[g + 1] += first[g];
  std::vector<Index> by_cell(cell_of_site.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (Index s = 0; s < sites_.count(); ++s) {
    by_cell[next[cell_of_site[static_cast<std::size_t>(s)]]++] = s;
  }

  constexpr std::size_t kChunk = 1024;
  std::vector<std::vector<Index>> chunk_sites((cells + kChunk - 1) / kChunk);
  begin_.assign(cells + 1, 0);
  arena.for_each(chunk_sites.size(), 1, [&](std::size_t c) {
    std::vector<Index> near;
    for (std::size_t g = c * kChunk; g < std::min((c + 1) * kChunk, cells); ++g) {
      near.clear();
      sites_near(first, by_cell, g, near);
      begin_[g + 1] = static_cast<std::uint32_t>(near.size());
      chunk_sites[c].insert(chunk_sites[c].end(), near.begin(), near.end());
    }
  });
  for (std::size_t g = 0; g < cells; ++g) begin_[g + 1] += begin_[g];
  candidate_.reserve(begin_.back());
  for (const auto& part : chunk_sites) {
    candidate_.insert(candidate_.end(), part.begin(), part.end());
  }
  position_.reserve(candidate_.size() * resolution_.size());
  for (const Index site : candidate_) {
    position_.insert(position_.end(), sites_.at(site), sites_.at(site) + metric_.dimension());
  }
}

/// Looks points up in the grid, a batch at a time: the candidates of a batch are on their way from
/// memory while its points are placed.
template <class Scalar>
template <int Dimension, bool Periodic>
void NearestSites<Scalar>::look_up(const PointsView<Scalar>& points, std::span<const Index> which,
                                   Index* owner) const {
  constexpr std::size_t kBatch = 32;
  constexpr auto kWidth = static_cast<std::size_t>(Dimension);
  std::array<std::array<double, kWidth>, kBatch> query;
  std::array<std::size_t, kBatch> cell;
  for (std::size_t first = 0; first < which.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, which.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      std::copy_n(points[which[first + k]], kWidth, query[k].begin());
      cell[k] = cell_of(query[k].data());
      __builtin_prefetch(&begin_[cell[k]]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      __builtin_prefetch(position_.data() + begin_[cell[k]] * kWidth);
      __builtin_prefetch(candidate_.data() + begin_[cell[k]]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t begin = begin_[cell[k]];
      const std::uint32_t end = begin_[cell[k] + 1];
      if (begin == end) {
        owner[first + k] = tree_.nearest(query[k].data());
        continue;
      }
      std::uint32_t best = begin;
      double best_squared = std::numeric_limits<double>::infinity();
      for (std::uint32_t c = begin; c < end; ++c) {
        const double* position = &position_[c * kWidth];
        double squared = 0;
        for (std::size_t d = 0; d < kWidth; ++d) {
          double difference = query[k][d] - position[d];
          if constexpr (Periodic) difference = metric_.wrap(difference, static_cast<int>(d));
          squared += difference * difference;
        }
        best = squared < best_squared ? c : best;
        best_squared = squared < best_squared ? squared : best_squared;
      }
      owner[first + k] = candidate_[best];
    }
  }
}

template <class Scalar>
void NearestSites<Scalar>::operator()(const PointsView<Scalar>& points,
                                      std::span<const Index> which, Index* owner) const {
  if (resolution_.empty()) {
    std::vector<double> query(static_cast<std::size_t>(metric_.dimension()));
    for (const Index point : which) {
      std::copy_n(points[point], query.size(), query.begin());
      *owner++ = tree_.nearest(query.data());
    }
  } else if (metric_.dimension() == 2) {
    metric_.periodic() ? look_up<2, true>(points, which, owner)
                       : look_up<2, false>(points, which, owner);
  } else {
    metric_.periodic() ? look_up<3, true>(points, which, owner)
                       : look_up<3, false>(points, which, owner);
  }
}

template class NearestSites<float>;
template class NearestSites<double>;

}  // namespace ccvt
