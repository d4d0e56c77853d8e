#include "relax/meeting_pairs.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <utility>

#include "parallel/together.h"
#include "schedule/own_pairs.h"

namespace ccvt {
namespace {

/// Of the radius. A thicker skin lasts longer but adds pairs that do not meet.
constexpr double kSkin = 0.2;
/// Of the sites: so many may be entered anew before the list is made again.
constexpr std::size_t kMovedShare = 8;
/// Of the sites: so many, or about, are searched apart when a sphere is entered anew.
constexpr std::ptrdiff_t kFarShare = 32;
/// Of how many sites that share is taken.
constexpr std::size_t kMostSampled = 4096;
/// Of the sites: so many may be looked at while spheres are entered anew.
constexpr std::size_t kMostNear = 16;
/// Rounding in distances must not lose a pair.
constexpr double kRounding = 1 + 1e-12;
constexpr std::size_t kSitesPerGrain = 1024;
constexpr std::size_t kSitesPerSearch = 64;
constexpr std::size_t kMovedPerSearch = 8;

/// Pairs are searched from the site with the larger reach, so that one far-reaching site does not
/// make every search wide.
bool searches(const std::vector<double>& reach, SiteNumber site, SiteNumber other) {
  const double own = reach[site];
  const double others = reach[other];
  return own != others ? own > others : site < other;
}

/// What all of `reach` but a share of 1 / kFarShare, or about, are at most.
double usual(const std::vector<double>& reach) {
  const std::size_t step = (reach.size() + kMostSampled - 1) / kMostSampled;
  std::vector<double> sample;
  for (std::size_t s = 0; s < reach.size(); s += step) sample.push_back(reach[s]);
  const auto rank = sample.end() - 1 - std::ssize(sample) / kFarShare;
  std::nth_element(sample.begin(), rank, sample.end());
  return *rank;
}

}  // namespace

Buffer<SiteNumber> MeetingPairs::outgrown(const Metric& metric, const SiteState& sites,
                                          const Tiling& tiling, const Arena& arena) const {
  const auto is_inside = [&](SiteNumber s) {
    const double room = reach_[s] - sites.radius[s];
    return room >= 0 && metric.squared_distance(sites.at(s), at(s)) * kRounding <= room * room;
  };
  return collect_by_site_together<SiteNumber>(
      arena, tiling, kSitesPerGrain, [&](SiteNumber site, std::vector<SiteNumber>& left, int) {
        if (!is_inside(site)) left.push_back(site);
      });
}

void MeetingPairs::enter(const SiteState& sites, SiteNumber site) {
  std::copy_n(sites.at(site), dimension_, &position_[site * dimension_]);
  reach_[site] = sites.radius[site] * (1 + kSkin);
}

/// Some of the sites, to be searched where they have been entered.
MeetingPairs::Group MeetingPairs::group(const Metric& metric, std::span<const SiteNumber> sites,
                                        const Arena& arena) const {
  std::vector<double> positions(sites.size() * dimension_);
  arena.for_each(sites.size(), kSitesPerGrain, [&](std::size_t k) {
    std::copy_n(at(sites[k]), dimension_, &positions[k * dimension_]);
  });
  const double largest_reach = reduce(
      arena, sites.size(), kSitesPerGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (const SiteNumber site : sites.subspan(begin, end - begin)) {
          largest = std::max(largest, reach_[site]);
        }
        return largest;
      },
      [](double x, double y) { return std::max(x, y); });
  return {SiteSearch(metric, positions, arena), largest_reach};
}

/// Of two spheres as far apart as this where they have been entered.
bool MeetingPairs::may_meet(SiteNumber a, SiteNumber b, double squared) const {
  const double both = reach_[a] + reach_[b];
  return squared <= both * both * kRounding;
}

MeetingPairs::Refreshed MeetingPairs::refresh(const Metric& metric, const SiteState& sites,
                                              const Tiling& tiling, const Arena& arena,
                                              std::size_t limit) {
  if (search_) {
    const Buffer<SiteNumber> left = outgrown(metric, sites, tiling, arena);
    if (left.empty()) return Refreshed::unchanged;
    const std::size_t moved = moved_.size() + left.size();
    if (moved <= sites.count() / kMovedShare && extend(metric, sites, tiling, left, arena)) {
      return Refreshed::extended;
    }
  }
  return build(metric, sites, tiling, arena, limit) ? Refreshed::rebuilt : Refreshed::too_many;
}

bool MeetingPairs::build(const Metric& metric, const SiteState& sites, const Tiling& tiling,
                         const Arena& arena, std::size_t limit) {
  const std::size_t count = sites.count();
  dimension_ = sites.dimension;
  position_.resize(sites.position.size());
  reach_.resize(count);
  for_each_site(arena, count, kSitesPerGrain, [&](SiteNumber s) { enter(sites, s); });
  return list(metric, tiling, arena, limit);
}

/// Lists the pairs of the spheres that have been entered.
bool MeetingPairs::list(const Metric& metric, const Tiling& tiling, const Arena& arena,
                        std::size_t limit) {
  const std::size_t count = reach_.size();
  pairs_ = {};
  added_.clear();
  moved_.clear();
  before_ = {};
  search_.emplace(metric, position_, arena);

  usual_reach_ = usual(reach_);
  far_ = collect_by_site<SiteNumber>(arena, count, kSitesPerGrain,
                                     [&](SiteNumber s, std::vector<SiteNumber>& far, int) {
                                       if (reach_[s] > usual_reach_) far.push_back(s);
                                     });
  far_group_.reset();
  if (!far_.empty()) far_group_.emplace(group(metric, far_, arena));

  // Beyond the limit nothing more is looked for.
  std::atomic<std::size_t> found_here{0};
  PerWorker<std::vector<Index>> scratch(arena);
  Buffer<Pair> found = collect_of_own_sites<Pair>(
      arena, tiling, kSitesPerSearch,
      [&](NumberRange<SiteNumber> own, std::vector<Pair>& out, int w) {
        if (found_here > limit) return;
        const std::size_t before = out.size();
        for (const SiteNumber site : own) {
          const auto add = [&](Index k, double squared) {
            const SiteNumber other(k);
            if (searches(reach_, site, other) && may_meet(site, other, squared)) {
              out.push_back(Pair::ascending(site, other));
            }
          };
          search_->within(at(site), 2 * reach_[site] * kRounding, scratch[w], add);
        }
        found_here += out.size() - before;
      });
  if (std::cmp_greater(total(tiling.ranks(), static_cast<std::int64_t>(found.size())), limit)) {
    search_.reset();
    return false;
  }
  pairs_ = pairs_by_first(arena, with_pairs_of_others(tiling, std::move(found)), count);
  return true;
}

bool MeetingPairs::listed(const Pair& pair) const {
  const auto own = pairs_[pair.first];
  return std::binary_search(own.begin(), own.end(), pair);
}

/// Enters the spheres that have left theirs, and adds the pairs that may now meet. False when that
/// takes longer than to make the list again: small spheres among many, sought as far as most reach.
bool MeetingPairs::extend(const Metric& metric, const SiteState& sites, const Tiling& tiling,
                          std::span<const SiteNumber> left, const Arena& arena) {
  for (const SiteNumber site : left) {
    if (std::binary_search(moved_.begin(), moved_.end(), site)) continue;
    before_.site.push_back(site);
    before_.position.insert(before_.position.end(), at(site), at(site) + dimension_);
    before_.reach.push_back(reach_[site]);
  }
  arena.for_each(left.size(), kSitesPerGrain, [&](std::size_t k) { enter(sites, left[k]); });
  std::vector<SiteNumber> moved_before;
  moved_before.swap(moved_);
  std::set_union(moved_before.begin(), moved_before.end(), left.begin(), left.end(),
                 std::back_inserter(moved_));

  const Group moved = group(metric, moved_, arena);
  struct Scratch {
    std::vector<Index> found;
    std::size_t near = 0;
  };
  PerWorker<Scratch> scratch(arena);
  std::atomic<std::size_t> near{0};
  const auto search = [&](SiteNumber site, std::vector<Pair>& fresh, Scratch& own) {
    const double reach = reach_[site];
    const auto add = [&](SiteNumber other, double squared) {
      ++own.near;
      if (other == site || !may_meet(site, other, squared)) return;
      const Pair pair = Pair::ascending(site, other);
      if (!listed(pair)) fresh.push_back(pair);
    };
    const auto add_from = [&](std::span<const SiteNumber> members, const Group& group) {
      group.search.within(at(site), (reach + group.largest_reach) * kRounding, own.found,
                          [&](Index k, double squared) { add(members[SiteNumber(k)], squared); });
    };
    search_->within(at(site), (reach + usual_reach_) * kRounding, own.found, [&](Index k, double) {
      const SiteNumber other(k);
      add(other, metric.squared_distance(at(site), at(other)));
    });
    if (far_group_) add_from(far_, *far_group_);
    add_from(moved_, moved);
  };
  const std::size_t most_near = kMostNear * reach_.size();
  const NumberRange<SiteNumber> own = tiling.own_sites();
  const auto first = std::lower_bound(left.begin(), left.end(), *own.begin());
  const std::span<const SiteNumber> own_left(first,
                                             std::lower_bound(first, left.end(), *own.end()));
  Buffer<Pair> fresh =
      collect<Pair>(arena, own_left.size(), kMovedPerSearch,
                    [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int w) {
                      if (near > most_near) return;
                      scratch[w].near = 0;
                      for (std::size_t k = begin; k < end; ++k)
                        search(own_left[k], out, scratch[w]);
                      near += scratch[w].near;
                    });
  // Whether that is so does not depend on who looked where: every task looks at as many, and who
  // gives up has looked at more than all may.
  if (total(tiling.ranks(), static_cast<std::int64_t>(near)) >
      static_cast<std::int64_t>(most_near)) {
    return false;
  }
  fresh = sorted_pairs(arena, with_pairs_of_others(tiling, std::move(fresh)), reach_.size());
  std::vector<Pair> added_before;
  added_before.swap(added_);
  std::set_union(added_before.begin(), added_before.end(), fresh.begin(), fresh.end(),
                 std::back_inserter(added_));
  return true;
}

void MeetingPairs::save(ByteWriter& out, std::span<const Pair> added) const {
  out.put(search_.has_value());
  if (!search_) return;
  out.put(std::uint64_t{dimension_});
  out.put(position_);
  out.put(reach_);
  out.put(before_.site);
  out.put(before_.position);
  out.put(before_.reach);
  out.put(moved_);
  out.put(std::uint64_t{added.size()});
  out.put(added);
}

void MeetingPairs::load(ByteReader& in, const Metric& metric, const Tiling& tiling,
                        const Arena& arena) {
  forget();
  if (!in.get<bool>()) return;
  dimension_ = static_cast<std::size_t>(in.get<std::uint64_t>());
  std::vector<double> position = in.get_all<double>();
  std::vector<double> reach = in.get_all<double>();
  if (dimension_ != metric.coordinate_count() || position.size() != reach.size() * dimension_) {
    throw Damaged();
  }
  Entered before;
  before.site = in.get_numbers<SiteNumber>(reach.size());
  before.position = in.get_all<double>(before.site.size() * dimension_);
  before.reach = in.get_all<double>(before.site.size());
  std::vector<SiteNumber> moved = in.get_numbers<SiteNumber>(reach.size());
  std::vector<Pair> added = in.get_all<Pair>();
  for (const Pair& pair : added) {
    if (std::max(pair.first, pair.second) >= reach.size()) throw Damaged();
  }
  std::erase_if(added, [&](const Pair& pair) { return !has_own_site(tiling, pair); });
  position_ = position;
  reach_ = reach;
  for (std::size_t k = 0; k < before.site.size(); ++k) {
    reach_[before.site[k]] = before.reach[k];
    std::copy_n(&before.position[k * dimension_], dimension_,
                &position_[before.site[k] * dimension_]);
  }
  list(metric, tiling, arena, SIZE_MAX);
  position_ = std::move(position);
  reach_ = std::move(reach);
  before_ = std::move(before);
  moved_ = std::move(moved);
  added_ = std::move(added);
}

}  // namespace ccvt
