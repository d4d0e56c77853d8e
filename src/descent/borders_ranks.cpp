// Borders of cells that are on several ranks.
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "descent/borders.h"
#include "parallel/bytes.h"
#include "parallel/together.h"
#include "relax/moved_points.h"

namespace ccvt {

/// What blocks of a rank's cells have for sites of others goes to these.
template <class Scalar>
void Borders<Scalar>::exchange_parts() {
  Ranks* const ranks = tiling_.ranks();
  if (ranks == nullptr) return;
  std::vector<ByteWriter> to(static_cast<std::size_t>(ranks->count()));
  for (const SiteNumber cell : tiling_.own_sites()) {
    for (const View view : views_.of(cell)) {
      const Tile tile = tiling_.tile_of(views_.site(view));
      if (tiling_.is_own(tile)) continue;
      ByteWriter& message = to[static_cast<std::size_t>(tiling_.rank_of(tile))];
      message.put(view);
      message.put(first_block_[cell + 1] - first_block_[cell]);
      for (std::size_t b = first_block_[cell]; b < first_block_[cell + 1]; ++b) {
        const std::size_t part = first_part_[b] + (view - views_.own(cell));
        message.put(std::span<const double>(&parts_[part * part_size()], sum_size()));
      }
    }
  }
  of_others_.assign(views_.count(), {});
  sums_of_others_.clear();
  for (const Ranks::Bytes& bytes : exchanged(*ranks, std::move(to))) {
    ByteReader message(bytes);
    while (!message.done()) {
      const auto view = message.get<View>();
      const std::size_t begin = sums_of_others_.size();
      of_others_[view] = {begin, message.get<std::size_t>()};
      sums_of_others_.resize(begin + of_others_[view].blocks * sum_size());
      message.get(std::span(sums_of_others_).subspan(begin));
    }
  }
}

/// What ranks have counted of their sites, on all; and `energy`, of each site.
template <class Scalar>
void Borders<Scalar>::share_counts(std::vector<double>& energy) {
  Ranks* const ranks = tiling_.ranks();
  if (ranks == nullptr) return;
  /// Calls with(numbers) for those that are of some sites.
  const auto for_each = [&](SiteNumber begin, SiteNumber end, const auto& with) {
    const auto of_sites = [&](std::vector<double>& all, std::size_t each) {
      with(std::span(all).subspan(begin * each, (end - begin) * each));
    };
    of_sites(surplus_, 1);
    of_sites(energy, 1);
    of_sites(to_centroid_, dimension_);
    with(std::span(mass_).subspan(views_.own(begin), views_.own(end) - views_.own(begin)));
  };
  const NumberRange<SiteNumber> own = tiling_.own_sites();
  ByteWriter counts;
  counts.put(*own.begin());
  counts.put(*own.end());
  for_each(*own.begin(), *own.end(),
           [&](std::span<double> numbers) { counts.put(std::span<const double>(numbers)); });
  for (const Ranks::Bytes& bytes : ranks->gather(counts.bytes)) {
    ByteReader reader(bytes);
    const auto begin = reader.get<SiteNumber>();
    const auto end = reader.get<SiteNumber>();
    for_each(begin, end, [&](std::span<double> numbers) { reader.get(numbers); });
  }
}

/// Of views from cells of each rank, to all.
template <class Scalar>
void Borders<Scalar>::share_leaving(std::vector<double>& leaving) const {
  if (tiling_.ranks() == nullptr) return;
  const NumberRange<SiteNumber> own = tiling_.own_sites();
  const auto at = [&](SiteNumber s) {
    return leaving.begin() + static_cast<std::ptrdiff_t>(views_.own(s).index());
  };
  leaving = joined(tiling_.ranks(), std::vector<double>(at(*own.begin()), at(*own.end())));
}

template <class Scalar>
std::int64_t Borders<Scalar>::change_owners_on_ranks(Filling<Scalar>& filling) const {
  MovedPoints<Scalar> moved(filling);
  std::int64_t count = 0;
  for (const SiteNumber s : tiling_.own_sites()) {
    for_each_leaving(s, [&](Index place, SiteNumber to) {
      moved.take(s, place, to);
      ++count;
    });
  }
  moved.arrive(arena_);
  return total(tiling_.ranks(), count);
}

#define CCVT_INSTANTIATE(Scalar)                                            \
  template void Borders<Scalar>::exchange_parts();                          \
  template void Borders<Scalar>::share_counts(std::vector<double>&);        \
  template void Borders<Scalar>::share_leaving(std::vector<double>&) const; \
  template std::int64_t Borders<Scalar>::change_owners_on_ranks(Filling<Scalar>&) const;

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
