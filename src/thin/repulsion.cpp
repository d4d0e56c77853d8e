#include "thin/repulsion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "schedule/tiling.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 32;
/// Of what repels a site.
constexpr double kLeastGain = 1e-4;
/// The same of a jump.
constexpr double kLeastJump = 0.1;
/// What repels a site so little is no matter: of a pair at nine tenths of its reach.
constexpr double kLeastRepulsion = 1e-8;
/// Rounds of jumps; a tenth of them is usual.
constexpr int kMostFillings = 100;
/// How far a site looks, of its home's reach. With few points a home there is little to look at.
constexpr double kHop = 1;
constexpr double kShortHop = 0.5;
constexpr std::size_t kManyPoints = 16;
/// Homes of which each worker knows what was gathered, 1 MB with about 60 others each: sites near
/// each other look at the same ones (300,000 points in space, a tenth chosen: 9 s without, 5 with).
constexpr std::size_t kRecent = 512;

/// At the squared distance, below the squared reach.
double weight(double squared, double reach) {
  const double near = 1 - std::sqrt(squared) / reach;
  const double second = near * near;
  const double fourth = second * second;
  return fourth * fourth;
}

template <class A, class B>
double squared_distance(const A* a, const B* b, std::size_t dimension) {
  double sum = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    const double to = a[d];
    const double difference = to - b[d];
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

template <class Scalar>
Repulsion<Scalar>::Repulsion(const Homes<Scalar>& homes, std::vector<Place> chosen,
                             const Arena& arena)
    : homes_(homes),
      arena_(arena),
      quotas_(homes.reach,
              static_cast<double>(homes.home_of.size()) / static_cast<double>(homes.count())),
      chosen_(std::move(chosen)),
      at_(chosen_.size() * homes.dimension()),
      taken_(homes.home_of.size(), 0),
      first_in_(homes.count(), SiteNumber::none()),
      next_in_(homes.count(), SiteNumber::none()),
      is_restless_(homes.count(), 0),
      recent_(arena, Recent(kRecent)) {
  for (const SiteNumber s : sites_below(chosen_.size())) enter(s, chosen_[s]);
}

template <class Scalar>
void Repulsion<Scalar>::enter(SiteNumber site, Place place) {
  const SiteNumber home = homes_.home_of[place];
  chosen_[site] = place;
  std::copy_n(homes_.at(place), homes_.dimension(), at_.data() + site * homes_.dimension());
  taken_[place] = 1;
  quotas_.enter(home);
  next_in_[site] = std::exchange(first_in_[home], site);
}

template <class Scalar>
void Repulsion<Scalar>::leave(SiteNumber site, Place place) {
  const SiteNumber home = homes_.home_of[place];
  taken_[place] = 0;
  quotas_.leave(home);
  SiteNumber* link = &first_in_[home];
  while (*link != site) link = &next_in_[*link];
  *link = next_in_[site];
}

/// Calls visit(site, its home) for every site in a home near this one.
template <class Scalar>
template <class Visit>
void Repulsion<Scalar>::for_each_near(SiteNumber home, const Visit& visit) const {
  for (const SiteNumber near : homes_.near[home]) {
    for (SiteNumber s = first_in_[near]; s != SiteNumber::none(); s = next_in_[s]) visit(s, near);
  }
}

/// By how much others than `site` repel what is at `place`.
template <class Scalar>
double Repulsion<Scalar>::repelled(Place place, SiteNumber site) const {
  const SiteNumber home = homes_.home_of[place];
  double sum = 0;
  for_each_near(home, [&](SiteNumber other, SiteNumber near) {
    if (other == site) return;
    const double reach = homes_.reach_of(home, near);
    const double squared = squared_distance(homes_.at(place), at(other), homes_.dimension());
    if (squared < reach * reach) sum += weight(squared, reach);
  });
  return sum;
}

/// The chosen points that may repel what is in a home.
template <class Scalar>
auto Repulsion<Scalar>::gather(SiteNumber home, Recent& recent) const -> const Others& {
  Gathered& slot = recent[home % kRecent];
  Others& others = slot.others;
  if (slot.home == home && slot.time == time_) return others;
  slot.home = home;
  slot.time = time_;
  const std::size_t dimension = homes_.dimension();
  others.sites.clear();
  others.coordinates.clear();
  others.reach.clear();
  for_each_near(home, [&](SiteNumber other, SiteNumber near) {
    const Scalar* const there = at(other);
    const double reach = homes_.reach_of(home, near);
    const double farthest = (homes_.centres.radius[home] + reach) * (1 + 1e-12);
    if (squared_distance(there, homes_.centres.at(home), dimension) > farthest * farthest) return;
    others.sites.push_back(other);
    others.coordinates.insert(others.coordinates.end(), there, there + dimension);
    others.reach.push_back(reach);
  });
  return others;
}

/// What others than `site` repel there; or `most`, or more, where it is that much.
template <class Scalar>
double Repulsion<Scalar>::repelled_by(const Others& others, SiteNumber site, const Scalar* at,
                                      double most) const {
  double sum = 0;
  const double* other = others.coordinates.data();
  for (std::size_t k = 0; k < others.sites.size(); ++k, other += homes_.dimension()) {
    const double reach = others.reach[k];
    const double squared = squared_distance(at, other, homes_.dimension());
    if (!(squared < reach * reach) || others.sites[k] == site) continue;
    sum += weight(squared, reach);
    if (sum >= most) break;
  }
  return sum;
}

/// Appends the place in a home where least would be repelled, if one is free.
template <class Scalar>
void Repulsion<Scalar>::weigh_gap(SiteNumber home, Recent& recent, std::vector<Gap>& gaps) const {
  const Others& others = gather(home, recent);
  Gap gap{std::numeric_limits<double>::infinity(), Place::none()};
  for (const Place place : homes_.places(home)) {
    if (taken_[place] != 0) continue;
    const double sum = repelled_by(others, SiteNumber::none(), homes_.at(place), gap.repelled);
    if (sum < gap.repelled) gap = {sum, place};
  }
  if (gap.place != Place::none()) gaps.push_back(gap);
}

/// Appends the best move of a site, if it has one.
template <class Scalar>
void Repulsion<Scalar>::weigh(SiteNumber site, Recent& recent, std::vector<Move>& moves) const {
  const std::size_t dimension = homes_.dimension();
  const Place from = chosen_[site];
  const SiteNumber own = homes_.home_of[from];
  const Scalar* const at = homes_.at(from);
  const double before = repelled(from, site);
  if (before < kLeastRepulsion) return;
  const bool many = homes_.points[own].size() >= kManyPoints;
  const double hop = (many ? kShortHop : kHop) * homes_.reach[own];
  double least = before * (1 - kLeastGain);
  Place best = Place::none();
  for (const SiteNumber home : homes_.near[own]) {
    const double farthest = (homes_.centres.radius[home] + hop) * (1 + 1e-12);
    if (squared_distance(at, homes_.centres.at(home), dimension) > farthest * farthest) continue;
    if (!quotas_.allow(own, home)) continue;
    const Others& others = gather(home, recent);
    for (const Place place : homes_.places(home)) {
      if (taken_[place] != 0) continue;
      const Scalar* const there = homes_.at(place);
      if (squared_distance(there, at, dimension) > hop * hop) continue;
      const double sum = repelled_by(others, site, there, least);
      if (sum >= least) continue;
      least = sum;
      best = place;
    }
  }
  if (best != Place::none()) moves.push_back({before - least, site, best});
}

/// Those in a home may have a move now.
template <class Scalar>
void Repulsion<Scalar>::disturb(SiteNumber home) {
  for_each_near(home, [&](SiteNumber s, SiteNumber) {
    if (std::exchange(is_restless_[s], std::uint8_t{1}) == 0) restless_.push_back(s);
  });
}

template <class Scalar>
bool Repulsion<Scalar>::make(const Move& move, double least_gain) {
  const Place from = chosen_[move.site];
  if (taken_[move.to] != 0 || !quotas_.allow(homes_.home_of[from], homes_.home_of[move.to]) ||
      repelled(move.to, move.site) >= repelled(from, move.site) * (1 - least_gain)) {
    return false;
  }
  leave(move.site, from);
  enter(move.site, move.to);
  disturb(homes_.home_of[from]);
  disturb(homes_.home_of[move.to]);
  return true;
}

/// Moves the restless to places near.
template <class Scalar>
void Repulsion<Scalar>::round() {
  ++rounds_;
  ++time_;
  std::vector<SiteNumber> looking = std::exchange(restless_, {});
  std::sort(looking.begin(), looking.end());  // numbers are in the order of space
  for (const SiteNumber s : looking) is_restless_[s] = 0;
  Buffer<Move> moves =
      collect<Move>(arena_, looking.size(), kSitesPerGrain,
                    [&](std::size_t begin, std::size_t end, std::vector<Move>& out, int worker) {
                      for (std::size_t k = begin; k < end; ++k)
                        weigh(looking[k], recent_[worker], out);
                    });
  std::sort(moves.begin(), moves.end(), by_gain);
  for (const Move& move : moves) {
    if (make(move, kLeastGain / 2)) {
      ++moves_;
    } else if (std::exchange(is_restless_[move.site], std::uint8_t{1}) == 0) {
      restless_.push_back(move.site);  // for another
    }
  }
}

/// The sites that are repelled most jump to the places where they would be least. Whether any did.
template <class Scalar>
bool Repulsion<Scalar>::fill_gaps() {
  ++time_;
  Buffer<Gap> gaps = collect_by_site<Gap>(
      arena_, homes_.count(), kSitesPerGrain,
      [&](SiteNumber home, std::vector<Gap>& out, int w) { weigh_gap(home, recent_[w], out); });
  std::sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) {
    return a.repelled != b.repelled ? a.repelled < b.repelled : a.place < b.place;
  });
  Buffer<Move> crowded(chosen_.size());
  for_each_site(arena_, chosen_.size(), kSitesPerGrain, [&](SiteNumber s) {
    crowded[s] = {repelled(chosen_[s], s), s, Place::none()};
  });
  std::sort(crowded.begin(), crowded.end(), by_gain);
  bool jumped = false;
  for (std::size_t k = 0; k < std::min(gaps.size(), crowded.size()); ++k) {
    const double now = crowded[k].gain;
    if (now < kLeastRepulsion || gaps[k].repelled >= now * (1 - kLeastJump)) break;
    if (!make({0, crowded[k].site, gaps[k].place}, kLeastJump)) continue;
    ++jumps_;
    jumped = true;
  }
  return jumped;
}

template <class Scalar>
bool Repulsion<Scalar>::run() {
  for (const SiteNumber s : sites_below(chosen_.size())) restless_.push_back(s);
  std::fill(is_restless_.begin(), is_restless_.end(), std::uint8_t{1});
  try {
    int fillings = 0;
    do {
      while (!restless_.empty()) round();
    } while (fillings++ < kMostFillings && fill_gaps());
  } catch (const Stopped&) {
    return false;
  }
  return true;
}

template <class Scalar>
double Repulsion<Scalar>::energy() const {
  constexpr std::size_t kGrain = 1024;
  return sum_of(arena_, chosen_.size(), kGrain,
                [&](std::size_t s) { return repelled(chosen_[s], SiteNumber(s)); }) /
         2;
}

template class Repulsion<float>;
template class Repulsion<double>;

}  // namespace ccvt
