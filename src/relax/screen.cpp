#include "relax/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/products.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// In fewer dimensions bounding spheres tell more, more cheaply.
constexpr int kScreenDimensions = 6;
/// Sites in a block: small enough that both blocks of a pair of blocks stay in cache.
constexpr std::size_t kBlockSites = 126;
static_assert(kBlockSites % kernels::kDotSites == 0);

/// All sites relative to their mean, in blocks; the touched sites of a block come first.
template <class Scalar>
class SiteBlocks {
 public:
  SiteBlocks(const SiteState& sites, const std::vector<std::uint8_t>& touched) : sites_(sites) {
    mean_.assign(sites.dimension, 0.0);
    for (const SiteNumber s : sites.all()) {
      for (std::size_t d = 0; d < sites.dimension; ++d) mean_[d] += sites.at(s)[d];
    }
    const auto count = static_cast<double>(sites.count());
    for (double& m : mean_) m /= count;
    for (std::size_t begin = 0; begin < sites.count(); begin += kBlockSites) {
      Block block;
      const auto members = sites_between(begin, std::min(begin + kBlockSites, sites.count()));
      for (const bool wanted : {true, false}) {
        for (const SiteNumber s : members) {
          if ((touched[s] != 0) == wanted) block.site.push_back(s);
        }
        if (wanted) block.touched = block.site.size();
      }
      // Padding repeats the last site; nobody reads what comes out for it.
      for (std::size_t k = 0; k < kBlockSites; ++k) {
        const SiteNumber s = block.site[std::min(k, block.site.size() - 1)];
        for (std::size_t d = 0; d < sites.dimension; ++d) block.position.push_back(centred(s, d));
      }
      blocks_.push_back(std::move(block));
    }
  }

  struct Block {
    std::vector<SiteNumber> site;
    std::vector<Scalar> position;
    std::size_t touched = 0;
  };

  [[nodiscard]] std::size_t count() const { return blocks_.size(); }
  [[nodiscard]] const Block& operator[](std::size_t b) const { return blocks_[b]; }
  [[nodiscard]] Scalar centred(SiteNumber site, std::size_t d) const {
    return static_cast<Scalar>(sites_.at(site)[d] - mean_[d]);
  }
  [[nodiscard]] double norm(SiteNumber site) const {
    double sum = 0;
    for (std::size_t d = 0; d < sites_.dimension; ++d) {
      sum += std::pow(sites_.at(site)[d] - mean_[d], 2);
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
            SiteNumber site) {
    const Index count = cells.size(site);
    const Index step = kernels::dot_points<Scalar>();
    stride = (count + step - 1) / step * step;
    const auto padded = static_cast<std::size_t>(stride);
    block.resize(padded * sites.dimension);
    offset.assign(padded, Scalar{0});
    const Scalar* from = cells.block(site);
    Scalar* to = block.data();
    for (std::size_t d = 0; d < sites.dimension; ++d, from += count, to += stride) {
      const double origin = sites.at(site)[d];
      const Scalar own = blocks.centred(site, d);
      for (Index k = 0; k < count; ++k) {
        to[k] = static_cast<Scalar>(from[k] - origin);
      }
      std::fill(to + count, to + stride, to[count - 1]);
      for (std::size_t k = 0; k < padded; ++k) offset[k] += to[k] * own;
    }
  }

  std::vector<Scalar> block;
  std::vector<Scalar> offset;  ///< point . own site
  Index stride = 0;
};

/// Tells of all pairs of sites in two blocks which may gain. One per worker: it owns scratch
/// memory.
template <class Scalar>
class BlockScreen {
 public:
  using Block = typename SiteBlocks<Scalar>::Block;

  BlockScreen(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
              const SiteBlocks<Scalar>& blocks, const std::vector<double>& norm, const Arena& arena)
      : metric_(metric),
        cells_(cells),
        sites_(sites),
        blocks_(blocks),
        norm_(norm),
        arena_(arena) {}

  /// What the points of a cell have for another site; both are of the same pair.
  struct Reach {
    Pair pair;
    bool of_first;  ///< the cell of the first site for the second one
    Scalar largest;
    auto operator<=>(const Reach&) const = default;
  };

  /// Appends the pairs that may gain of a site of `a` and one of `b`, which may be the same, of
  /// which at least one is touched.
  void append(const Block& a, const Block& b, std::vector<Pair>& out) {
    const bool same = &a == &b;
    find_largest(a, b, forth_);
    if (!same) find_largest(b, a, back_);
    const std::vector<Scalar>& back = same ? forth_ : back_;
    for (std::size_t k = 0; k < a.site.size(); ++k) {
      for (std::size_t l = 0; l < b.site.size(); ++l) {
        if (k >= a.touched && l >= b.touched) continue;
        if (same && a.site[k] >= b.site[l]) continue;
        if (may_gain(a.site[k], b.site[l], forth_[k * kBlockSites + l],
                     back[l * kBlockSites + k])) {
          out.push_back(Pair::ascending(a.site[k], b.site[l]));
        }
      }
    }
  }

  /// Of the same pairs, appends what cells of `a` that are here have for sites of `b`, where that
  /// may be enough for an exchange, whatever the other cell has.
  void append_own(const Block& a, const Block& b, const Tiling& tiling, std::vector<Reach>& out) {
    find_largest(a, b, forth_, &tiling);
    for (std::size_t k = 0; k < a.site.size(); ++k) {
      const SiteNumber own = a.site[k];
      if (!tiling.is_own(tiling.tile_of(own))) continue;
      for (std::size_t l = 0; l < b.site.size(); ++l) {
        const SiteNumber other = b.site[l];
        if ((k >= a.touched && l >= b.touched) || own == other) continue;
        const Scalar largest = forth_[k * kBlockSites + l];
        const double distance =
            std::sqrt(metric_.squared_distance(sites_.at(own), sites_.at(other)));
        const double most = sites_.radius[other] * distance + rounding(own, other);
        if (may_gain(own, other, largest, most)) {
          out.push_back({Pair::ascending(own, other), own < other, largest});
        }
      }
    }
  }

  /// M(i, j) = 2 max over p of (p - s_i) . (s_j - s_i) - |s_j - s_i|^2, and the same of j, sum to
  /// more than rounding can take away.
  [[nodiscard]] bool may_gain(SiteNumber i, SiteNumber j, double to_j, double to_i) const {
    const double gain = to_j + to_i - metric_.squared_distance(sites_.at(i), sites_.at(j));
    return gain > -rounding(i, j);
  }

 private:
  /// largest[k][l]: over the points of cell k of `from`, the largest point . (site l of `to`), less
  /// the same with the point's own site. Only of a rank's own cells, where `tiling` is given.
  void find_largest(const Block& from, const Block& to, std::vector<Scalar>& largest,
                    const Tiling* tiling = nullptr) {
    largest.resize(kBlockSites * kBlockSites);  // here, so that the worker touches it first
    for (std::size_t k = 0; k < from.site.size(); ++k) {
      const auto targets = static_cast<Index>(k < from.touched ? to.site.size() : to.touched);
      if (targets == 0) continue;
      if (tiling != nullptr && !tiling->is_own(tiling->tile_of(from.site[k]))) continue;
      arena_.check();
      cell_.load(cells_, sites_, blocks_, from.site[k]);
      const Index padded =
          (targets + kernels::kDotSites - 1) / kernels::kDotSites * kernels::kDotSites;
      kernels::largest_dots(cell_.block.data(), cell_.stride, metric_.dimension(),
                            cell_.offset.data(), to.position.data(), padded,
                            largest.data() + k * kBlockSites);
    }
  }

  [[nodiscard]] double rounding(SiteNumber i, SiteNumber j) const {
    return 4 * (metric_.dimension() + 4) *
           (std::numeric_limits<Scalar>::epsilon() * (sites_.radius[i] + sites_.radius[j]) *
                (norm_[i] + norm_[j]) +
            std::numeric_limits<Scalar>::denorm_min());
  }

  const Metric& metric_;
  const Cells<Scalar>& cells_;
  const SiteState& sites_;
  const SiteBlocks<Scalar>& blocks_;
  const std::vector<double>& norm_;
  const Arena& arena_;
  CentredCell<Scalar> cell_;
  std::vector<Scalar> forth_;
  std::vector<Scalar> back_;
};

}  // namespace

bool screening_pays(const Metric& metric) {
  return !metric.periodic() && metric.dimension() > kScreenDimensions;
}

template <class Scalar>
Buffer<Pair> gaining_pairs(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                           const std::vector<std::uint8_t>& touched, const Tiling& tiling,
                           const Arena& arena) {
  const auto charge = arena.phase(Phase::lists);
  const SiteBlocks<Scalar> blocks(sites, touched);
  std::vector<double> norm(sites.count());
  for (const SiteNumber s : sites.all()) norm[s] = blocks.norm(s);
  struct PairOfBlocks {
    std::size_t first;
    std::size_t second;
  };
  std::vector<PairOfBlocks> work;
  for (std::size_t a = 0; a < blocks.count(); ++a) {
    for (std::size_t b = a; b < blocks.count(); ++b) {
      if (blocks[a].touched + blocks[b].touched > 0) work.push_back({a, b});
    }
  }
  PerWorker<BlockScreen<Scalar>> screens(arena, {metric, cells, sites, blocks, norm, arena});
  if (tiling.ranks() == nullptr) {
    Buffer<Pair> gaining =
        collect<Pair>(arena, work.size(), 1,
                      [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int worker) {
                        for (std::size_t w = begin; w < end; ++w) {
                          const auto& [a, b] = work[w];
                          screens[worker].append(blocks[a], blocks[b], out);
                        }
                      });
    return std::move(pairs_by_first(arena, std::move(gaining), sites.count()).items);
  }
  // Each rank has what its own cells have for other sites; together they see both sides of a pair.
  using Reach = typename BlockScreen<Scalar>::Reach;
  const Buffer<Reach> own =
      collect<Reach>(arena, work.size(), 1,
                     [&](std::size_t begin, std::size_t end, std::vector<Reach>& out, int worker) {
                       for (std::size_t w = begin; w < end; ++w) {
                         const auto& [a, b] = work[w];
                         screens[worker].append_own(blocks[a], blocks[b], tiling, out);
                         if (a != b) screens[worker].append_own(blocks[b], blocks[a], tiling, out);
                       }
                     });
  std::vector<Reach> all = joined(tiling.ranks(), std::vector<Reach>(own.begin(), own.end()));
  std::sort(all.begin(), all.end());
  std::vector<Pair> gaining;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const auto& [pair, of_first, back] = all[k - 1];
    if (all[k].pair == pair && screens[0].may_gain(pair.first, pair.second, all[k].largest, back)) {
      gaining.push_back(pair);
    }
  }
  Buffer<Pair> result(gaining.size());
  std::copy(gaining.begin(), gaining.end(), result.begin());
  return result;
}

template Buffer<Pair> gaining_pairs(const Metric&, const Cells<float>&, const SiteState&,
                                    const std::vector<std::uint8_t>&, const Tiling&, const Arena&);
template Buffer<Pair> gaining_pairs(const Metric&, const Cells<double>&, const SiteState&,
                                    const std::vector<std::uint8_t>&, const Tiling&, const Arena&);

}  // namespace ccvt
