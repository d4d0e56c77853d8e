#include "relax/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/products.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// In fewer dimensions bounding spheres tell more, more cheaply.
constexpr int kScreenDimensions = 6;
/// Sites in a block: small enough that both blocks of a pair of blocks stay in cache.
constexpr Index kBlockSites = 126;
static_assert(kBlockSites % kernels::kDotSites == 0);

/// All sites relative to their mean, in blocks; the touched sites of a block come first.
template <class Scalar>
class SiteBlocks {
 public:
  SiteBlocks(const SiteState& sites, const std::vector<std::uint8_t>& touched) : sites_(sites) {
    const int dimension = sites.dimension;
    mean_.assign(static_cast<std::size_t>(dimension), 0.0);
    for (Index s = 0; s < sites.count(); ++s) {
      for (int d = 0; d < dimension; ++d) mean_[static_cast<std::size_t>(d)] += sites.at(s)[d];
    }
    for (double& m : mean_) m /= sites.count();
    for (Index begin = 0; begin < sites.count(); begin += kBlockSites) {
      Block block;
      const Index end = std::min(begin + kBlockSites, sites.count());
      for (const bool wanted : {true, false}) {
        for (Index s = begin; s < end; ++s) {
          if ((touched[static_cast<std::size_t>(s)] != 0) == wanted) block.site.push_back(s);
        }
        if (wanted) block.touched = static_cast<Index>(block.site.size());
      }
      // Padding repeats the last site; nobody reads what comes out for it.
      for (Index k = 0; k < kBlockSites; ++k) {
        const Index s = block.site[static_cast<std::size_t>(std::min(k, end - begin - 1))];
        for (int d = 0; d < dimension; ++d) block.position.push_back(centred(s, d));
      }
      blocks_.push_back(std::move(block));
    }
  }

  struct Block {
    std::vector<Index> site;
    std::vector<Scalar> position;
    Index touched = 0;
  };

  [[nodiscard]] Index count() const { return static_cast<Index>(blocks_.size()); }
  [[nodiscard]] const Block& operator[](Index b) const {
    return blocks_[static_cast<std::size_t>(b)];
  }
  [[nodiscard]] Scalar centred(Index site, int d) const {
    return static_cast<Scalar>(sites_.at(site)[d] - mean_[static_cast<std::size_t>(d)]);
  }
  [[nodiscard]] double norm(Index site) const {
    double sum = 0;
    for (int d = 0; d < sites_.dimension; ++d) {
      sum += std::pow(sites_.at(site)[d] - mean_[static_cast<std::size_t>(d)], 2);
    }
    return std::sqrt(sum);
  }

 private:
  const SiteState& sites_;
  std::vector<double> mean_;
  std::vector<Block> blocks_;
};

/// A cell relative to its site, padded for the kernel.
template <class Scalar>
struct CentredCell {
  void load(const Cells<Scalar>& cells, const SiteState& sites, const SiteBlocks<Scalar>& blocks,
            Index site) {
    const Index count = cells.size(site);
    const Index step = kernels::dot_points<Scalar>();
    stride = (count + step - 1) / step * step;
    const auto padded = static_cast<std::size_t>(stride);
    block.resize(padded * static_cast<std::size_t>(sites.dimension));
    offset.assign(padded, Scalar{0});
    const Scalar* from = cells.block(site);
    Scalar* to = block.data();
    for (int d = 0; d < sites.dimension; ++d, from += count, to += stride) {
      const double origin = sites.at(site)[d];
      const Scalar own = blocks.centred(site, d);
      for (Index k = 0; k < count; ++k) {
        to[k] = static_cast<Scalar>(static_cast<double>(from[k]) - origin);
      }
      std::fill(to + count, to + stride, to[count - 1]);
      for (Index k = 0; k < stride; ++k) offset[static_cast<std::size_t>(k)] += to[k] * own;
    }
  }

  std::vector<Scalar> block;
  std::vector<Scalar> offset;  ///< point . own site
  Index stride = 0;
};

}  // namespace

bool screening_pays(const Metric& metric) {
  return !metric.periodic() && metric.dimension() > kScreenDimensions;
}

template <class Scalar>
Buffer<Pair> gaining_pairs(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                           const std::vector<std::uint8_t>& touched, const Arena& arena) {
  const auto charge = arena.phase(Phase::lists);
  const int dimension = metric.dimension();
  const SiteBlocks<Scalar> blocks(sites, touched);
  std::vector<double> norm(static_cast<std::size_t>(sites.count()));
  for (Index s = 0; s < sites.count(); ++s) norm[static_cast<std::size_t>(s)] = blocks.norm(s);

  std::vector<Pair> work;
  for (Index a = 0; a < blocks.count(); ++a) {
    for (Index b = a; b < blocks.count(); ++b) {
      if (blocks[a].touched + blocks[b].touched > 0) work.emplace_back(a, b);
    }
  }
  struct Scratch {
    CentredCell<Scalar> cell;
    std::vector<Scalar> largest;
  };
  PerWorker<Scratch> scratch(arena);
  const auto screen = [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int worker) {
    Scratch& own = scratch[worker];
    own.largest.resize(std::size_t{2} * kBlockSites * kBlockSites);
    // largest[k][l]: over the points of cell k of `from`, the largest point . (site l of `to`),
    // less the same with the point's own site.
    const auto fill = [&](const auto& from, const auto& to, Scalar* largest) {
      const auto cells_here = static_cast<Index>(from.site.size());
      for (Index k = 0; k < cells_here; ++k) {
        const Index targets = k < from.touched ? static_cast<Index>(to.site.size()) : to.touched;
        if (targets == 0) continue;
        arena.check();
        own.cell.load(cells, sites, blocks, from.site[static_cast<std::size_t>(k)]);
        const Index padded =
            (targets + kernels::kDotSites - 1) / kernels::kDotSites * kernels::kDotSites;
        kernels::largest_dots(own.cell.block.data(), own.cell.stride, dimension,
                              own.cell.offset.data(), to.position.data(), padded,
                              largest + k * kBlockSites);
      }
    };
    for (std::size_t w = begin; w < end; ++w) {
      const auto& a = blocks[work[w].first];
      const auto& b = blocks[work[w].second];
      Scalar* forth = own.largest.data();
      Scalar* back = forth + kBlockSites * kBlockSites;
      fill(a, b, forth);
      if (work[w].first == work[w].second) {
        back = forth;
      } else {
        fill(b, a, back);
      }
      for (Index k = 0; k < static_cast<Index>(a.site.size()); ++k) {
        for (Index l = 0; l < static_cast<Index>(b.site.size()); ++l) {
          const Index i = a.site[static_cast<std::size_t>(k)];
          const Index j = b.site[static_cast<std::size_t>(l)];
          if (k >= a.touched && l >= b.touched) continue;
          if (work[w].first == work[w].second && i >= j) continue;
          // M(i, j) = 2 max over p of (p - s_i) . (s_j - s_i) - |s_j - s_i|^2.
          const auto x = static_cast<std::size_t>(i);
          const auto y = static_cast<std::size_t>(j);
          const double gain = static_cast<double>(forth[k * kBlockSites + l]) +
                              static_cast<double>(back[l * kBlockSites + k]) -
                              metric.squared_distance(sites.at(i), sites.at(j));
          const double rounding = 4 * (dimension + 4) *
                                  (static_cast<double>(std::numeric_limits<Scalar>::epsilon()) *
                                       (sites.radius[x] + sites.radius[y]) * (norm[x] + norm[y]) +
                                   static_cast<double>(std::numeric_limits<Scalar>::denorm_min()));
          if (gain > -rounding) {
            out.emplace_back(std::min(i, j), std::max(i, j));
          }
        }
      }
    }
  };
  return std::move(pairs_by_first(arena, collect<Pair>(arena, work.size(), 1, screen),
                                  static_cast<std::size_t>(sites.count()))
                       .items);
}

template Buffer<Pair> gaining_pairs(const Metric&, const Cells<float>&, const SiteState&,
                                    const std::vector<std::uint8_t>&, const Arena&);
template Buffer<Pair> gaining_pairs(const Metric&, const Cells<double>&, const SiteState&,
                                    const std::vector<std::uint8_t>&, const Arena&);

}  // namespace ccvt
