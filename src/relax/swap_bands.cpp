#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "kernels/keys.h"
#include "relax/swap.h"

namespace ccvt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Points of a side of a band.
constexpr std::size_t kMost = 256;
constexpr std::size_t kLeast = 32;
constexpr Index kShare = 64;  ///< of the cell's
/// Places for points that come.
constexpr std::size_t kSpare = 32;
constexpr double kFirstShare = 0.125;  ///< of a band's width
constexpr int kFewUses = 8;            ///< a band that served fewer looks was too narrow
constexpr int kLongestWait = 32;       ///< of looks
/// Of the smaller cell, points: to keep what is known of a pair with fewer takes more memory than
/// it is worth.
constexpr Index kFewest = 16;
constexpr int kSearches = 4;  ///< until a pair has a band that exchanges nothing

/// Of candidates of which `moves` are the best, the key of the next best, or what bounds those of
/// points that are not among them, but for points that could not gain by any exchange.
template <class Better>
double next_key(const std::vector<Candidate>& all, const std::vector<Candidate>& moves,
                double others, const Better& better) {
  double weakest = moves.empty() ? 0 : moves.front().key;
  for (const Candidate& c : moves) weakest = better(weakest, c.key) ? c.key : weakest;
  std::size_t as_good = 0;
  double next = others;
  for (const Candidate& c : all) {
    if (!moves.empty() && !better(weakest, c.key)) {
      ++as_good;
    } else if (better(c.key, next)) {
      next = c.key;
    }
  }
  return as_good > moves.size() ? weakest : next;
}

}  // namespace

/// Brings what is copied of a cell up to date; false where that is not known, or there is no room.
/// Of all points that have come or left, only those are gone through that were near the cut.
template <class Scalar>
bool PairSwapper<Scalar>::follow(Side side, const Patches<Scalar>& patches, SiteNumber cell,
                                 BandSide<Scalar>& band) {
  if (band.of_all == patches.has(cell)) return false;
  if (band.of_all) return true;
  const typename Patches<Scalar>::Changes& changes = patches.changes(cell);
  if (changes.version != band.version) return false;
  const std::size_t first = std::exchange(band.known, changes.places.size());
  const auto count = static_cast<Index>(band.known - first);
  if (count == 0) return true;
  band.cut.extend(changes.box);
  // Of points that are farther away than any were, by a cut that was at most twice as long: when
  // the sites have come closer than that, nothing is decided by the band.
  band.cut.tolerance = std::max(band.cut.tolerance, 4 * cut_.tolerance());
  const auto near = [&](const std::vector<Scalar>& streams, std::vector<Index>& found) {
    found.resize(std::max(found.size(), static_cast<std::size_t>(count)));
    return found.data() + kernels::places_beyond(streams.data() + first,
                                                 static_cast<Index>(changes.room), count,
                                                 metric_.dimension(), band.cut.cut(), beyond(side),
                                                 static_cast<Scalar>(band.limit), found.data());
  };
  const Index* const came_end = near(changes.come, places_);
  const Index* const left_end = near(changes.left, places_left_);
  const Index* came = places_.data();
  const Index* left = places_left_.data();
  const auto dimension = static_cast<std::size_t>(metric_.dimension());
  while (came != came_end || left != left_end) {
    const bool is_near = left == left_end || (came != came_end && *came <= *left);
    const Index next = is_near ? *came : *left;
    left += left != left_end && *left == next ? 1 : 0;
    came += is_near ? 1 : 0;
    const std::size_t at = first + static_cast<std::size_t>(next);
    const Scalar* const coordinates = is_near ? changes.come.data() + at : nullptr;
    if (!band.replace(changes.places[at], coordinates, changes.room, dimension)) return false;
  }
  return true;
}

/// Of one cell of a pair, the points in the band; all of one that is not divided.
template <class Scalar>
auto PairSwapper<Scalar>::near_points(Side side, const Cells<Scalar>& cells, SiteNumber cell,
                                      const BandSide<Scalar>& band) const -> NearPoints {
  const kernels::Cut<Scalar> cut = cut_.straight_cut(side);
  if (band.of_all) {
    const Index all = cells.size(cell);
    const double none = side == Side::i ? -kInfinity : kInfinity;
    return {side, cut, cells.block(cell), all, all, nullptr, {none, none}};
  }
  return {side,
          cut,
          band.block.data(),
          static_cast<Index>(band.room),
          static_cast<Index>(band.places.size()),
          band.places.data(),
          cut_.bounds_since(side, band.cut, band.limit)};
}

/// The key farthest beyond the cut, or what bounds those of the other points.
template <class Scalar>
double PairSwapper<Scalar>::extreme(const NearPoints& near) const {
  const double others = near.others.of_kernels;
  if (near.count == 0) return others;
  const double key = kernels::extreme_key(near.block, near.stride, near.count, metric_.dimension(),
                                          near.cut, beyond(near.side));
  return is_beyond(near.side, key, others) ? key : others;
}

/// The points beyond `others`, but for those that are not beyond `opposite`, a key of the kernels,
/// by more than rounding.
template <class Scalar>
void PairSwapper<Scalar>::near_candidates(const NearPoints& near, double opposite, double others,
                                          std::vector<Candidate>& candidates) {
  candidates.clear();
  if (near.count == 0) return;
  make_room(static_cast<std::size_t>(near.count));
  const double sign = near.side == Side::i ? 1 : -1;
  const double beyond_others = others + cut_.kernels_differ(near.side);
  const double farther = is_beyond(near.side, beyond_others, opposite) ? beyond_others : opposite;
  const auto threshold = std::nextafter(static_cast<Scalar>(farther - sign * 2 * cut_.tolerance()),
                                        static_cast<Scalar>(-sign * kInfinity));
  const Index found =
      kernels::places_beyond(near.block, near.stride, near.count, metric_.dimension(), near.cut,
                             beyond(near.side), threshold, places_.data());
  for (Index k = 0; k < found; ++k) {
    const Index at = places_[static_cast<std::size_t>(k)];
    const double key = cut_.key(near.side, near.block, near.stride, at);
    if (is_beyond(near.side, key, others)) {
      candidates.push_back({key, near.places == nullptr ? at : near.places[at]});
    }
  }
}

/// Finds what to exchange in the band of a pair; false where the points outside may count. First by
/// a part of it: mostly few move, and the others need not be told apart.
template <class Scalar>
bool PairSwapper<Scalar>::within_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                                      const SiteState& sites, SiteNumber i, SiteNumber j,
                                      KnownPair<Scalar>& known) {
  Band<Scalar>& band = *known.band;
  if (!band.valid) return false;
  band.valid =
      band.first == i && follow(Side::i, patches, i, band.i) && follow(Side::j, patches, j, band.j);
  if (!band.valid) return false;
  const NearPoints near_i = near_points(Side::i, cells, i, band.i);
  const NearPoints near_j = near_points(Side::j, cells, j, band.j);
  const double highest = extreme(near_i);
  const double lowest = extreme(near_j);
  ++band.uses;
  if (highest + cut_.tolerance() <= lowest - cut_.tolerance()) {
    moves_.clear();
    band.level = (highest + lowest) / 2;
    const NearPoints& large = patches.has(i) ? near_i : near_j;
    known.apart.note({metric_, cut_, cells, patches, sites, i, j}, large.block, large.stride,
                     large.count, large.others.of_kernels);
    return true;
  }
  for (const double share : {kFirstShare, 1.0}) {
    const double others_i = std::max(near_i.others.exact, band.level - share * band.i.width);
    const double others_j = std::min(near_j.others.exact, band.level + share * band.j.width);
    near_candidates(near_i, lowest, others_i, moves_.from_i);
    near_candidates(near_j, highest, others_j, moves_.from_j);
    known_.from_i = moves_.from_i;
    known_.from_j = moves_.from_j;
    select(cells, sites, i, j);
    // As many move as of all points, when the next two would not gain.
    const double next_i = next_key(known_.from_i, moves_.from_i, others_i, std::greater<>());
    const double next_j = next_key(known_.from_j, moves_.from_j, others_j, std::less<>());
    if (next_i - next_j <= margin_) {
      const double met_i = std::isinf(next_i) ? next_j : next_i;
      band.level = (met_i + (std::isinf(next_j) ? next_i : next_j)) / 2;
      return true;
    }
  }
  return band.valid = false;
}

/// Copies the points of a cell that are near the cut; of one that is not divided all are looked at
/// where they are.
template <class Scalar>
bool PairSwapper<Scalar>::copy_band(Side side, const Cells<Scalar>& cells,
                                    const Patches<Scalar>& patches, SiteNumber cell,
                                    SiteNumber other, double level, Part& part,
                                    BandSide<Scalar>& band) {
  const bool was_of_all = std::exchange(band.of_all, !patches.has(cell));
  if (band.of_all) {
    band.width = kInfinity;
    return true;
  }
  if (was_of_all) band.width = 0;
  const Index size = cells.size(cell);
  const Index others = std::min(size, cells.size(other));
  const auto wanted = static_cast<std::size_t>(patches.has(other) ? size / kShare : others);
  const std::size_t most = std::clamp(wanted, kLeast, kMost);
  if (band.width == 0) {
    // The cut is as long as the smaller cell, of points that are spread as in this one.
    const double depth = 1.0 / metric_.dimension();
    band.width = cut_.length() * cut_.length() * static_cast<double>(most) / 2 /
                 (std::pow(size, depth) * std::pow(others, 1 - depth));
  }
  std::size_t count = 0;
  Scalar limit = 0;
  for (int attempt = 0;; ++attempt, band.width /= 4) {
    limit = static_cast<Scalar>(side == Side::i ? level - band.width : level + band.width);
    choose(side, size, limit, part);
    count = static_cast<std::size_t>(find_beyond(cells, cell, side, part, limit));
    if (count <= most) break;
    if (attempt == 5) return false;
  }
  const typename Patches<Scalar>::Changes& changes = patches.changes(cell);
  band.version = changes.version;
  band.known = changes.places.size();
  band.limit = limit;
  cut_.keep(side, patches.low(cell), patches.high(cell), band.cut);
  band.places.assign(places_.data(), places_.data() + count);
  band.room = count + kSpare;
  const auto dimension = static_cast<std::size_t>(metric_.dimension());
  band.block.resize(band.room * dimension);
  const Scalar* stream = cells.block(cell);
  for (std::size_t d = 0; d < dimension; ++d, stream += size) {
    for (std::size_t k = 0; k < count; ++k) band.block[d * band.room + k] = stream[band.places[k]];
  }
  band.copied = true;
  return true;
}

/// Makes a band around where the cells met the last time.
template <class Scalar>
void PairSwapper<Scalar>::make_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                                    SiteNumber i, SiteNumber j, Band<Scalar>& band) {
  for (BandSide<Scalar>* const side : {&band.i, &band.j}) {
    const bool too_narrow = band.uses < kFewUses && side->places.size() < kLeast;
    if (std::exchange(side->copied, false) && too_narrow) side->width *= 2;
  }
  divide(patches, i, Side::i, part_i_);
  divide(patches, j, Side::j, part_j_);
  band.first = i;
  band.uses = 0;
  band.valid = copy_band(Side::i, cells, patches, i, j, band.level, part_i_, band.i) &&
               copy_band(Side::j, cells, patches, j, i, band.level, part_j_, band.j);
}

/// Finds what to exchange by the band of a pair, which is made anew where it no longer serves;
/// false where both cells must be searched.
template <class Scalar>
bool PairSwapper<Scalar>::search_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                                      const SiteState& sites, SiteNumber i, SiteNumber j,
                                      KnownPair<Scalar>& known) {
  if (known.band == nullptr) return false;
  Band<Scalar>& band = *known.band;
  if (within_band(cells, patches, sites, i, j, known)) return true;
  if (band.wait-- > 0) return false;
  band.wait = 0;
  make_band(cells, patches, i, j, band);
  if (within_band(cells, patches, sites, i, j, known)) {
    band.failures = 0;
    return true;
  }
  band.wait = band.failures = std::min(band.failures + 1, kLongestWait);
  return false;
}

/// Whether a pair may have a band.
template <class Scalar>
bool PairSwapper<Scalar>::has_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                                   SiteNumber i, SiteNumber j) const {
  return cut_.straight() && (patches.has(i) || patches.has(j)) &&
         std::min(cells.size(i), cells.size(j)) >= kFewest;
}

/// After a search of both cells: gives the pair a band when they have exchanged points, or have
/// been searched often.
template <class Scalar>
void PairSwapper<Scalar>::note_search(KnownPair<Scalar>& known) const {
  if (known.band == nullptr) {
    if (moves_.from_i.empty() && ++known.searches < kSearches) return;
    known.band = std::make_unique<Band<Scalar>>();
  }
  known.band->level = level();
}

/// After a search of both cells: the key where they meet.
template <class Scalar>
double PairSwapper<Scalar>::level() const {
  if (moves_.from_i.empty()) return (bounds_.highest_i + bounds_.lowest_j) / 2;
  const auto less = [](const Candidate& a, const Candidate& b) { return a.key < b.key; };
  return (std::min_element(moves_.from_i.begin(), moves_.from_i.end(), less)->key +
          std::max_element(moves_.from_j.begin(), moves_.from_j.end(), less)->key) /
         2;
}

template class PairSwapper<float>;
template class PairSwapper<double>;

}  // namespace ccvt
