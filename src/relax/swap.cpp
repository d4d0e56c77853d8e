#include "relax/swap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/kernels.h"
#include "relax/update.h"

namespace ccvt {
namespace {

constexpr double kHalfUlp = 0x1p-53;
/// Of the torus's extent. Not one half: rounding must not decide which image is the nearest.
constexpr double kLargestFrame = 0.499;

}  // namespace

template <class Scalar>
PairSwapper<Scalar>::PairSwapper(const Metric& metric, const Options& options,
                                 double coordinate_bound)
    : metric_(metric),
      method_(options.swap),
      pruning_(options.point_pruning),
      median_cut_(options.median_cut_pruning),
      coordinate_bound_(coordinate_bound) {
  const auto size = static_cast<std::size_t>(metric.dimension());
  for (auto* vector : {&normal_, &middle_i_, &middle_j_}) vector->resize(size);
  for (auto* vector : {&scalar_normal_, &scalar_middle_i_, &scalar_middle_j_}) vector->resize(size);
  if (metric.periodic()) {
    const double least = *std::min_element(metric.extent(), metric.extent() + size);
    largest_wrapped_ =
        kLargestFrame - 2 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) *
                            (1 + coordinate_bound / least);
    for (std::size_t d = 0; d < size; ++d) {
      extent_.push_back(static_cast<Scalar>(metric.extent()[d]));
      inverse_extent_.push_back(static_cast<Scalar>(1 / metric.extent()[d]));
    }
    turn_.resize(size);
  }
}

template <class Scalar>
bool PairSwapper<Scalar>::spheres_meet(const Metric& metric, const SiteState& sites, Index i,
                                       Index j) {
  const double reach =
      sites.radius[static_cast<std::size_t>(i)] + sites.radius[static_cast<std::size_t>(j)];
  return metric.squared_distance(sites.at(i), sites.at(j)) <= reach * reach;
}

/// Sets up the cut between two sites, with bounds on the rounding of keys. A straight cut needs
/// both cells in one frame: no point of either cell may be nearer to another image of a site.
template <class Scalar>
void PairSwapper<Scalar>::place_cut(const SiteState& sites, Index i, Index j) {
  if (metric_.dimension() == 2) return place_cut_in<2>(sites, i, j);
  if (metric_.dimension() == 3) return place_cut_in<3>(sites, i, j);
  place_cut_in<0>(sites, i, j);
}

/// `Dimension`: 0 for any. Where it is known, loops are unrolled.
template <class Scalar>
template <std::size_t Dimension>
void PairSwapper<Scalar>::place_cut_in(const SiteState& sites, Index i, Index j) {
  const std::size_t dimension = Dimension > 0 ? Dimension : normal_.size();
  const double* const at_i = sites.at(i);
  const double* const at_j = sites.at(j);
  const auto a = static_cast<std::size_t>(i);
  const auto b = static_cast<std::size_t>(j);
  const double radius = std::max(sites.radius[a], sites.radius[b]);
  const bool compact = !metric_.periodic() || (sites.compact[a] != 0 && sites.compact[b] != 0);
  const double largest = compact ? kLargestFrame : largest_wrapped_;
  double* const normal = normal_.data();
  double* const middle_i = middle_i_.data();
  double* const middle_j = middle_j_.data();
  bool crosses = false;
  bool too_large = false;
  bool shifted = false;
  double squared_length = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    const auto k = static_cast<int>(d);
    const double raw = at_j[d] - at_i[d];
    const double u = metric_.wrap(raw, k);
    normal[d] = u;
    squared_length += u * u;
    middle_i[d] = at_i[d] + u / 2;
    middle_j[d] = u == raw ? middle_i[d] : at_j[d] - u / 2;
    shifted = shifted || u != raw;
    if (!metric_.periodic()) continue;
    crosses = crosses || (!compact && (u != raw || metric_.reaches_face(at_i[d], radius, k) ||
                                       metric_.reaches_face(at_j[d], radius, k)));
    too_large = too_large || std::abs(u) + radius > largest * metric_.extent()[d];
  }
  site_i_ = at_i;
  site_j_ = at_j;
  shifted_ = shifted || crosses;
  frame_ = too_large ? Frame::none : crosses ? Frame::wrapped : Frame::plain;
  length_ = std::sqrt(squared_length);
  const auto terms = static_cast<double>(dimension + 4);
  // Across faces a difference to the cut is rounded as coordinates are, and the normal as extents
  // are; else both cells see the same cut, and the rounding of its place does not matter.
  const double placement = metric_.largest_extent() + coordinate_bound_;
  const double reach = length_ + radius;
  double size = length_ * reach;
  if (frame_ == Frame::none) {
    size = reach * (reach + placement);
  } else if (shifted_) {
    size += length_ * placement + reach * metric_.largest_extent();
  }
  rounding_ = 4 * terms * kHalfUlp * size;
  tolerance_ = 2 * terms * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * size +
               terms * static_cast<double>(std::numeric_limits<Scalar>::min());
  Scalar* const scalar_normal = scalar_normal_.data();
  Scalar* const scalar_i = scalar_middle_i_.data();
  Scalar* const scalar_j = scalar_middle_j_.data();
  for (std::size_t d = 0; d < dimension; ++d) {
    scalar_normal[d] = static_cast<Scalar>(normal[d]);
    scalar_i[d] = static_cast<Scalar>(middle_i[d]);
    scalar_j[d] = static_cast<Scalar>(middle_j[d]);
  }
  if (frame_ == Frame::plain) return;
  for (std::size_t d = 0; d < dimension; ++d) {
    if (frame_ == Frame::wrapped) {
      const Metric::Unrolled frame = metric_.unrolled(middle_i[d], static_cast<int>(d));
      scalar_i[d] = static_cast<Scalar>(frame.origin);
      turn_[d] = static_cast<Scalar>(frame.turn);
    } else {
      scalar_i[d] = static_cast<Scalar>(at_i[d]);
      scalar_j[d] = static_cast<Scalar>(at_j[d]);
    }
  }
}

template <class Scalar>
double PairSwapper<Scalar>::exact_key(const Scalar* block, Index count, Index place,
                                      const std::vector<double>& middle) const {
  double key = 0;
  const Scalar* x = block + place;
  for (std::size_t d = 0; d < normal_.size(); ++d, x += count) {
    const auto k = static_cast<int>(d);
    if (frame_ == Frame::plain) {
      key += (static_cast<double>(*x) - middle[d]) * normal_[d];
    } else if (frame_ == Frame::wrapped) {
      key += metric_.wrap(static_cast<double>(*x) - middle_i_[d], k) * normal_[d];
    } else {
      const double to_i = metric_.wrap(static_cast<double>(*x) - site_i_[d], k);
      const double to_j = metric_.wrap(static_cast<double>(*x) - site_j_[d], k);
      key += (to_i * to_i - to_j * to_j) / 2;
    }
  }
  return key;
}

/// exact_key() of every point of a cell, a stream at a time: the same sums in the same order.
template <class Scalar>
void PairSwapper<Scalar>::exact_keys(const Scalar* block, Index count,
                                     const std::vector<double>& middle) {
  per_point_.assign(static_cast<std::size_t>(count), 0.0);
  for (std::size_t d = 0; d < normal_.size(); ++d, block += count) {
    const double along = normal_[d];
    const auto add = [&](auto term) {
      for (std::size_t k = 0; k < per_point_.size(); ++k) {
        per_point_[k] += term(static_cast<double>(block[k]));
      }
    };
    if (frame_ == Frame::plain) {
      add([along, origin = middle[d]](double x) { return (x - origin) * along; });
      continue;
    }
    const auto shortest = [extent = metric_.extent()[d]](double difference) {
      return shortest_difference(difference, extent);
    };
    if (frame_ == Frame::wrapped) {
      add([=, origin = middle_i_[d]](double x) { return shortest(x - origin) * along; });
    } else {
      add([=, at_i = site_i_[d], at_j = site_j_[d]](double x) {
        const double to_i = shortest(x - at_i);
        const double to_j = shortest(x - at_j);
        return (to_i * to_i - to_j * to_j) / 2;
      });
    }
  }
}

/// Calls `visit` with the cut as the kernels see it from cell i and from cell j.
template <class Scalar>
template <class Visit>
auto PairSwapper<Scalar>::with_cuts(Visit visit) const {
  switch (frame_) {
    case Frame::plain:
      break;
    case Frame::wrapped: {
      const kernels::WrappedCut<Scalar> cut{scalar_middle_i_.data(), scalar_normal_.data(),
                                            turn_.data(), extent_.data()};
      return visit(cut, cut);
    }
    case Frame::none: {
      const kernels::TorusCut<Scalar> cut{scalar_middle_i_.data(), scalar_middle_j_.data(),
                                          extent_.data(), inverse_extent_.data()};
      return visit(cut, cut);
    }
  }
  return visit(kernels::Cut<Scalar>{scalar_middle_i_.data(), scalar_normal_.data()},
               kernels::Cut<Scalar>{scalar_middle_j_.data(), scalar_normal_.data()});
}

/// Median-cut pruning [5.2]: no key of cell i is above any key of cell j.
template <class Scalar>
bool PairSwapper<Scalar>::already_separated(const Cells<Scalar>& cells, Index i, Index j) {
  const auto extremes = [&](const auto& cut_i, const auto& cut_j) {
    return kernels::key_extremes(cells.block(i), cells.size(i), cut_i, cells.block(j),
                                 cells.size(j), cut_j, metric_.dimension());
  };
  const auto [highest, lowest] = with_cuts(extremes);
  highest_i_ = static_cast<double>(highest) + tolerance_;
  lowest_j_ = static_cast<double>(lowest) - tolerance_;
  return highest_i_ <= lowest_j_;
}

/// Point distance pruning [5.2, eq. 8 and 9]: the points of `cell` that are near enough to the
/// other site to gain by an exchange.
template <class Scalar>
void PairSwapper<Scalar>::within_reach(const Cells<Scalar>& cells, const SiteState& sites,
                                       Index cell, Index other, std::vector<Index>& places) {
  const double own = sites.radius[static_cast<std::size_t>(cell)];
  const double others = sites.radius[static_cast<std::size_t>(other)];
  const double nearest = std::max(0.0, length_ - others);
  const double slack = 1 + 8 * static_cast<double>(normal_.size() + 4) * kHalfUlp;
  const double limit = (own * own + others * others) * slack - nearest * nearest;
  const Index count = cells.size(cell);
  const double* site = sites.at(other);
  per_point_.assign(static_cast<std::size_t>(count), 0.0);
  const Scalar* stream = cells.block(cell);
  for (int d = 0; d < metric_.dimension(); ++d, stream += count) {
    const double x = site[d];
    const double half = metric_.periodic() ? metric_.extent()[d] / 2 : 0;
    for (std::size_t k = 0; k < per_point_.size(); ++k) {
      double difference = std::abs(static_cast<double>(stream[k]) - x);
      if (half > 0) difference = std::min(difference, 2 * half - difference);
      per_point_[k] += difference * difference;
    }
  }
  places.clear();
  for (Index k = 0; k < count; ++k) {
    if (per_point_[static_cast<std::size_t>(k)] <= limit) places.push_back(k);
  }
}

template <class Scalar>
void PairSwapper<Scalar>::find_candidates(const Cells<Scalar>& cells, const SiteState& sites,
                                          Index i, Index j) {
  switch (pruning_) {
    case PointPruning::none: {
      const auto keep_all = [&](Index cell, const std::vector<double>& middle,
                                std::vector<Candidate>& candidates) {
        exact_keys(cells.block(cell), cells.size(cell), middle);
        candidates.resize(per_point_.size());
        for (std::size_t k = 0; k < per_point_.size(); ++k) {
          candidates[k] = {per_point_[k], static_cast<Index>(k)};
        }
      };
      keep_all(i, middle_i_, moves_.from_i);
      keep_all(j, middle_j_, moves_.from_j);
      return;
    }
    case PointPruning::distance:
      within_reach(cells, sites, i, j, places_i_);
      within_reach(cells, sites, j, i, places_j_);
      break;
    case PointPruning::extremes: {
      const auto beyond = [&](Index cell, const auto& cut, std::vector<Index>& places,
                              auto select) {
        const auto count = static_cast<std::size_t>(cells.size(cell));
        keys_.resize(count);
        places.resize(count);
        kernels::keys(cells.block(cell), cells.size(cell), metric_.dimension(), cut, keys_.data());
        places.resize(
            static_cast<std::size_t>(select(keys_.data(), cells.size(cell), places.data())));
      };
      // Thresholds are rounded outwards, away from the points that can move.
      const auto infinity = std::numeric_limits<Scalar>::infinity();
      const auto floor = std::nextafter(static_cast<Scalar>(lowest_j_ - tolerance_), -infinity);
      const auto ceiling = std::nextafter(static_cast<Scalar>(highest_i_ + tolerance_), infinity);
      with_cuts([&](const auto& cut_i, const auto& cut_j) {
        beyond(i, cut_i, places_i_, [&](const Scalar* k, Index n, Index* p) {
          return kernels::places_above(k, n, floor, p);
        });
        beyond(j, cut_j, places_j_, [&](const Scalar* k, Index n, Index* p) {
          return kernels::places_below(k, n, ceiling, p);
        });
      });
      break;
    }
  }
  const auto keep = [&](Index cell, const std::vector<double>& middle,
                        const std::vector<Index>& places, std::vector<Candidate>& candidates) {
    candidates.clear();
    const Scalar* block = cells.block(cell);
    for (const Index place : places) {
      candidates.push_back({exact_key(block, cells.size(cell), place, middle), place});
    }
  };
  keep(i, middle_i_, places_i_, moves_.from_i);
  keep(j, middle_j_, places_j_, moves_.from_j);
}

template <class Scalar>
void PairSwapper<Scalar>::exchange(Cells<Scalar>& cells, SiteState& sites, Index i, Index j) {
  std::vector<Scalar>& x = keys_;
  x.resize(normal_.size());
  // The sets decide the result, not the order in which a selection left them.
  const auto by_place = [](const Candidate& a, const Candidate& b) { return a.place < b.place; };
  std::sort(moves_.from_i.begin(), moves_.from_i.end(), by_place);
  std::sort(moves_.from_j.begin(), moves_.from_j.end(), by_place);
  const auto grow = [&](Index cell, Index place) {
    cells.get(cell, place, x.data());
    double& radius = sites.radius[static_cast<std::size_t>(cell)];
    const double squared = metric_.squared_distance(x.data(), sites.at(cell));
    if (squared > radius * radius) radius = upper_radius(squared, metric_.dimension());
  };
  for (std::size_t k = 0; k < moves_.from_i.size(); ++k) {
    cells.exchange(i, moves_.from_i[k].place, j, moves_.from_j[k].place);
    grow(i, moves_.from_i[k].place);
    grow(j, moves_.from_j[k].place);
  }
  if (shifted_ || frame_ == Frame::none) {
    sites.compact[static_cast<std::size_t>(i)] = 0;
    sites.compact[static_cast<std::size_t>(j)] = 0;
  }
}

template <class Scalar>
Index PairSwapper<Scalar>::operator()(Cells<Scalar>& cells, SiteState& sites, Index i, Index j) {
  place_cut(sites, i, j);
  if ((median_cut_ || pruning_ == PointPruning::extremes) && already_separated(cells, i, j)) {
    return 0;
  }
  find_candidates(cells, sites, i, j);
  if (moves_.from_i.empty() || moves_.from_j.empty()) return 0;

  // How far a site may be from the exact centroid: see update_site().
  const auto centroid_error = [&](Index cell) {
    const double count = cells.size(cell);
    const double summed = metric_.periodic()
                              ? (count + 16) * metric_.largest_extent()
                              : (count / 8 + 16) * 2 * sites.radius[static_cast<std::size_t>(cell)];
    const double error = kHalfUlp * (coordinate_bound_ + summed);
    return count * error * error * metric_.dimension();
  };
  const double margin = 2 * rounding_ + (centroid_error(i) + centroid_error(j)) / 2;
  select_exchange(method_, margin, moves_);
  if (moves_.from_i.empty()) return 0;
  exchange(cells, sites, i, j);
  return static_cast<Index>(moves_.from_i.size());
}

template class PairSwapper<float>;
template class PairSwapper<double>;

}  // namespace ccvt
