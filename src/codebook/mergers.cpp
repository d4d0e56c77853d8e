#include "codebook/mergers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "exact/neighbourhoods.h"
#include "exact/packs.h"
#include "geometry/squares.h"
#include "kernels/nearest.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// Sites are looked at in groups of at most so many.
constexpr std::size_t kGroupSites = 64;
constexpr std::size_t kSitesPerGrain = 16;

/// What merging two cells costs by their sizes, times the squared distance of their sites.
double merging_share(double a, double b) { return a * b == 0 ? 0 : a * b / (a + b); }

/// Finds with which other each cell is merged at the least cost: the first of several. Sites are
/// looked at by groups of near ones, those first that may cost least; not at groups of which it is
/// known that all cost more, nor, with very many sites, at the last groups.
class Mergers {
 public:
  Mergers(std::span<const double> sites, std::size_t dimension, std::span<const double> size,
          const Arena& arena)
      : sites_(sites),
        dimension_(dimension),
        size_(size),
        most_(size.size() <= kExactMergers ? size.size() : kComparedMergers),
        near_(sites, dimension, kGroupSites, arena),
        radius_(near_.count(), 0.0),
        least_(near_.count(), std::numeric_limits<double>::infinity()) {
    const std::vector<double> means = near_.means(sites, dimension);
    centres_ = packs_of(means, dimension);
    for (const SiteNumber s : near_.order) rows_.push_back(at(s));
    for (std::size_t g = 0; g < near_.count(); ++g) {
      for (const SiteNumber s : near_.of(g)) {
        const double squared = squared_difference(at(s), means.data() + g * dimension, width());
        radius_[g] = std::max(radius_[g], std::sqrt(squared));
        least_[g] = std::min(least_[g], size[s]);
      }
    }
  }

  struct Scratch {
    std::vector<double> squared;
    std::vector<std::pair<double, std::size_t>> groups;
    std::vector<double> apart;
  };

  [[nodiscard]] Merger cheapest(SiteNumber i, Scratch& scratch) const {
    scratch.squared.resize(centres_.size() / dimension_);
    kernels::squared_distances(at(i), centres_.data(),
                               static_cast<Index>(scratch.squared.size()) / kernels::kPack, width(),
                               nullptr, scratch.squared.data());
    scratch.groups.clear();
    for (std::size_t g = 0; g < near_.count(); ++g) {
      const double apart =
          std::max(0.0, std::sqrt(scratch.squared[g]) * (1 - kSafe) - radius_[g] * (1 + kSafe));
      scratch.groups.emplace_back(merging_share(size_[i], least_[g]) * apart * apart * (1 - kSafe),
                                  g);
    }
    // Few groups come to be looked at: a heap takes less time than sorting all.
    std::make_heap(scratch.groups.begin(), scratch.groups.end(), std::greater<>());
    Merger merger{.i = i, .j = i};
    std::size_t looked = 0;  // at so many sites
    for (auto end = scratch.groups.end(); end != scratch.groups.begin(); --end) {
      const auto [bound, g] = scratch.groups.front();
      if (bound > merger.cost || looked >= most_) break;
      std::pop_heap(scratch.groups.begin(), end, std::greater<>());
      const auto others = near_.of(g);
      looked += others.size();
      scratch.apart.resize(others.size());
      kernels::squared_distances_of(rows_.data() + near_.begin[g],
                                    static_cast<Index>(others.size()), width(), at(i),
                                    scratch.apart.data());
      for (std::size_t k = 0; k < others.size(); ++k) {
        const SiteNumber j = others[k];
        if (j == i) continue;
        const double cost = merging_share(size_[i], size_[j]) * scratch.apart[k];
        if (cost < merger.cost || (cost == merger.cost && j < merger.j)) merger = {cost, i, j};
      }
    }
    return merger;
  }

 private:
  /// More than the rounding of what is compared.
  static constexpr double kSafe = 1e-9;
  [[nodiscard]] const double* at(SiteNumber s) const { return sites_.data() + s * dimension_; }
  [[nodiscard]] int width() const { return static_cast<int>(dimension_); }

  std::span<const double> sites_;
  std::size_t dimension_;
  std::span<const double> size_;
  std::size_t most_;  ///< sites that one is compared with
  Neighbourhoods near_;
  std::vector<const double*> rows_;  ///< positions in the groups' order
  std::vector<double> centres_;      ///< means of the groups, for the kernel
  std::vector<double> radius_;       ///< of each group, around its mean
  std::vector<double> least_;        ///< of each group, the size of the smallest cell
};

}  // namespace

std::vector<Merger> cheapest_mergers(std::span<const double> sites, std::size_t dimension,
                                     std::span<const double> size, const Arena& arena) {
  const Mergers pairs(sites, dimension, size, arena);
  PerWorker<Mergers::Scratch> scratch(arena);
  const Buffer<Merger> mergers = collect_together<Merger>(
      arena, size.size(), kSitesPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<Merger>& out, int worker) {
        for (const SiteNumber i : sites_between(begin, end)) {
          out.push_back(pairs.cheapest(i, scratch[worker]));
        }
      });
  return {mergers.data(), mergers.data() + mergers.size()};
}

}  // namespace ccvt
