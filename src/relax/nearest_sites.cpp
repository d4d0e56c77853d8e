#include "relax/nearest_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ccvt {
namespace {

/// Blocks a site. A block has 2^D cells.
constexpr double kBlocksPerSite = 1;
/// A cell with more sites to choose from asks the tree, and so does a block that has more around
/// it, or finds none within so many rings of blocks.
constexpr std::size_t kMostCandidates = 24;
constexpr std::size_t kMostAround = 160;
constexpr Index kMostRings = 3;
/// Rings that wrap around onto themselves would find sites twice.
constexpr Index kFewestBlocks = 2 * kMostRings + 1;

}  // namespace

template <class Scalar>
NearestSites<Scalar>::NearestSites(const Metric& metric, const SiteState& sites, const Box& box,
                                   std::size_t queries, const Arena& arena)
    : metric_(metric), sites_(sites), tree_(metric, sites.position) {
  const bool pays = static_cast<double>(queries) > 8.0 * sites.count();
  const bool flat = metric.dimension() == 2 || metric.dimension() == 3;
  if (flat && pays && box.extent().minCoeff() > 0) make_grid(box, arena);
}

template <class Scalar>
std::size_t NearestSites<Scalar>::cell_of(const double* position) const {
  std::size_t block = 0;
  std::size_t child = 0;
  for (std::size_t d = blocks_.size(); d-- > 0;) {
    const auto k =
        static_cast<std::size_t>(std::clamp((position[d] - lower_[d]) * inverse_width_[d], 0.0,
                                            static_cast<double>(2 * blocks_[d] - 1)));
    block = block * static_cast<std::size_t>(blocks_[d]) + k / 2;
    child = 2 * child + k % 2;
  }
  return (block << blocks_.size()) + child;
}

/// Visits the blocks whose largest offset from `centre` along any dimension is `ring`.
template <class Scalar>
template <class Visit>
void NearestSites<Scalar>::for_ring(const Index* centre, Index ring, Visit visit) const {
  const auto recurse = [&](auto& self, std::size_t d, std::size_t block, bool on_ring) -> void {
    const Index count = blocks_[d];
    // Only the two ends reach the ring when no other dimension can.
    const Index step = d == 0 && !on_ring && ring > 0 ? 2 * ring : 1;
    for (Index offset = -ring; offset <= ring; offset += step) {
      Index k = centre[d] + offset;
      if (k < 0 || k >= count) {
        if (!metric_.periodic()) continue;
        k += k < 0 ? count : -count;
      }
      const bool reaches = on_ring || offset == ring || offset == -ring;
      const std::size_t next =
          block * static_cast<std::size_t>(count) + static_cast<std::size_t>(k);
      if (d > 0) {
        self(self, d - 1, next, reaches);
      } else {
        visit(next);
      }
    }
  };
  recurse(recurse, blocks_.size() - 1, 0, false);
}

/// The sites that can be nearest to a point of a block, by their offset from its centre: with the
/// nearest to the centre at distance r, those within r and the block's diagonal. None when there
/// are too many or they are too far.
template <class Scalar>
void NearestSites<Scalar>::sites_around(const SitesByBlock& sites, const Index* place,
                                        const double* centre, std::vector<Offset>& around) const {
  around.clear();
  const std::size_t dimension = blocks_.size();
  double nearest = std::numeric_limits<double>::infinity();
  for (Index ring = 0; ring <= kMostRings; ++ring) {
    for_ring(place, ring, [&](std::size_t block) {
      for (std::size_t k = sites.first[block]; k < sites.first[block + 1]; ++k) {
        Offset found{sites.site[k], 0, {}};
        for (std::size_t d = 0; d < dimension; ++d) {
          found.from_centre[d] =
              metric_.wrap(sites.position[k * dimension + d] - centre[d], static_cast<int>(d));
          found.squared += found.from_centre[d] * found.from_centre[d];
        }
        nearest = std::min(nearest, found.squared);
        around.push_back(found);
      }
    });
    if (around.size() > kMostAround) break;
    const double reach = std::sqrt(nearest) + diagonal_;
    if ((static_cast<double>(ring) + 0.5) * 2 * least_width_ < reach) continue;
    std::erase_if(around, [&](const Offset& o) { return o.squared > reach * reach; });
    // Of a site farther than this another image may be the nearer one at the block's far side.
    const auto ambiguous = [&](const Offset& o) {
      for (std::size_t d = 0; d < dimension; ++d) {
        if (std::abs(o.from_centre[d]) + 2 * width_[d] > metric_.extent()[d] / 2) return true;
      }
      return false;
    };
    if (metric_.periodic() && std::any_of(around.begin(), around.end(), ambiguous)) break;
    return;
  }
  around.clear();
}

/// Of the sites around a block, those that no other keeps from being nearest in the region
/// `cells_wide` around `centre` (from the block's centre): s is out when the nearest to the
/// region's centre, c, is nearer than s in all of it, which is when it is at each of its corners,
/// as |x - s|^2 - |x - c|^2 is linear in x.
template <class Scalar>
void NearestSites<Scalar>::candidates_of(const std::vector<Offset>& around, const double* centre,
                                         double cells_wide, std::vector<Offset>& near) const {
  near.clear();
  const std::size_t dimension = blocks_.size();
  const auto squared = [&](const Offset& o) {
    double sum = 0;
    for (std::size_t d = 0; d < dimension; ++d) {
      const double difference = o.from_centre[d] - centre[d];
      sum += difference * difference;
    }
    return sum;
  };
  const Offset* central = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Offset& o : around) {
    const double distance = squared(o);
    if (distance < least) {
      least = distance;
      central = &o;
    }
  }
  for (const Offset& o : around) {
    double at_best_corner = squared(o) - least;
    for (std::size_t d = 0; d < dimension; ++d) {
      at_best_corner -=
          cells_wide * slack_width_[d] * std::abs(o.from_centre[d] - central->from_centre[d]);
    }
    if (at_best_corner <= 0) near.push_back(o);
  }
}

/// False when there are too few blocks for the rings, or too many for the memory.
template <class Scalar>
bool NearestSites<Scalar>::cut_into_blocks(const Box& box) {
  const Eigen::VectorXd extent = box.extent();
  const double most = std::max(1.0, kBlocksPerSite * sites_.count());
  const double block_width = std::pow(box.volume() / most, 1.0 / metric_.dimension());
  double all = 1;
  double diagonal_squared = 0;
  double farthest = 0;
  for (int d = 0; d < metric_.dimension(); ++d) {
    const double count = std::clamp(std::round(extent[d] / block_width), 1.0, most);
    blocks_.push_back(static_cast<Index>(count));
    lower_.push_back(box.lower[d]);
    width_.push_back(extent[d] / (2 * count));
    inverse_width_.push_back(2 * count / extent[d]);
    all *= count;
    diagonal_squared += 4 * width_.back() * width_.back();
    farthest = std::max({farthest, std::abs(box.lower[d]), std::abs(box.upper[d])});
    if ((metric_.periodic() && count < kFewestBlocks) || all > 4 * most) return false;
  }
  // Rounding may put a point into the cell next to its own.
  diagonal_ = std::sqrt(diagonal_squared) * (1 + 1e-9) + 1e-15 * farthest;
  least_width_ = *std::min_element(width_.begin(), width_.end());
  for (const double width : width_) slack_width_.push_back(width * (1 + 1e-9) + 1e-15 * farthest);
  return true;
}

template <class Scalar>
auto NearestSites<Scalar>::sort_by_block(std::size_t blocks) const -> SitesByBlock {
  SitesByBlock sorted;
  sorted.first.assign(blocks + 1, 0);
  std::vector<std::size_t> block_of(static_cast<std::size_t>(sites_.count()));
  for (Index s = 0; s < sites_.count(); ++s) {
    const std::size_t block = cell_of(sites_.at(s)) >> blocks_.size();
    block_of[static_cast<std::size_t>(s)] = block;
    ++sorted.first[block + 1];
  }
  for (std::size_t b = 0; b < blocks; ++b) sorted.first[b + 1] += sorted.first[b];
  sorted.site.resize(block_of.size());
  sorted.position.resize(sites_.position.size());
  std::vector<std::size_t> next(sorted.first.begin(), sorted.first.end() - 1);
  for (Index s = 0; s < sites_.count(); ++s) {
    const std::size_t place = next[block_of[static_cast<std::size_t>(s)]]++;
    sorted.site[place] = s;
    std::copy_n(sites_.at(s), blocks_.size(), &sorted.position[place * blocks_.size()]);
  }
  return sorted;
}

template <class Scalar>
void NearestSites<Scalar>::make_grid(const Box& box, const Arena& arena) {
  if (!cut_into_blocks(box)) {
    blocks_.clear();
    return;
  }
  const std::size_t dimension = blocks_.size();
  const std::size_t children = std::size_t{1} << dimension;
  std::size_t blocks = 1;
  for (const Index count : blocks_) blocks *= static_cast<std::size_t>(count);
  const SitesByBlock sites = sort_by_block(blocks);

  constexpr std::size_t kChunk = 256;
  struct Chunk {
    std::vector<Index> site;
    std::vector<double> position;
  };
  std::vector<Chunk> chunks((blocks + kChunk - 1) / kChunk);
  begin_.assign(blocks * children + 1, 0);
  arena.for_each(chunks.size(), 1, [&](std::size_t c) {
    std::vector<Offset> around;
    std::vector<Offset> in_block;
    std::vector<Offset> in_cell;
    std::array<Index, kMostDimensions> place{};
    std::array<double, kMostDimensions> centre{};
    const std::array<double, kMostDimensions> here{};
    std::array<double, kMostDimensions> cell_centre{};
    for (std::size_t b = c * kChunk; b < std::min((c + 1) * kChunk, blocks); ++b) {
      std::size_t rest = b;
      for (std::size_t d = 0; d < dimension; ++d) {
        const auto count = static_cast<std::size_t>(blocks_[d]);
        place[d] = static_cast<Index>(rest % count);
        rest /= count;
        centre[d] = lower_[d] + (2 * static_cast<double>(place[d]) + 1) * width_[d];
      }
      sites_around(sites, place.data(), centre.data(), around);
      candidates_of(around, here.data(), 2, in_block);
      for (std::size_t child = 0; child < children; ++child) {
        for (std::size_t d = 0; d < dimension; ++d) {
          cell_centre[d] = ((child >> d) % 2 == 0 ? -0.5 : 0.5) * width_[d];
        }
        candidates_of(in_block, cell_centre.data(), 1, in_cell);
        if (in_cell.size() > kMostCandidates) in_cell.clear();
        begin_[b * children + child + 1] = static_cast<std::uint32_t>(in_cell.size());
        for (const Offset& o : in_cell) {
          chunks[c].site.push_back(o.site);
          for (std::size_t d = 0; d < dimension; ++d) {
            chunks[c].position.push_back(centre[d] + o.from_centre[d]);
          }
        }
      }
    }
  });
  std::size_t candidates = 0;
  for (const Chunk& chunk : chunks) candidates += chunk.site.size();
  if (candidates > std::numeric_limits<std::uint32_t>::max()) {
    blocks_.clear();
    begin_ = {};
    return;
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  candidate_.reserve(begin_.back());
  position_.reserve(candidate_.capacity() * dimension);
  for (const Chunk& chunk : chunks) {
    candidate_.insert(candidate_.end(), chunk.site.begin(), chunk.site.end());
    position_.insert(position_.end(), chunk.position.begin(), chunk.position.end());
  }
}

/// Looks points up in the grid, a batch at a time: the candidates of a batch are on their way from
/// memory while its points are placed.
template <class Scalar>
template <int Dimension>
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
          const double difference = query[k][d] - position[d];
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
  if (blocks_.empty()) {
    std::vector<double> query(static_cast<std::size_t>(metric_.dimension()));
    for (const Index point : which) {
      std::copy_n(points[point], query.size(), query.begin());
      *owner++ = tree_.nearest(query.data());
    }
  } else if (metric_.dimension() == 2) {
    look_up<2>(points, which, owner);
  } else {
    look_up<3>(points, which, owner);
  }
}

template class NearestSites<float>;
template class NearestSites<double>;

}  // namespace ccvt
