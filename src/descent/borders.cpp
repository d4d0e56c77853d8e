#include "descent/borders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "parallel/together.h"
#include "relax/add_near.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 64;
/// Points that one task looks at.
constexpr std::size_t kBlock = 4096;
/// Of the squared radius: how wide a border is where its points are counted; and how many points of
/// a cell that takes at least.
constexpr double kWidth = 0.04;
constexpr double kPointsAtBorders = 20;

/// Blocks a task, when so many have so many points.
std::size_t grain(std::size_t blocks, std::size_t points) {
  return 1 + blocks * kBlock / (points + kBlock);
}

/// Eight interleaved partial sums, so that the loop is vectorized; the bits do not depend on how.
struct Sums {
  static constexpr std::size_t kPartials = 8;
  std::array<double, kPartials> sum{};
  std::array<double, kPartials> squares{};

  template <class Scalar>
  void add(const Scalar* x, std::size_t count) {
    std::size_t k = 0;
    for (; k + kPartials <= count; k += kPartials) {
      for (std::size_t l = 0; l < kPartials; ++l) {
        const double y = x[k + l];
        sum.data()[l] += y;
        squares.data()[l] += y * y;
      }
    }
    for (; k < count; ++k) {
      const double y = x[k];
      sum[0] += y;
      squares[0] += y * y;
    }
  }
  static double of(const std::array<double, kPartials>& part) {
    return ((part[0] + part[4]) + (part[1] + part[5])) +
           ((part[2] + part[6]) + (part[3] + part[7]));
  }
};

}  // namespace

template <class Scalar>
void Borders<Scalar>::Scratch::make_room(std::size_t count, std::size_t dimension) {
  if (places.size() >= count && points.size() >= count * dimension) return;
  points.resize(count * dimension);
  places.resize(count);
  nearest.resize(count);
  next.resize(count);
  margin.resize(count);
}

template <class Scalar>
void Borders<Scalar>::find(const Cells<Scalar>& cells, std::span<const double> position,
                           std::span<const double> radius, std::span<const double> weight,
                           std::span<const Pair> near, double share) {
  capacity_.clear();
  threshold_.clear();
  width_.clear();
  for (const SiteNumber s : cells.sites()) {
    const double squared = radius[s] * radius[s];
    capacity_.push_back(cells.size(s));
    threshold_.push_back(share * squared);
    width_.push_back(std::min(threshold_.back(),
                              squared * std::max(kWidth, kPointsAtBorders / capacity_.back())));
  }
  views_.look(cells, position, radius, weight, near, threshold_);
  split(cells);
  keep(cells);
}

/// Which points are near a border, and the sums of those that are not.
template <class Scalar>
void Borders<Scalar>::split(const Cells<Scalar>& cells) {
  std::vector<Block> blocks;
  std::vector<std::size_t> first_block{0};
  for (const SiteNumber s : cells.sites()) {
    const std::size_t size = tiling_.is_own(tiling_.tile_of(s)) ? cells.points(s).size() : 0;
    for (std::size_t k = 0; k < size; k += kBlock) {
      blocks.push_back({s, k, std::min(k + kBlock, size)});
    }
    first_block.push_back(blocks.size());
  }
  std::vector<double> inner(blocks.size() * sum_size());
  std::vector<double> squares(blocks.size());
  std::vector<std::size_t> kept(blocks.size());
  place_ = collect<Index>(
      arena_, blocks.size(), grain(blocks.size(), static_cast<std::size_t>(cells.point_count())),
      [&](std::size_t begin, std::size_t end, std::vector<Index>& near, int worker) {
        for (std::size_t b = begin; b < end; ++b) {
          const std::size_t before = near.size();
          squares[b] = sum_block(blocks[b], cells, scratch_[worker], &inner[b * sum_size()], near);
          kept[b] = near.size() - before;
        }
      });
  inner_.assign(cells.site_count() * sum_size(), 0.0);
  first_.assign(1, 0);
  for (const SiteNumber s : cells.sites()) {
    std::size_t points = 0;
    for (std::size_t b = first_block[s]; b < first_block[s + 1]; ++b) {
      points += kept[b];
      for (std::size_t v = 0; v < sum_size(); ++v) {
        inner_[s * sum_size() + v] += inner[b * sum_size() + v];
      }
    }
    first_.push_back(first_.back() + points);
  }
  squares = joined(tiling_.ranks(), std::move(squares));
  squares_ =
      sum_of(arena_, squares.size(), kSitesPerGrain, [&](std::size_t b) { return squares[b]; });
}

/// Appends the places of the points of a block that are near a border, and sums the others. Returns
/// the squares of all.
template <class Scalar>
double Borders<Scalar>::sum_block(const Block& block, const Cells<Scalar>& cells, Scratch& own,
                                  double* inner, std::vector<Index>& near) const {
  const auto& [cell, begin, end] = block;
  const std::size_t size = block.size();
  own.make_room(kBlock, dimension_);
  const Scalar* stream = cells.block(cell) + begin;
  for (std::size_t d = 0; d < dimension_; ++d, stream += cells.size(cell)) {
    views_.relative(cell, d, {stream, size}, &own.points[d * size]);
  }
  const auto count = static_cast<Index>(size);
  const Index found = kernels::contested_places(
      own.points.data(), count, count, static_cast<int>(dimension_), views_.seen_from(cell),
      static_cast<Scalar>(threshold_[cell]), own.places.data());
  const std::span<const Index> places =
      std::span(own.places).first(static_cast<std::size_t>(found));
  for (const Index place : places) near.push_back(static_cast<Index>(begin) + place);
  inner[0] = count - found;
  double squares = 0;
  for (std::size_t d = 0; d < dimension_; ++d) {
    const Scalar* const x = &own.points[d * size];
    Sums sums;
    sums.add(x, size);
    inner[1 + d] = Sums::of(sums.sum);
    squares += Sums::of(sums.squares);
    for (const Index place : places) inner[1 + d] -= x[place];
  }
  return squares;
}

/// The points near borders, with room for what is counted of them.
template <class Scalar>
void Borders<Scalar>::keep(const Cells<Scalar>& cells) {
  points_.reset(place_.size() * dimension_);
  owner_.reset(place_.size());
  blocks_.clear();
  first_block_.assign(1, 0);
  first_part_.assign(1, 0);
  for (const SiteNumber s : cells.sites()) {
    for (std::size_t k = 0; k < stride(s); k += kBlock) {
      blocks_.push_back({s, k, std::min(k + kBlock, stride(s))});
      first_part_.push_back(first_part_.back() + views_.count(s));
    }
    first_block_.push_back(blocks_.size());
  }
  parts_.reset(first_part_.back() * part_size());
  totals_.reset(blocks_.size() * dimension_);
  arena_.for_each(blocks_.size(), grain(blocks_.size(), place_.size()), [&](std::size_t b) {
    const auto& [cell, begin, end] = blocks_[b];
    const Scalar* stream = cells.block(cell);
    const Index* const place = place_.data() + first_[cell];
    Scalar* out = points_.data() + first_[cell] * dimension_;
    for (std::size_t d = 0; d < dimension_; ++d) {
      for (std::size_t k = begin; k < end; ++k) {
        out[k] = views_.relative(cell, stream[place[k]], d);
      }
      Sums sums;
      sums.add(out + begin, end - begin);
      totals_[b * dimension_ + d] = Sums::of(sums.sum);
      stream += cells.size(cell);
      out += stride(cell);
    }
  });
}

template <class Scalar>
void Borders<Scalar>::count(const PowerDiagram& diagram) {
  const std::size_t sites = capacity_.size();
  constexpr double kMostOfOne = 2;  // one site that leaps does not end it for all
  used_ = sum_of(arena_, sites, kSitesPerGrain,
                 [&](std::size_t s) {
                   return std::min(kMostOfOne, views_.move(SiteNumber(s), diagram));
                 }) /
          static_cast<double>(sites);
  std::vector<double> energy(blocks_.size());
  arena_.for_ranges(blocks_.size(), grain(blocks_.size(), place_.size()),
                    [&](std::size_t begin, std::size_t end, int worker) {
                      for (std::size_t b = begin; b < end; ++b) {
                        energy[b] = count_block(b, scratch_[worker]);
                      }
                    });
  surplus_.resize(sites);
  to_centroid_.resize(sites * dimension_);
  at_border_.resize(views_.count() * sum_size());
  mass_.resize(views_.count());
  exchange_parts();
  std::vector<double> of_sites(sites);
  for_each_site(arena_, tiling_, [&](SiteNumber s) { of_sites[s] = gather(s, diagram); });
  share_counts(of_sites);
  energy = joined(tiling_.ranks(), std::move(energy));
  energy_ = squares_;
  energy_ +=
      sum_of(arena_, energy.size(), kSitesPerGrain, [&](std::size_t b) { return energy[b]; });
  energy_ += sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t s) { return of_sites[s]; });
}

/// Counts the points of a block into its parts. What they add to their owners' energy, but for the
/// squares.
template <class Scalar>
double Borders<Scalar>::count_block(std::size_t number, Scratch& own) {
  const Block& block = blocks_[number];
  const SiteNumber cell = block.cell;
  const std::size_t step = stride(cell);
  const Scalar* const points = points_.data() + first_[cell] * dimension_ + block.begin;
  const auto width = static_cast<Scalar>(width_[cell]);
  const auto dimension = static_cast<int>(dimension_);
  own.make_room(kBlock, dimension_);
  const Index found =
      kernels::contested_places(points, static_cast<Index>(step), static_cast<Index>(block.size()),
                                dimension, views_.seen_from(cell), width, own.places.data());
  const auto contested = static_cast<std::size_t>(found);
  for (std::size_t d = 0; d < dimension_; ++d) {
    for (std::size_t k = 0; k < contested; ++k) {
      own.points[d * contested + k] = points[d * step + static_cast<std::size_t>(own.places[k])];
    }
  }
  kernels::nearest_powers<Scalar>(own.points.data(), found, found, dimension,
                                  views_.seen_from(cell),
                                  {own.nearest.data(), own.next.data(), own.margin.data()});

  double* const parts = &parts_[first_part_[number] * part_size()];
  std::fill_n(parts, views_.count(cell) * part_size(), 0.0);
  parts[0] = static_cast<double>(block.size());
  std::copy_n(&totals_[number * dimension_], dimension_, parts + 1);
  Index* const owner = owner_.data() + first_[cell] + block.begin;
  std::fill_n(owner, block.size(), 0);
  for (std::size_t k = 0; k < contested; ++k) {
    const auto to = static_cast<std::size_t>(own.nearest[k]);
    const auto next = static_cast<std::size_t>(own.next[k]);
    if (own.margin[k] < width && (to == 0 || next == 0)) {
      double* const at_border = parts + (to + next) * part_size() + sum_size();
      at_border[0] += 1;
      for (std::size_t d = 0; d < dimension_; ++d)
        at_border[1 + d] += own.points[d * contested + k];
    }
    if (to == 0) continue;
    owner[own.places[k]] = own.nearest[k];
    double* const part = parts + to * part_size();
    part[0] += 1;
    parts[0] -= 1;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double x = own.points[d * contested + k];
      part[1 + d] += x;
      parts[1 + d] -= x;
    }
  }

  double energy = 0;
  for (const View view : views_.of(cell)) {
    double* const part = parts + (view - views_.own(cell)) * part_size();
    double along = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      along += views_.at(view)[d] * part[1 + d];
      part[1 + d] -= part[0] * views_.at(view)[d];
    }
    energy += part[0] * views_.squared_distance(view) - 2 * along;
  }
  return energy;
}

/// Adds up what cells have counted for a site. What its inner points add to the energy, and its
/// weight.
template <class Scalar>
double Borders<Scalar>::gather(SiteNumber site, const PowerDiagram& diagram) {
  const View own = views_.own(site);
  const double* const inner = &inner_[site * sum_size()];
  double* const to = &to_centroid_[site * dimension_];
  double points = inner[0];
  double energy = points * views_.squared_distance(own);
  for (std::size_t d = 0; d < dimension_; ++d) {
    to[d] = inner[1 + d] - points * views_.at(own)[d];
    energy -= 2 * views_.at(own)[d] * inner[1 + d];
  }
  const auto add = [&](const double* part) {
    points += part[0];
    for (std::size_t d = 0; d < dimension_; ++d) to[d] += part[1 + d];
  };
  for (const View view : views_.of(site)) {
    const SiteNumber cell = views_.site(view);
    const View twin = views_.twin(view);
    for (std::size_t b = first_block_[cell]; b < first_block_[cell + 1]; ++b) {
      add(&parts_[(first_part_[b] + (twin - views_.own(cell))) * part_size()]);
    }
    if (!of_others_.empty()) {
      const auto [begin, blocks] = of_others_[twin];
      for (std::size_t b = 0; b < blocks; ++b) add(&sums_of_others_[begin + b * sum_size()]);
    }
    double* const at_border = &at_border_[view * sum_size()];
    std::fill_n(at_border, sum_size(), 0.0);
    for (std::size_t b = first_block_[site]; b < first_block_[site + 1]; ++b) {
      const double* const part = &parts_[(first_part_[b] + (view - own)) * part_size()];
      for (std::size_t v = 0; v < sum_size(); ++v) at_border[v] += part[sum_size() + v];
    }
    mass_[view] = at_border[0];
  }
  surplus_[site] = points - capacity_[site];
  for (std::size_t d = 0; d < dimension_; ++d) to[d] = points > 0 ? to[d] / points : 0;
  return energy - diagram.weight[site] * surplus_[site];
}

template <class Scalar>
std::int64_t Borders<Scalar>::change_owners(Filling<Scalar>& filling) const {
  if (tiling_.ranks() != nullptr) return change_owners_on_ranks(filling);
  return with_dimension(
      dimension_, [&]<std::size_t Dimension>() { return change_owners_in<Dimension>(filling); });
}

/// `Dimension`: 0 for any. Where it is known, points take their coordinates along: to read these at
/// random takes longer.
template <class Scalar>
template <std::size_t Dimension>
std::int64_t Borders<Scalar>::change_owners_in(Filling<Scalar>& filling) const {
  using Leaving = Near<Scalar, Dimension>;
  // Whole tiles: two tasks must not write one journal.
  const auto tile = static_cast<std::size_t>(filling.tiles.sites_per_tile());
  Buffer<Leaving> leaving =
      collect_by_site<Leaving>(arena_, capacity_.size(), tile * (1 + kSitesPerGrain / tile),
                               [&](SiteNumber s, std::vector<Leaving>& out, int) {
                                 for_each_leaving(s, [&](Index place, SiteNumber to) {
                                   Leaving& own = out.emplace_back();
                                   own.site = to;
                                   if constexpr (Dimension > 0) {
                                     filling.cells.get(s, place, own.x.data());
                                   }
                                   own.point = filling.points.own(filling.take(s, place));
                                 });
                               });
  Buffer<Leaving> spare;
  add_near(arena_, leaving, spare, filling);
  return std::ssize(leaving.span());
}

template class Borders<float>;
template class Borders<double>;

}  // namespace ccvt
