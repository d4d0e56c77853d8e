#include "relax/reaches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "parallel/bytes.h"
#include "parallel/together.h"
#include "relax/reach_steps.h"

namespace ccvt {
namespace {

/// Rows and columns that are gone through together, since reaches both ways of a pair are wanted.
constexpr std::size_t kTile = 64;
/// Sites that a cell is multiplied with at once: they stay in cache beside it.
constexpr std::size_t kSitesAtOnce = 126;
static_assert(kSitesAtOnce % kernels::kDotSites == 0);
constexpr std::size_t kRows = ReachSteps<float>::kRows;
/// Cells whose points that came are multiplied together.
constexpr std::size_t kCellsAtOnce = 2 * kRows;

/// Calls visit(i, j, out) for each i < j, in parallel by tiles.
template <class Visit>
Buffer<Pair> for_pairs_of_sites(const Arena& arena, std::size_t sites, const Visit& visit) {
  const std::size_t tiles = (sites + kTile - 1) / kTile;
  const auto tile = [&](std::size_t t) {
    return sites_between(t * kTile, std::min((t + 1) * kTile, sites));
  };
  return collect<Pair>(arena, tiles * tiles, 1,
                       [&](std::size_t w, std::size_t, std::vector<Pair>& out, int) {
                         const std::size_t a = w / tiles;
                         const std::size_t b = w % tiles;
                         if (a > b) return;
                         for (const SiteNumber i : tile(a)) {
                           for (const SiteNumber j : a == b ? tile(b).after(i) : tile(b)) {
                             visit(i, j, out);
                           }
                         }
                       });
}

/// By how much |p - site|^2 grows over the points of a cell, at most and rounded up, with a step to
/// where the site is. `along`: scratch memory.
template <class Scalar>
double growth(const Cells<Scalar>& cells, const SiteState& sites, SiteNumber site,
              const double* step, std::vector<double>& along) {
  const auto count = static_cast<std::size_t>(cells.size(site));
  along.assign(count, 0.0);
  const Scalar* x = cells.block(site);
  double squared = 0;
  for (std::size_t d = 0; d < sites.dimension; ++d, x += count) {
    const double origin = sites.at(site)[d];
    squared += step[d] * step[d];
    for (std::size_t k = 0; k < count; ++k) along[k] += (x[k] - origin) * step[d];
  }
  const double terms = squared + 2 * std::sqrt(squared) * sites.radius[site];
  const double rounding = 4 * (static_cast<double>(sites.dimension) + 4) *
                          std::numeric_limits<double>::epsilon() * terms;
  return -squared - 2 * *std::min_element(along.begin(), along.end()) + rounding;
}

/// A reach that is known; where a product of floats has overflowed, it may be any.
template <class Scalar>
Scalar at_most(Scalar reach) {
  const bool known = std::abs(reach) <= std::numeric_limits<Scalar>::max();
  return known ? reach : std::numeric_limits<Scalar>::infinity();
}

}  // namespace

template <class Scalar>
Reaches<Scalar>::Reaches(const Cells<Scalar>& cells, const Tiling& tiling)
    : count_(cells.site_count()),
      own_(tiling.own_sites()),
      ranks_(tiling.ranks()),
      reach_(own_.size() * count_),
      back_(ranks_ == nullptr ? 0 : reach_.size()),
      marked_(reach_.size()) {
  std::size_t first = 0;
  for (const SiteNumber s : own_) {
    first_.push_back(first);
    first += cells.points(s).size();
  }
  counted_.resize(first);
  if (ranks_ == nullptr) return;
  for (const SiteNumber s : cells.sites()) rank_of_.push_back(tiling.rank_of(tiling.tile_of(s)));
}

template <class Scalar>
void Reaches<Scalar>::set_known(const Cells<Scalar>& cells, const SiteState& sites,
                                const Arena& arena) {
  position_ = sites.position;
  arena.for_each(own_.size(), 16, [&](std::size_t k) {
    auto counted = counted_.begin() + static_cast<std::ptrdiff_t>(first_[k]);
    for (const PointOfAll p : cells.points(SiteNumber(*own_.begin() + k))) *counted++ = p;
  });
  known_ = true;
}

/// Brings the reaches of all cells for own sites, of the pairs for which wanted(i, j), which is
/// wanted(j, i).
template <class Scalar>
template <class Wanted>
void Reaches<Scalar>::exchange(const Wanted& wanted) {
  if (ranks_ == nullptr) return;
  const auto of_rank = [this](int rank) {
    const auto [begin, end] = std::equal_range(rank_of_.begin(), rank_of_.end(), rank);
    return NumberRange(SiteNumber(begin - rank_of_.begin()), SiteNumber(end - rank_of_.begin()));
  };
  std::vector<Scalar> row;
  std::vector<ByteWriter> to(static_cast<std::size_t>(ranks_->count()));
  for (int rank = 0; rank < ranks_->count(); ++rank) {
    for (const SiteNumber i : own_) {
      row.clear();
      for (const SiteNumber j : of_rank(rank)) {
        if (wanted(i, j)) row.push_back(of(i)[j]);
      }
      to[static_cast<std::size_t>(rank)].put(std::span<const Scalar>(row));
    }
  }
  const std::vector<Ranks::Bytes> come = exchanged(*ranks_, std::move(to));
  for (int rank = 0; rank < ranks_->count(); ++rank) {
    ByteReader message(come[static_cast<std::size_t>(rank)]);
    for (const SiteNumber j : of_rank(rank)) {
      row.clear();
      for (const SiteNumber i : own_) {
        if (wanted(i, j)) row.push_back(0);
      }
      message.get(std::span(row));
      const Scalar* next = row.data();
      for (const SiteNumber i : own_) {
        if (wanted(i, j)) back_[row_of(i) * count_ + j] = *next++;
      }
    }
  }
}

/// After the sites' steps, by which |p - s_i|^2 grows by so much. `products`: -s_i . step of each.
///
/// With q = p - s_i, -|p - s_j|^2 grows by 2 q . step + |s_i - s_j + step|^2 - |s_i - s_j|^2, which
/// is 2 q . step + |step|^2 - 2 s_j . step + 2 s_i . step.
template <class Scalar>
void Reaches<Scalar>::follow_steps(const ReachSteps<Scalar>& steps, SiteNumber i, double grows,
                                   const float* products, const std::vector<SiteNumber>* touched) {
  constexpr Scalar kEpsilon = 8 * std::numeric_limits<Scalar>::epsilon();
  const auto own = static_cast<Scalar>(grows + kEpsilon * std::abs(grows) + steps.underflow);
  const Scalar radius = steps.radius[i] * (1 + kEpsilon);
  const Scalar norm_i = steps.norm[i];
  const Scalar* const norm = steps.norm.data();
  const Scalar* const radii = steps.radius.data();
  const Scalar* const length = steps.length.data();
  const Scalar* const constant = steps.constant.data();
  const Scalar share = steps.share;
  const Scalar pair_share = steps.pair_share;
  Scalar* const reach = of(i);
  const auto follow = [=](std::size_t j) {
    const Scalar norms = norm_i + norm[j];
    const Scalar rounding =
        share * (norms + length[j]) * length[j] + pair_share * (radius + radii[j]) * norms;
    const Scalar before = reach[j];
    const Scalar after = before + own + 2 * radius * length[j] + rounding +
                         (constant[j] - 2 * static_cast<Scalar>(products[j]));
    reach[j] = at_most(after + kEpsilon * (std::abs(before) + std::abs(after)));
  };
  if (touched == nullptr) {
    for (std::size_t j = 0; j < count_; ++j) follow(j);
  } else {
    for (const SiteNumber j : *touched) follow(j);
  }
  reach[i] = 0;
}

/// A point that came to a cell.
template <class Scalar>
struct Reaches<Scalar>::Arrival {
  /// Writes the point's position relative to the mean of the sites.
  Arrival(const Cells<Scalar>& cells, const SiteState& sites, const CentredSites<Scalar>& centred,
          Came came, float* row)
      : site(came.site) {
    const Scalar* x = cells.block(site) + came.place;
    const auto size = static_cast<std::size_t>(cells.size(site));
    double own = 0;
    double squared = 0;
    for (std::size_t d = 0; d < sites.dimension; ++d, x += size) {
      const double from_site = *x - sites.at(site)[d];
      const double from_mean = from_site + centred.at(site, d);
      row[d] = static_cast<float>(from_mean);
      own += from_site * from_site;
      squared += from_mean * from_mean;
    }
    norm = static_cast<Scalar>(std::sqrt(squared));
    constant = static_cast<Scalar>(own - squared);
  }

  SiteNumber site;
  Scalar norm;
  Scalar constant;  ///< |p - site|^2 - |p|^2
};

/// Counts a point in. `products`: -p . site of each.
template <class Scalar>
void Reaches<Scalar>::include(const ReachSteps<Scalar>& steps, const Arrival& point,
                              const float* products) {
  const Scalar norm_i = steps.norm[point.site];
  const Scalar radius = steps.radius[point.site];
  const Scalar* const norm = steps.norm.data();
  const Scalar* const squared_norm = steps.squared_norm.data();
  const Scalar* const radii = steps.radius.data();
  const Scalar share = steps.share;
  const Scalar pair_share = steps.pair_share;
  const auto underflow = static_cast<Scalar>(steps.underflow);
  const Scalar length = point.norm;
  const Scalar constant = point.constant;
  Scalar* const reach = of(point.site);
  for (std::size_t j = 0; j < count_; ++j) {
    const Scalar norms = length + norm[j];
    const Scalar rounding =
        share * norms * norms + pair_share * (radius + radii[j]) * (norm_i + norm[j]) + underflow;
    const Scalar there =
        constant - squared_norm[j] - 2 * static_cast<Scalar>(products[j]) + rounding;
    reach[j] = std::max(reach[j], at_most(there));
  }
  reach[point.site] = 0;
}

/// From the positions and cells before to these.
template <class Scalar>
void Reaches<Scalar>::follow(const Cells<Scalar>& cells, const SiteState& sites,
                             const CentredSites<Scalar>& centred,
                             const std::vector<std::uint8_t>& touched, const Arena& arena) {
  const ReachSteps<Scalar> steps(sites, centred, position_, arena);
  std::vector<SiteNumber> all_touched;
  for (const SiteNumber s : sites.all()) {
    if (touched[s] != 0) all_touched.push_back(s);
  }
  struct Scratch {
    std::vector<float> product;
    std::vector<float> lowest;
    std::vector<float> row;
    std::vector<double> along;
    std::vector<Came> came;
  };
  PerWorker<Scratch> scratch(arena);
  const std::array<float, kRows> none{};
  const std::size_t first_own = *own_.begin();
  arena.for_ranges(own_.size(), kCellsAtOnce, [&](std::size_t from, std::size_t to, int worker) {
    const std::size_t begin = first_own + from;
    const std::size_t end = first_own + to;
    Scratch& own = scratch[worker];
    std::vector<float>& product = own.product;
    std::vector<float>& lowest = own.lowest;
    std::vector<float>& row = own.row;
    std::vector<Came>& came = own.came;
    product.resize(kRows * steps.stride);
    lowest.resize(steps.stride);
    row.resize(kRows * steps.dimension);
    const auto multiply = [&](const std::vector<float>& streams, const float* rows) {
      kernels::site_costs(streams.data(), static_cast<Index>(steps.stride),
                          static_cast<int>(steps.dimension), rows, none.data(), kRows,
                          product.data(), lowest.data());
    };
    arena.check();
    for (std::size_t first = begin; first < end; first += kRows) {
      multiply(steps.step_streams, steps.row.data() + first * steps.dimension);
      for (const SiteNumber i : sites_between(first, std::min(first + kRows, end))) {
        const double* const step = steps.step.data() + i * steps.dimension;
        const double grows = steps.length[i] > 0 ? growth(cells, sites, i, step, own.along) : 0;
        follow_steps(steps, i, grows, product.data() + (i - first) * steps.stride,
                     touched[i] != 0 ? nullptr : &all_touched);
      }
    }
    came.clear();
    for (const SiteNumber i : sites_between(begin, end)) {
      if (touched[i] == 0) continue;
      const auto points = cells.points(i);
      for (std::size_t k = 0; k < points.size(); ++k) {
        const PointOfAll point = points[k];
        if (std::exchange(counted_[first_[row_of(i)] + k], point) != point) came.push_back({i, k});
      }
    }
    for (std::size_t first = 0; first < came.size(); first += kRows) {
      const auto some = std::span(came).subspan(first, std::min(kRows, came.size() - first));
      std::vector<Arrival> arrivals;
      for (const Came& c : some) {
        float* const own_row = row.data() + arrivals.size() * steps.dimension;
        arrivals.emplace_back(cells, sites, centred, c, own_row);
      }
      multiply(steps.site_streams, row.data());
      for (std::size_t k = 0; k < arrivals.size(); ++k) {
        include(steps, arrivals[k], product.data() + k * steps.stride);
      }
    }
  });
  position_ = sites.position;
}

/// Marks the pairs that may gain by what is known.
template <class Scalar>
void Reaches<Scalar>::mark(const std::vector<std::uint8_t>& touched, const Arena& arena) {
  const auto wanted = [&](SiteNumber i, SiteNumber j) { return (touched[i] | touched[j]) != 0; };
  std::fill(marked_.begin(), marked_.end(), std::uint8_t{0});
  if (ranks_ == nullptr) {
    for_pairs_of_sites(arena, count_, [&](SiteNumber i, SiteNumber j, std::vector<Pair>&) {
      if (wanted(i, j) && may_gain(i, j)) marks_of(i)[j] = marks_of(j)[i] = 1;
    });
    return;
  }
  exchange(wanted);
  arena.for_each(own_.size(), 4, [&](std::size_t k) {
    const SiteNumber i(*own_.begin() + k);
    for (const SiteNumber j : sites_below(count_)) {
      if (i != j && wanted(i, j) && may_gain(i, j)) marks_of(i)[j] = 1;
    }
  });
}

/// Of the pairs that are marked.
template <class Scalar>
Buffer<Pair> Reaches<Scalar>::marked_gaining(const Arena& arena) {
  const auto add = [&](SiteNumber i, SiteNumber j, std::vector<Pair>& out) {
    if (marks_of(i)[j] != 0 && may_gain(i, j)) out.emplace_back(i, j);
  };
  if (ranks_ == nullptr) return for_pairs_of_sites(arena, count_, add);
  return found_together(
      ranks_, collect<Pair>(arena, own_.size(), 4,
                            [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int) {
                              const std::size_t first = *own_.begin();
                              for (const SiteNumber i : sites_between(first + begin, first + end)) {
                                for (const SiteNumber j : sites_below(count_).after(i)) {
                                  add(i, j, out);
                                }
                              }
                            }));
}

template <class Scalar>
Buffer<Pair> Reaches<Scalar>::known_gaining(const std::vector<std::uint8_t>& touched,
                                            const Arena& arena) {
  mark(touched, arena);
  return marked_gaining(arena);
}

template <class Scalar>
Buffer<Pair> Reaches<Scalar>::gaining(const Metric& metric, const Cells<Scalar>& cells,
                                      const SiteState& sites, const CentredSites<Scalar>& centred,
                                      const std::vector<std::uint8_t>& touched,
                                      const Arena& arena) {
  follow(cells, sites, centred, touched, arena);
  mark(touched, arena);
  struct Scratch {
    CentredCell<Scalar> cell;
    std::vector<SiteNumber> others;
    std::vector<Scalar> position;
    std::vector<Scalar> largest;
  };
  PerWorker<Scratch> scratch(arena);
  const std::size_t dimension = sites.dimension;
  const std::size_t first_own = *own_.begin();
  arena.for_ranges(own_.size(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    auto& [cell, others, position, largest] = scratch[worker];
    position.resize(kSitesAtOnce * dimension);
    largest.resize(kSitesAtOnce);
    for (const SiteNumber i : sites_between(first_own + begin, first_own + end)) {
      others.clear();
      for (const SiteNumber j : sites.all()) {
        if (marks_of(i)[j] != 0) others.push_back(j);
      }
      if (others.empty()) continue;
      arena.check();
      cell.load(cells, sites, centred, i);
      for (std::size_t first = 0; first < others.size(); first += kSitesAtOnce) {
        const auto some =
            std::span(others).subspan(first, std::min(kSitesAtOnce, others.size() - first));
        Scalar* to = position.data();
        for (const SiteNumber j : some) {
          for (std::size_t d = 0; d < dimension; ++d) *to++ = centred.at(j, d);
        }
        const std::size_t padded =
            (some.size() + kernels::kDotSites - 1) / kernels::kDotSites * kernels::kDotSites;
        kernels::largest_dots(cell.block.data(), cell.stride, metric.dimension(),
                              cell.offset.data(), position.data(), static_cast<Index>(padded),
                              largest.data());
        for (std::size_t k = 0; k < some.size(); ++k) {
          const SiteNumber j = some[k];
          of(i)[j] = reach_of<Scalar>(largest[k], metric.squared_distance(sites.at(i), sites.at(j)),
                                      centred.rounding(i, j));
        }
      }
    }
  });
  exchange([&](SiteNumber i, SiteNumber j) { return marks_of(i)[j] != 0; });
  return marked_gaining(arena);
}

template class Reaches<float>;
template class Reaches<double>;

}  // namespace ccvt
