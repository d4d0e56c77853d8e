#include "relax/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/products.h"
#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/screen_cells.h"

namespace ccvt {
namespace {

/// In fewer dimensions bounding spheres tell more, more cheaply.
constexpr int kScreenDimensions = 6;
/// Sites in a block: small enough that both blocks of a pair of blocks stay in cache.
constexpr std::size_t kBlockSites = 126;
static_assert(kBlockSites % kernels::kDotSites == 0);

/// All sites in blocks; the touched sites of a block come first.
template <class Scalar>
class SiteBlocks {
 public:
  SiteBlocks(const SiteState& sites, const CentredSites<Scalar>& centred,
             const std::vector<std::uint8_t>& touched) {
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
        for (std::size_t d = 0; d < sites.dimension; ++d) {
          block.position.push_back(centred.at(s, d));
        }
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

 private:
  std::vector<Block> blocks_;
};

/// Tells of all pairs of sites in two blocks which may gain. One per worker: it owns scratch
/// memory.
template <class Scalar>
class BlockScreen {
 public:
  using Block = typename SiteBlocks<Scalar>::Block;

  BlockScreen(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
              const CentredSites<Scalar>& centred, const Arena& arena)
      : metric_(metric), cells_(cells), sites_(sites), centred_(centred), arena_(arena) {}

  /// The reach of a cell for another site.
  struct Reach {
    Pair pair;
    bool of_first;  ///< the cell of the first site for the second one
    Scalar reach;
    auto operator<=>(const Reach&) const = default;
  };

  /// Appends the pairs that may gain of a site of `a` and one of `b`, which may be the same, of
  /// which at least one is touched. `reaches`: where to keep what is found, or none.
  void append(const Block& a, const Block& b, const std::vector<std::uint8_t>& touched,
              Reaches<Scalar>* reaches, std::vector<Pair>& out) {
    const bool same = &a == &b;
    find_largest(a, b, forth_);
    if (!same) find_largest(b, a, back_);
    const std::vector<Scalar>& back = same ? forth_ : back_;
    for (std::size_t k = 0; k < a.site.size(); ++k) {
      const SiteNumber i = a.site[k];
      for (std::size_t l = 0; l < b.site.size(); ++l) {
        const SiteNumber j = b.site[l];
        if (k >= a.touched && l >= b.touched) continue;
        if (same && i >= j) continue;
        const double distance = metric_.squared_distance(sites_.at(i), sites_.at(j));
        const double rounding = centred_.rounding(i, j);
        const auto to_j = reach_of<Scalar>(forth_[k * kBlockSites + l], distance, rounding);
        const auto to_i = reach_of<Scalar>(back[l * kBlockSites + k], distance, rounding);
        if (!(to_j + to_i <= 0) && (touched[i] | touched[j]) != 0) {
          out.push_back(Pair::ascending(i, j));
        }
        if (reaches != nullptr) {
          reaches->of(i)[j] = to_j;
          reaches->of(j)[i] = to_i;
        }
      }
    }
  }

  /// Of the same pairs, appends the reaches of cells of `a` that are here for sites of `b`, where
  /// they may be enough for an exchange, whatever the other cell's is.
  void append_own(const Block& a, const Block& b, const Tiling& tiling, std::vector<Reach>& out) {
    for_own(a, b, tiling, [&](SiteNumber own, SiteNumber other, double to_other) {
      const double distance = metric_.squared_distance(sites_.at(own), sites_.at(other));
      const double rounding = centred_.rounding(own, other);
      const auto reach = reach_of<Scalar>(to_other, distance, rounding);
      const double largest = sites_.radius[other] * std::sqrt(distance) + rounding;
      if (!(reach + reach_of<Scalar>(largest, distance, rounding) <= 0)) {
        out.push_back({Pair::ascending(own, other), own < other, reach});
      }
    });
  }
  /// Keeps all of these.
  void keep_own(const Block& a, const Block& b, const Tiling& tiling, Reaches<Scalar>& reaches) {
    for_own(a, b, tiling, [&](SiteNumber own, SiteNumber other, double to_other) {
      reaches.of(own)[other] =
          reach_of<Scalar>(to_other, metric_.squared_distance(sites_.at(own), sites_.at(other)),
                           centred_.rounding(own, other));
    });
  }

 private:
  /// Calls visit(own, other, largest) for the cells of `a` that are here and the sites of `b`, of
  /// which one is touched: see find_largest().
  template <class Visit>
  void for_own(const Block& a, const Block& b, const Tiling& tiling, const Visit& visit) {
    find_largest(a, b, forth_, &tiling);
    for (std::size_t k = 0; k < a.site.size(); ++k) {
      const SiteNumber own = a.site[k];
      if (!tiling.is_own(tiling.tile_of(own))) continue;
      for (std::size_t l = 0; l < b.site.size(); ++l) {
        const SiteNumber other = b.site[l];
        if ((k >= a.touched && l >= b.touched) || own == other) continue;
        visit(own, other, forth_[k * kBlockSites + l]);
      }
    }
  }

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
      cell_.load(cells_, sites_, centred_, from.site[k]);
      const Index padded =
          (targets + kernels::kDotSites - 1) / kernels::kDotSites * kernels::kDotSites;
      kernels::largest_dots(cell_.block.data(), cell_.stride, metric_.dimension(),
                            cell_.offset.data(), to.position.data(), padded,
                            largest.data() + k * kBlockSites);
    }
  }

  const Metric& metric_;
  const Cells<Scalar>& cells_;
  const SiteState& sites_;
  const CentredSites<Scalar>& centred_;
  const Arena& arena_;
  CentredCell<Scalar> cell_;
  std::vector<Scalar> forth_;
  std::vector<Scalar> back_;
};

/// Two blocks, or one twice, with a touched site.
template <class Scalar>
struct PairOfBlocks {
  using Block = typename SiteBlocks<Scalar>::Block;
  const Block& first;
  const Block& second;
};

template <class Scalar>
std::vector<PairOfBlocks<Scalar>> touched_pairs(const SiteBlocks<Scalar>& blocks) {
  std::vector<PairOfBlocks<Scalar>> pairs;
  for (std::size_t a = 0; a < blocks.count(); ++a) {
    for (std::size_t b = a; b < blocks.count(); ++b) {
      if (blocks[a].touched + blocks[b].touched > 0) pairs.push_back({blocks[a], blocks[b]});
    }
  }
  return pairs;
}

/// Keeps the reaches of a rank's own cells, for all sites.
template <class Scalar>
void keep_own(const SiteBlocks<Scalar>& blocks, const Tiling& tiling,
              PerWorker<BlockScreen<Scalar>>& screens, const Arena& arena,
              Reaches<Scalar>& reaches) {
  const std::size_t count = blocks.count();
  arena.for_ranges(count * count, 1, [&](std::size_t w, std::size_t, int worker) {
    screens[worker].keep_own(blocks[w / count], blocks[w % count], tiling, reaches);
  });
}

/// Of all ranks. Each has the reaches of its own cells; together they see both sides of a pair.
template <class Scalar>
Buffer<Pair> gaining_of_ranks(const SiteBlocks<Scalar>& blocks, const Tiling& tiling,
                              PerWorker<BlockScreen<Scalar>>& screens, const Arena& arena) {
  const auto work = touched_pairs(blocks);
  using Reach = typename BlockScreen<Scalar>::Reach;
  const Buffer<Reach> own =
      collect<Reach>(arena, work.size(), 1,
                     [&](std::size_t begin, std::size_t end, std::vector<Reach>& out, int worker) {
                       for (std::size_t w = begin; w < end; ++w) {
                         const auto& [a, b] = work[w];
                         screens[worker].append_own(a, b, tiling, out);
                         if (&a != &b) screens[worker].append_own(b, a, tiling, out);
                       }
                     });
  std::vector<Reach> all = joined(tiling.ranks(), std::vector<Reach>(own.begin(), own.end()));
  std::sort(all.begin(), all.end());
  std::vector<Pair> gaining;
  for (std::size_t k = 1; k < all.size(); ++k) {
    const auto& [pair, of_first, back] = all[k - 1];
    if (all[k].pair == pair && !(all[k].reach + back <= 0)) gaining.push_back(pair);
  }
  Buffer<Pair> result(gaining.size());
  std::copy(gaining.begin(), gaining.end(), result.begin());
  return result;
}

}  // namespace

bool screening_pays(const Metric& metric) {
  return !metric.periodic() && metric.dimension() > kScreenDimensions;
}

/// Where the reaches of all cells for all sites are to be kept from now on, if anywhere.
template <class Scalar>
Reaches<Scalar>* Screen<Scalar>::start_keeping(const Cells<Scalar>& cells, const Tiling& tiling) {
  if (cells.site_count() * cells.site_count() > most_kept_) return nullptr;
  if (!reaches_) reaches_.emplace(cells, tiling);
  return &*reaches_;
}

template <class Scalar>
Buffer<Pair> Screen<Scalar>::gaining(const Cells<Scalar>& cells, const SiteState& sites,
                                     const std::vector<std::uint8_t>& touched, const Tiling& tiling,
                                     const Arena& arena) {
  const auto charge = arena.phase(Phase::lists);
  const CentredSites<Scalar> centred(sites);
  const auto sorted = [&](Buffer<Pair> pairs) {
    return std::move(pairs_by_first(arena, std::move(pairs), sites.count()).items);
  };
  if (reaches_ && reaches_->known()) {
    return sorted(reaches_->gaining(metric_, cells, sites, centred, touched, arena));
  }
  PerWorker<BlockScreen<Scalar>> screens(arena, {metric_, cells, sites, centred, arena});
  Reaches<Scalar>* const kept = start_keeping(cells, tiling);
  const std::vector<std::uint8_t> all(touched.size(), 1);
  const SiteBlocks<Scalar> blocks(sites, centred, kept != nullptr ? all : touched);
  if (tiling.ranks() != nullptr) {
    if (kept == nullptr) return gaining_of_ranks(blocks, tiling, screens, arena);
    keep_own(blocks, tiling, screens, arena, *kept);
    kept->set_known(cells, sites, arena);
    return sorted(kept->known_gaining(touched, arena));
  }
  const auto work = touched_pairs(blocks);
  Buffer<Pair> gaining =
      collect<Pair>(arena, work.size(), 1,
                    [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int worker) {
                      for (std::size_t w = begin; w < end; ++w) {
                        screens[worker].append(work[w].first, work[w].second, touched, kept, out);
                      }
                    });
  if (kept != nullptr) kept->set_known(cells, sites, arena);
  return sorted(std::move(gaining));
}

template class Screen<float>;
template class Screen<double>;

}  // namespace ccvt
