#include "descent/borders.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <array>
#include <cmath>
#include <limits>

#include "relax/potential.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 64;
/// Points that one task looks at.
constexpr std::size_t kBlock = 4096;
/// Of the squared radius: how wide a border is where its points are counted, and how many points of
/// a cell that takes at least.
constexpr double kWidth = 0.04;
constexpr double kPointsAtBorders = 20;
/// Points that a border has at the least: cells that do not meet now may come to.
constexpr double kLeastMass = 1e-3;

double squared(const double* x, std::size_t dimension) {
  double sum = 0;
  for (std::size_t d = 0; d < dimension; ++d) sum += x[d] * x[d];
  return sum;
}

/// Calls body(block index, worker), of small blocks several a task.
template <class Blocks, class Body>
void for_each_block(const Arena& arena, const Blocks& blocks, std::size_t points,
                    const Body& body) {
  const std::size_t grain = 1 + blocks.size() * kBlock / (points + kBlock);
  arena.for_ranges(blocks.size(), grain, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t b = begin; b < end; ++b) body(b, worker);
  });
}

}  // namespace

template <class Scalar>
void Borders<Scalar>::find(const Cells<Scalar>& cells, std::span<const double> position,
                           std::span<const double> radius, std::span<const double> weight,
                           std::span<const Pair> near, double share) {
  link(cells, near);
  set_thresholds(position, radius, weight, share);
  split(cells);
  keep(cells);
}

/// Who sees whom.
template <class Scalar>
void Borders<Scalar>::link(const Cells<Scalar>& cells, std::span<const Pair> near) {
  const std::size_t sites = cells.site_count();
  Buffer<Pair> both(2 * near.size() + sites);
  for (std::size_t k = 0; k < near.size(); ++k) {
    both[2 * k] = near[k];
    both[2 * k + 1] = Pair(near[k].second, near[k].first);
  }
  for (const SiteNumber s : sites_below(sites)) both[2 * near.size() + s] = Pair(s, s);
  Groups<Pair> seen = pairs_by_first(arena_, std::move(both), sites);
  first_slot_.assign(seen.first.begin(), seen.first.end());
  site_.resize(seen.items.size());
  twin_.resize(site_.size());
  capacity_.resize(sites);
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    capacity_[s] = cells.size(s);
    // The own site first; the others stay in order.
    const auto own = seen[s];
    const auto at = std::find(own.begin(), own.end(), Pair(s, s));
    std::rotate(own.begin(), at, at + 1);
    for (std::size_t k = 0; k < own.size(); ++k) site_[first_slot_[s] + k] = own[k].second;
  });
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    for (const Slot slot : slots(s)) {
      const auto others = slots(site_[slot]);
      for (const Slot other : others) {
        if (site_[other] == s) twin_[slot] = other;
      }
    }
  });
}

/// The power of the slot's site less that of the own, at the cell's reference, but for weights.
template <class Scalar>
double Borders<Scalar>::power_gap(SiteNumber cell, Slot slot) const {
  return squared(&now_[slot * dimension_], dimension_) -
         squared(&now_[first_slot_[cell] * dimension_], dimension_);
}

template <class Scalar>
void Borders<Scalar>::set_thresholds(std::span<const double> position,
                                     std::span<const double> radius,
                                     std::span<const double> weight, double share) {
  const std::size_t sites = capacity_.size();
  const std::size_t slots_in_all = site_.size();
  reference_.resize(sites * dimension_);
  reach_.resize(sites);
  threshold_.resize(sites);
  width_.resize(sites);
  from_reference_.resize(slots_in_all * dimension_);
  gap_.resize(slots_in_all);
  room_.resize(slots_in_all);
  slope_.resize(slots_in_all * dimension_);
  offset_.resize(slots_in_all);
  mass_.resize(slots_in_all);
  now_.resize(slots_in_all * dimension_);
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    double off = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double x = position[s * dimension_ + d];
      const auto rounded = static_cast<Scalar>(x);
      reference_[s * dimension_ + d] = rounded;
      off += std::abs(x - rounded);
    }
    reach_[s] = radius[s] + off;
    const double square = radius[s] * radius[s];
    threshold_[s] = share * square;
    width_[s] = std::min(threshold_[s],
                         square * std::max(kWidth, kPointsAtBorders / capacity_[s]));
    for (const Slot slot : slots(s)) {
      double* const from = &from_reference_[slot * dimension_];
      for (std::size_t d = 0; d < dimension_; ++d) {
        const double x = position[s * dimension_ + d];
        from[d] = metric_.wrap(position[site_[slot] * dimension_ + d] - x, d) +
                  (x - static_cast<double>(reference_[s * dimension_ + d]));
        now_[slot * dimension_ + d] = from[d];
      }
    }
    const double* const own = &from_reference_[first_slot_[s] * dimension_];
    for (const Slot slot : slots(s)) {
      gap_[slot] = power_gap(s, slot) - (weight[site_[slot]] - weight[s]);
      double apart = 0;
      for (std::size_t d = 0; d < dimension_; ++d) {
        const double u = from_reference_[slot * dimension_ + d] - own[d];
        apart += u * u;
      }
      // No point of the cell has a lower margin to this site than that.
      const double least = gap_[slot] - 2 * std::sqrt(apart) * reach_[s];
      room_[slot] = std::max(threshold_[s], least);
    }
  });
  PowerDiagram diagram{std::vector<double>(position.size(), 0.0),
                       std::vector<double>(weight.begin(), weight.end())};
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) { see(s, diagram); });
}

/// Places the sites of the diagram as the cell sees them. How much of the room that takes.
template <class Scalar>
double Borders<Scalar>::see(SiteNumber cell, const PowerDiagram& diagram) {
  const double* const own_step = &diagram.step[cell * dimension_];
  double most = 0;
  for (const Slot slot : slots(cell)) {
    const double* const step = &diagram.step[site_[slot] * dimension_];
    double* const now = &now_[slot * dimension_];
    double turned = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      now[d] = from_reference_[slot * dimension_ + d] + step[d];
      slope_[slot * dimension_ + d] = static_cast<Scalar>(2 * now[d]);
      turned += (step[d] - own_step[d]) * (step[d] - own_step[d]);
    }
    const double lighter = diagram.weight[cell] - diagram.weight[site_[slot]];
    const double gap = power_gap(cell, slot) + lighter;
    const double change = std::abs(gap - gap_[slot]) + 2 * std::sqrt(turned) * reach_[cell];
    most = std::max(most, change / room_[slot]);
    offset_[slot] = static_cast<Scalar>(squared(now, dimension_) + lighter);
  }
  return most;
}

template <class Scalar>
Scalar Borders<Scalar>::relative(SiteNumber cell, Scalar x, std::size_t d) const {
  const Scalar reference = reference_[cell * dimension_ + d];
  return static_cast<Scalar>(metric_.wrap(static_cast<double>(x) - reference, d));
}

template <class Scalar>
kernels::NearestPowers<Scalar> Borders<Scalar>::nearest(SiteNumber cell, const Scalar* points,
                                                        std::size_t stride, std::size_t count,
                                                        Scratch& own) const {
  own.nearest.resize(std::max(own.nearest.size(), count));
  own.next.resize(own.nearest.size());
  own.margin.resize(own.nearest.size());
  const kernels::NearestPowers<Scalar> out{own.nearest.data(), own.next.data(),
                                           own.margin.data()};
  kernels::nearest_powers(points, static_cast<Index>(stride), static_cast<Index>(count),
                          metric_.dimension(), seen_from(cell), out);
  return out;
}

/// Which points are near a border, and the sums of those that are not.
template <class Scalar>
void Borders<Scalar>::split(const Cells<Scalar>& cells) {
  const std::size_t sites = capacity_.size();
  std::vector<Block> blocks;
  std::vector<std::size_t> first_block{0};
  for (const SiteNumber s : sites_below(sites)) {
    const auto size = cells.points(s).size();
    for (std::size_t k = 0; k < size; k += kBlock) {
      blocks.push_back({s, k, std::min(k + kBlock, size)});
    }
    first_block.push_back(blocks.size());
  }
  const std::size_t values = dimension_ + 2;
  std::vector<double> sums(blocks.size() * values, 0.0);
  std::vector<std::size_t> kept(blocks.size());
  const std::size_t grain =
      1 + blocks.size() * kBlock / (static_cast<std::size_t>(cells.point_count()) + kBlock);
  place_ = collect<Index>(
      arena_, blocks.size(), grain,
      [&](std::size_t begin, std::size_t end, std::vector<Index>& out, int worker) {
        Scratch& own = scratch_[worker];
        for (std::size_t b = begin; b < end; ++b) {
          const auto& [cell, from, to] = blocks[b];
          const std::size_t before = out.size();
          const std::size_t count = to - from;
          own.points.resize(std::max(own.points.size(), count * dimension_));
          const Scalar* stream = cells.block(cell) + from;
          for (std::size_t d = 0; d < dimension_; ++d, stream += cells.size(cell)) {
            for (std::size_t k = 0; k < count; ++k) {
              own.points[d * count + k] = relative(cell, stream[k], d);
            }
          }
          own.places.resize(std::max(own.places.size(), count));
          const Index found = kernels::contested_places(
              own.points.data(), static_cast<Index>(count), static_cast<Index>(count),
              metric_.dimension(), seen_from(cell), static_cast<Scalar>(threshold_[cell]),
              own.places.data());
          double* const sum = &sums[b * values];
          sum[0] = double(count) - found;
          for (Index k = 0; k < found; ++k) out.push_back(static_cast<Index>(from) + own.places[k]);
          for (std::size_t d = 0; d < dimension_; ++d) {
            const Scalar* const x = &own.points[d * count];
            std::array<double, 8> part{};
            std::array<double, 8> square{};
            std::size_t k = 0;
            for (; k + 8 <= count; k += 8) {
              for (std::size_t l = 0; l < 8; ++l) {
                const double y = x[k + l];
                part[l] += y;
                square[l] += y * y;
              }
            }
            for (; k < count; ++k) {
              const double y = x[k];
              part[0] += y;
              square[0] += y * y;
            }
            for (std::size_t l = 0; l < 8; ++l) {
              sum[1 + d] += part[l];
              sum[1 + dimension_] += square[l];
            }
            for (Index q = 0; q < found; ++q) sum[1 + d] -= x[own.places[q]];
          }
          kept[b] = out.size() - before;
        }
      });
  inner_.assign(sites * values, 0.0);
  first_.assign(1, 0);
  squares_ = 0;
  for (const SiteNumber s : sites_below(sites)) {
    std::size_t points = 0;
    for (std::size_t b = first_block[s]; b < first_block[s + 1]; ++b) {
      points += kept[b];
      for (std::size_t v = 0; v < values; ++v) inner_[s * values + v] += sums[b * values + v];
    }
    first_.push_back(first_.back() + points);
  }
  if (std::getenv("TRACE")) std::fprintf(stderr, "slots %.2f\n", double(site_.size()) / double(sites));
  squares_ = sum_of(arena_, sites, kSitesPerGrain,
                    [&](std::size_t s) { return inner_[s * values + 1 + dimension_]; });
}

/// The points near borders, with room for what is counted of them.
template <class Scalar>
void Borders<Scalar>::keep(const Cells<Scalar>& cells) {
  const std::size_t sites = capacity_.size();
  points_.reset(place_.size() * dimension_);
  owner_.reset(place_.size());
  blocks_.clear();
  first_block_.assign(1, 0);
  first_part_.assign(1, 0);
  for (const SiteNumber s : sites_below(sites)) {
    const std::size_t size = first_[s + 1] - first_[s];
    for (std::size_t k = 0; k < size; k += kBlock) {
      blocks_.push_back({s, k, std::min(k + kBlock, size)});
      first_part_.push_back(first_part_.back() + slot_count(s));
    }
    first_block_.push_back(blocks_.size());
  }
  parts_.resize(first_part_.back() * part_size());
  totals_.assign(blocks_.size() * dimension_, 0.0);
  for_each_block(arena_, blocks_, place_.size(), [&](std::size_t b, int) {
    const auto& [cell, begin, end] = blocks_[b];
    const std::size_t stride = first_[cell + 1] - first_[cell];
    const Scalar* stream = cells.block(cell);
    Scalar* out = points_.data() + first_[cell] * dimension_;
    for (std::size_t d = 0; d < dimension_; ++d, stream += cells.size(cell), out += stride) {
      for (std::size_t k = begin; k < end; ++k) {
        out[k] = relative(cell, stream[place_[first_[cell] + k]], d);
        totals_[b * dimension_ + d] += out[k];
      }
    }
  });
}

template <class Scalar>
void Borders<Scalar>::count(const PowerDiagram& diagram) {
  const std::size_t sites = capacity_.size();
  used_ = sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t s) {
            return std::min(2.0, see(SiteNumber(s), diagram));
          });
  used_ = used_ / double(sites);
  std::vector<double> energy(blocks_.size());
  for_each_block(arena_, blocks_, place_.size(), [&](std::size_t b, int worker) {
    energy[b] = count_block(b, scratch_[worker], &parts_[first_part_[b] * part_size()]);
  });
  energy_ = squares_ + sum_of(arena_, blocks_.size(), kSitesPerGrain,
                              [&](std::size_t b) { return energy[b]; });
  gather(diagram);
}

/// Counts the points of a block into the parts of its cell's slots. What the owners add to their
/// energy, but for the squares.
template <class Scalar>
double Borders<Scalar>::count_block(std::size_t number, Scratch& own, double* part) {
  const auto& [cell, begin, end] = blocks_[number];
  const std::size_t count = end - begin;
  const std::size_t stride = first_[cell + 1] - first_[cell];
  const Scalar* const points = points_.data() + first_[cell] * dimension_ + begin;
  own.places.resize(std::max(own.places.size(), count));
  const auto width = static_cast<Scalar>(width_[cell]);
  const auto contested = static_cast<std::size_t>(kernels::contested_places(
      points, static_cast<Index>(stride), static_cast<Index>(count), metric_.dimension(),
      seen_from(cell), width, own.places.data()));
  own.points.resize(std::max(own.points.size(), contested * dimension_));
  for (std::size_t d = 0; d < dimension_; ++d) {
    for (std::size_t k = 0; k < contested; ++k) {
      own.points[d * contested + k] = points[static_cast<std::size_t>(own.places[k]) + d * stride];
    }
  }
  const auto found = nearest(cell, own.points.data(), contested, contested, own);
  Index* const owner = owner_.data() + first_[cell] + begin;
  std::fill_n(owner, count, 0);
  const std::size_t values = part_size();
  std::fill_n(part, slot_count(cell) * values, 0.0);
  part[0] = double(count);
  for (std::size_t d = 0; d < dimension_; ++d) part[1 + d] = totals_[number * dimension_ + d];
  for (std::size_t k = 0; k < contested; ++k) {
    const Index to = found.nearest[k];
    if (found.margin[k] < width && (to == 0 || found.next[k] == 0)) {
      part[static_cast<std::size_t>(to + found.next[k]) * values + 1 + dimension_] += 1;
    }
    if (to == 0) continue;
    owner[own.places[k]] = to;
    double* const sum = part + static_cast<std::size_t>(to) * values;
    sum[0] += 1;
    part[0] -= 1;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double x = own.points[d * contested + k];
      sum[1 + d] += x;
      part[1 + d] -= x;
    }
  }
  double energy = 0;
  for (const Slot slot : slots(cell)) {
    const double* const now = &now_[slot * dimension_];
    double* const sum = part + (slot - first_slot_[cell]) * values;
    double along = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      along += now[d] * sum[1 + d];
      sum[1 + d] -= sum[0] * now[d];
    }
    energy += sum[0] * squared(now, dimension_) - 2 * along;
  }
  return energy;
}

/// Adds up what cells have counted for each site.
template <class Scalar>
void Borders<Scalar>::gather(const PowerDiagram& diagram) {
  const std::size_t sites = capacity_.size();
  const std::size_t values = part_size();
  surplus_.resize(sites);
  to_centroid_.resize(sites * dimension_);
  energy_ += sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t number) {
    const SiteNumber s(number);
    const Slot own(first_slot_[s]);
    const double* const now = &now_[own * dimension_];
    const double* const inner = &inner_[s * values];
    double points = inner[0];
    double* const to = &to_centroid_[s * dimension_];
    double energy = inner[0] * squared(now, dimension_);
    for (std::size_t d = 0; d < dimension_; ++d) {
      energy -= 2 * now[d] * inner[1 + d];
      to[d] = inner[1 + d] - inner[0] * now[d];
    }
    for (const Slot slot : slots(s)) {
      const SiteNumber cell = site_[slot];
      const std::size_t which = twin_[slot] - first_slot_[cell];
      for (std::size_t b = first_block_[cell]; b < first_block_[cell + 1]; ++b) {
        const double* const part = &parts_[(first_part_[b] + which) * values];
        points += part[0];
        for (std::size_t d = 0; d < dimension_; ++d) to[d] += part[1 + d];
      }
      mass_[slot] = 0;
      for (std::size_t b = first_block_[s]; b < first_block_[s + 1]; ++b) {
        mass_[slot] += parts_[(first_part_[b] + (slot - own)) * values + 1 + dimension_];
      }
    }
    surplus_[s] = points - capacity_[s];
    for (std::size_t d = 0; d < dimension_; ++d) to[d] = points > 0 ? to[d] / points : 0;
    return energy - diagram.weight[s] * surplus_[s];
  });
}

template <class Scalar>
std::vector<double> Borders<Scalar>::correction() const {
  const std::size_t sites = capacity_.size();
  WeightedGraph graph{std::vector<std::size_t>(sites + 1), {}, {}};
  for (std::size_t s = 0; s <= sites; ++s) graph.first[s] = first_slot_[s] - s;
  graph.neighbour.resize(graph.first.back());
  graph.weight.resize(graph.neighbour.size());
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    std::size_t edge = graph.first[s];
    for (const Slot slot : slots(s)) {
      const SiteNumber other = site_[slot];
      if (other == s) continue;
      const auto density = [&](double mass, SiteNumber cell) {
        return (mass + kLeastMass) / (2 * width_[cell]);
      };
      graph.neighbour[edge] = other;
      graph.weight[edge++] =
          static_cast<float>(density(mass_[slot], s) + density(mass_[twin_[slot]], other));
    }
  });
  std::vector<double> lack(sites);
  for (std::size_t s = 0; s < sites; ++s) lack[s] = -surplus_[s];
  return potential(graph, lack, arena_);
}

template <class Scalar>
Index Borders<Scalar>::change_owners(Filling<Scalar>& filling) const {
  struct Leaving {
    PointNumber point;
    SiteNumber to;
    SiteNumber from;
    Index place;
  };
  const std::size_t sites = capacity_.size();
  Buffer<Leaving> leaving = collect_by_site<Leaving>(
      arena_, sites, kSitesPerGrain, [&](SiteNumber s, std::vector<Leaving>& out, int) {
        // From the last to the first, so that filling a gap does not move another.
        for (std::size_t k = first_[s + 1]; k-- > first_[s];) {
          if (owner_[k] == 0) continue;
          const auto slot = first_slot_[s] + static_cast<std::size_t>(owner_[k]);
          const PointNumber point = filling.take(s, place_[k]);
          out.push_back({point, site_[slot], s, place_[k]});
        }
      });
  const auto count = static_cast<Index>(leaving.size());
  const auto by_site = group_by_key(arena_, std::move(leaving), sites,
                                    [](const Leaving& l) { return l.to; });
  for_each_site(arena_, filling.tiles, [&](SiteNumber s) {
    for (const Leaving& l : by_site[s]) filling.add(s, l.point);
  });
  return count;
}

template class Borders<float>;
template class Borders<double>;

}  // namespace ccvt
