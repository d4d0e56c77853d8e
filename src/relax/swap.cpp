#include "relax/swap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/keys.h"
#include "relax/update.h"
#include "rounding.h"

namespace ccvt {

template <class Scalar>
PairSwapper<Scalar>::PairSwapper(const Metric& metric, const Options& options,
                                 double coordinate_bound)
    : metric_(metric),
      method_(options.swap),
      pruning_(options.point_pruning),
      median_cut_(options.median_cut_pruning),
      coordinate_bound_(coordinate_bound),
      cut_(metric, coordinate_bound),
      coordinates_(2 * static_cast<std::size_t>(metric.dimension())) {}

/// Bounds the keys of the patches of a cell that is divided.
template <class Scalar>
void PairSwapper<Scalar>::divide(const Patches<Scalar>& patches, SiteNumber cell, Side side,
                                 Part& part) {
  part.divided = cut_.straight() && patches.has(cell);
  if (!part.divided) return;
  part.size = patches.size(cell);
  cut_.bound_keys(side, patches.low(cell), patches.high(cell), part.bounds);
}

/// Of a cell of so many points, the patches that may have keys beyond what is known: higher ones
/// on side i, lower ones on side j. Of one that is not divided all.
template <class Scalar>
void PairSwapper<Scalar>::choose(Side side, Index points, double known, Part& part) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!part.divided) {
    part.stretches.assign(1, {side == Side::i ? kInfinity : -kInfinity, 0, points});
    return;
  }
  part.stretches.clear();
  Index first = 0;
  for (const double bound : part.bounds) {
    if (is_beyond(side, bound, known)) {
      part.stretches.push_back({bound, first, std::min(part.size, points - first)});
    }
    first += part.size;
  }
}

template <class Scalar>
auto PairSwapper<Scalar>::key_bounds(const Cells<Scalar>& cells, SiteNumber i, SiteNumber j)
    -> KeyBounds {
  if (part_i_.divided || part_j_.divided) return key_bounds_by_patches(cells, i, j);
  choose(Side::i, cells.size(i), 0, part_i_);
  choose(Side::j, cells.size(j), 0, part_j_);
  const auto extremes = [&](const auto& cut_i, const auto& cut_j) {
    return kernels::key_extremes(cells.block(i), cells.size(i), cut_i, cells.block(j),
                                 cells.size(j), cut_j, metric_.dimension());
  };
  const auto [highest, lowest] = cut_.with_kernels(extremes);
  return {highest + cut_.tolerance(), lowest - cut_.tolerance()};
}

/// The same, but that bounds of separated cells may be loose. Only patches are looked at whose
/// points can lie beyond what is known already.
template <class Scalar>
auto PairSwapper<Scalar>::key_bounds_by_patches(const Cells<Scalar>& cells, SiteNumber i,
                                                SiteNumber j) -> KeyBounds {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double apart = 3 * cut_.tolerance();  // with room for rounding: for separated() it is two
  // The highest key of cell i, or what is known if that is higher; of cell j the lowest.
  const auto extreme = [&](SiteNumber cell, Side side, const auto& cut, Part& part, double known) {
    choose(side, cells.size(cell), known, part);
    for (const auto& [bound, first, count] : part.stretches) {
      if (!is_beyond(side, bound, known)) continue;
      const double key = kernels::extreme_key(cells.block(cell) + first, cells.size(cell), count,
                                              metric_.dimension(), cut, beyond(side));
      if (is_beyond(side, key, known)) known = key;
    }
    return known;
  };
  return cut_.with_kernels([&](const auto& cut_i, const auto& cut_j) {
    double lowest = part_j_.divided
                        ? *std::min_element(part_j_.bounds.begin(), part_j_.bounds.end())
                        : extreme(j, Side::j, cut_j, part_j_, kInfinity);
    const double known = part_i_.divided ? lowest - apart : -kInfinity;
    const double highest = extreme(i, Side::i, cut_i, part_i_, known);
    if (part_j_.divided) lowest = extreme(j, Side::j, cut_j, part_j_, highest + apart);
    return KeyBounds{highest + cut_.tolerance(), lowest - cut_.tolerance()};
  });
}

/// Point distance pruning [5.2, eq. 8 and 9]: the points of `cell` that are near enough to the
/// other site to gain by an exchange. Notes their places and returns how many.
template <class Scalar>
Index PairSwapper<Scalar>::within_reach(const Cells<Scalar>& cells, const SiteState& sites,
                                        SiteNumber cell, SiteNumber other) {
  const double own = sites.radius[cell];
  const double others = sites.radius[other];
  const double nearest = std::max(0.0, cut_.length() - others);
  const double slack = 1 + 8 * (metric_.dimension() + 4) * kHalfUlp;
  const double limit = (own * own + others * others) * slack - nearest * nearest;
  const Index count = cells.size(cell);
  const double* site = sites.at(other);
  per_point_.assign(cells.points(cell).size(), 0.0);
  const Scalar* stream = cells.block(cell);
  for (int d = 0; d < metric_.dimension(); ++d, stream += count) {
    const double x = site[d];
    const double extent =
        metric_.periodic() ? metric_.extent()[d] : std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < per_point_.size(); ++k) {
      const double distance = shortest_distance(stream[k] - x, extent);
      per_point_[k] += distance * distance;
    }
  }
  make_room(per_point_.size());
  const double* const squared = per_point_.data();
  Index* const places = places_.data();
  Index found = 0;
  for (Index k = 0; k < count; ++k) {
    places[found] = k;
    found += squared[k] <= limit ? 1 : 0;
  }
  return found;
}

/// The points in the stretches of a cell whose keys are beyond a threshold. Notes their places and
/// returns how many.
template <class Scalar>
Index PairSwapper<Scalar>::find_beyond(const Cells<Scalar>& cells, SiteNumber cell, Side side,
                                       const Part& part, Scalar threshold) {
  make_room(cells.points(cell).size());
  return cut_.with_kernels([&](const auto& cut_i, const auto& cut_j) {
    Index found = 0;
    for (const Stretch& stretch : part.stretches) {
      if (!is_beyond(side, stretch.bound, threshold)) continue;
      Index* const places = places_.data() + found;
      const Scalar* const block = cells.block(cell) + stretch.first;
      const auto find = [&](const auto& cut) {
        return kernels::places_beyond(block, cells.size(cell), stretch.count, metric_.dimension(),
                                      cut, beyond(side), threshold, places);
      };
      const Index here = side == Side::i ? find(cut_i) : find(cut_j);
      for (Index k = 0; k < here; ++k) places[k] += stretch.first;
      found += here;
    }
    return found;
  });
}

template <class Scalar>
void PairSwapper<Scalar>::find_candidates(const Cells<Scalar>& cells, const SiteState& sites,
                                          SiteNumber i, SiteNumber j, const KeyBounds& bounds) {
  const auto keep = [&](SiteNumber cell, Side side, Index found,
                        std::vector<Candidate>& candidates) {
    candidates.clear();
    const Scalar* block = cells.block(cell);
    const Index* const places = places_.data();
    for (Index k = 0; k < found; ++k) {
      const Index place = places[k];
      cells.prefetch_point(cell, place);
      candidates.push_back({cut_.key(side, block, cells.size(cell), place), place});
    }
  };
  switch (pruning_) {
    case PointPruning::none: {
      const auto keep_all = [&](SiteNumber cell, Side side, std::vector<Candidate>& candidates) {
        per_point_.assign(cells.points(cell).size(), 0.0);
        cut_.add_keys(side, cells.block(cell), cells.size(cell), per_point_.data());
        candidates.resize(per_point_.size());
        for (std::size_t k = 0; k < per_point_.size(); ++k) {
          candidates[k] = {per_point_[k], static_cast<Index>(k)};
        }
      };
      keep_all(i, Side::i, moves_.from_i);
      keep_all(j, Side::j, moves_.from_j);
      return;
    }
    case PointPruning::distance:
      keep(i, Side::i, within_reach(cells, sites, i, j), moves_.from_i);
      keep(j, Side::j, within_reach(cells, sites, j, i), moves_.from_j);
      return;
    case PointPruning::extremes: {
      // Thresholds are rounded outwards, away from the points that can move.
      const auto infinity = std::numeric_limits<Scalar>::infinity();
      const auto floor =
          std::nextafter(static_cast<Scalar>(bounds.lowest_j - cut_.tolerance()), -infinity);
      const auto ceiling =
          std::nextafter(static_cast<Scalar>(bounds.highest_i + cut_.tolerance()), infinity);
      keep(i, Side::i, find_beyond(cells, i, Side::i, part_i_, floor), moves_.from_i);
      keep(j, Side::j, find_beyond(cells, j, Side::j, part_j_, ceiling), moves_.from_j);
      return;
    }
  }
}

template <class Scalar>
void PairSwapper<Scalar>::exchange(Cells<Scalar>& cells, Patches<Scalar>& patches, SiteState& sites,
                                   SiteNumber i, SiteNumber j) {
  // The sets decide the result, not the order in which a selection left them.
  const auto by_place = [](const Candidate& a, const Candidate& b) { return a.place < b.place; };
  std::sort(moves_.from_i.begin(), moves_.from_i.end(), by_place);
  std::sort(moves_.from_j.begin(), moves_.from_j.end(), by_place);
  Scalar* const to_i = coordinates_.data();
  Scalar* const to_j = to_i + metric_.dimension();
  const auto grow = [&](SiteNumber cell, Index place, const Scalar* come, const Scalar* left) {
    double& radius = sites.radius[cell];
    const double squared = metric_.squared_distance(come, sites.at(cell));
    if (squared > radius * radius) radius = upper_radius(squared, metric_.dimension());
    patches.replace(cell, place, come, left);
  };
  for (std::size_t k = 0; k < moves_.from_i.size(); ++k) {
    const Index place_i = moves_.from_i[k].place;
    const Index place_j = moves_.from_j[k].place;
    cells.get(i, place_i, to_j);
    cells.get(j, place_j, to_i);
    cells.exchange(i, place_i, j, place_j);
    grow(i, place_i, to_i, to_j);
    grow(j, place_j, to_j, to_i);
  }
  if (cut_.crosses_faces()) {
    sites.compact[i] = sites.compact[j] = 0;
  }
}

/// Reduces the candidates to those that move.
template <class Scalar>
void PairSwapper<Scalar>::select(const Cells<Scalar>& cells, const SiteState& sites, SiteNumber i,
                                 SiteNumber j) {
  // Of both cells, whose points may change places; one far away, in another, counts for nothing.
  const double bound = std::max(coordinate_bound_of(metric_, coordinate_bound_, sites, i),
                                coordinate_bound_of(metric_, coordinate_bound_, sites, j));
  const auto centroid_error = [&](SiteNumber cell) {
    return energy_of_rounding(metric_, bound, cells.size(cell), sites.radius[cell]);
  };
  margin_ = 2 * cut_.rounding() + (centroid_error(i) + centroid_error(j)) / 2;
  if (moves_.from_i.empty() || moves_.from_j.empty()) return moves_.clear();
  select_exchange(method_, margin_, moves_);
}

/// Finds what to exchange in the two cells.
template <class Scalar>
void PairSwapper<Scalar>::search(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                                 const SiteState& sites, SiteNumber i, SiteNumber j) {
  moves_.clear();
  if (looks_at_bounds()) {
    divide(patches, i, Side::i, part_i_);
    divide(patches, j, Side::j, part_j_);
    bounds_ = key_bounds(cells, i, j);
    if (bounds_.separated()) return;
  }
  find_candidates(cells, sites, i, j, bounds_);
  select(cells, sites, i, j);
}

template <class Scalar>
Index PairSwapper<Scalar>::operator()(Cells<Scalar>& cells, Patches<Scalar>& patches,
                                      SiteState& sites, SiteNumber i, SiteNumber j,
                                      Bands<Scalar>* bands) {
  cut_.place(sites, i, j);
  sorted_ = {};
  KnownPair<Scalar>* known = nullptr;
  if (looks_at_bounds()) {
    sorted_ = {patches.look(cells, i, scratch_), patches.look(cells, j, scratch_)};
    if (bands != nullptr && has_band(cells, patches, i, j)) {
      known = bands->of(cells, i, j);
      if (known != nullptr && known->apart.holds({metric_, cut_, cells, patches, sites, i, j}))
        return 0;
    }
  }
  if (known == nullptr || !search_band(cells, patches, sites, i, j, *known)) {
    search(cells, patches, sites, i, j);
    if (known != nullptr) note_search(*known);
  }
  if (moves_.from_i.empty()) return 0;
  exchange(cells, patches, sites, i, j);
  return static_cast<Index>(moves_.from_i.size());
}

template class PairSwapper<float>;
template class PairSwapper<double>;

}  // namespace ccvt
