#include "relax/meeting_pairs.h"

#include <algorithm>
#include <atomic>

namespace ccvt {
namespace {

/// Of the radius. A thicker skin lasts longer but adds pairs that do not meet.
constexpr double kSkin = 0.2;
/// Of the sites: so many may be entered anew before the list is made again.
constexpr Index kMovedShare = 8;
/// Of the sites: so many are searched apart when a sphere is entered anew.
constexpr Index kFarShare = 32;
/// Of the sites: so many may be looked at while spheres are entered anew.
constexpr std::size_t kMostNear = 16;
/// Rounding in distances must not lose a pair.
constexpr double kRounding = 1 + 1e-12;
constexpr std::size_t kSitesPerGrain = 1024;
constexpr std::size_t kSitesPerSearch = 64;

/// Pairs are searched from the site with the larger reach, so that one far-reaching site does not
/// make every search wide.
bool searches(const std::vector<double>& reach, Index site, Index other) {
  const double own = reach[static_cast<std::size_t>(site)];
  const double others = reach[static_cast<std::size_t>(other)];
  return own != others ? own > others : site < other;
}

}  // namespace

Buffer<Index> MeetingPairs::outgrown(const Metric& metric, const SiteState& sites,
                                     const Arena& arena) const {
  const auto is_inside = [&](Index s) {
    const auto k = static_cast<std::size_t>(s);
    const double room = reach_[k] - sites.radius[k];
    return room >= 0 && metric.squared_distance(sites.at(s), at(s)) * kRounding <= room * room;
  };
  return collect<Index>(arena, reach_.size(), kSitesPerGrain,
                        [&](std::size_t begin, std::size_t end, std::vector<Index>& left, int) {
                          for (std::size_t s = begin; s < end; ++s) {
                            const auto site = static_cast<Index>(s);
                            if (!is_inside(site)) left.push_back(site);
                          }
                        });
}

void MeetingPairs::enter(const SiteState& sites, Index site) {
  std::copy_n(sites.at(site), dimension_,
              position_.begin() + static_cast<std::ptrdiff_t>(site) * dimension_);
  reach_[static_cast<std::size_t>(site)] =
      sites.radius[static_cast<std::size_t>(site)] * (1 + kSkin);
}

/// Some of the sites, to be searched where they have been entered.
MeetingPairs::Group MeetingPairs::group(const Metric& metric, std::span<const Index> sites,
                                        const Arena& arena) const {
  std::vector<double> positions;
  double largest_reach = 0;
  for (const Index s : sites) {
    positions.insert(positions.end(), at(s), at(s) + dimension_);
    largest_reach = std::max(largest_reach, reach_[static_cast<std::size_t>(s)]);
  }
  return {SiteSearch(metric, positions, arena), largest_reach};
}

/// Of two spheres as far apart as this where they have been entered.
bool MeetingPairs::may_meet(Index a, Index b, double squared) const {
  const double both = reach_[static_cast<std::size_t>(a)] + reach_[static_cast<std::size_t>(b)];
  return squared <= both * both * kRounding;
}

MeetingPairs::Refreshed MeetingPairs::refresh(const Metric& metric, const SiteState& sites,
                                              const Arena& arena, std::size_t limit) {
  if (search_) {
    const Buffer<Index> left = outgrown(metric, sites, arena);
    if (left.empty()) return Refreshed::unchanged;
    const auto moved = static_cast<Index>(moved_.size() + left.size());
    if (moved <= sites.count() / kMovedShare && extend(metric, sites, left, arena)) {
      return Refreshed::extended;
    }
  }
  return build(metric, sites, arena, limit) ? Refreshed::rebuilt : Refreshed::too_many;
}

bool MeetingPairs::build(const Metric& metric, const SiteState& sites, const Arena& arena,
                         std::size_t limit) {
  const auto count = static_cast<std::size_t>(sites.count());
  dimension_ = sites.dimension;
  position_.resize(sites.position.size());
  reach_.resize(count);
  arena.for_each(count, kSitesPerGrain,
                 [&](std::size_t s) { enter(sites, static_cast<Index>(s)); });
  pairs_ = {};
  added_.clear();
  moved_.clear();
  search_.emplace(metric, sites.position, arena);

  std::vector<double> sorted = reach_;
  const auto rank = static_cast<std::ptrdiff_t>(count - 1 - count / kFarShare);
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  usual_reach_ = sorted[static_cast<std::size_t>(rank)];
  far_ = collect<Index>(arena, count, kSitesPerGrain,
                        [&](std::size_t begin, std::size_t end, std::vector<Index>& far, int) {
                          for (std::size_t s = begin; s < end; ++s) {
                            if (reach_[s] > usual_reach_) far.push_back(static_cast<Index>(s));
                          }
                        });
  far_group_.reset();
  if (!far_.empty()) far_group_.emplace(group(metric, far_, arena));

  // Beyond the limit nothing more is looked for.
  std::atomic<std::size_t> total{0};
  PerWorker<std::vector<Index>> scratch(arena);
  Buffer<Pair> found =
      collect<Pair>(arena, count, kSitesPerSearch,
                    [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int w) {
                      if (total > limit) return;
                      const std::size_t before = out.size();
                      for (std::size_t s = begin; s < end; ++s) {
                        const auto site = static_cast<Index>(s);
                        const auto add = [&](Index other, double squared) {
                          if (searches(reach_, site, other) && may_meet(site, other, squared)) {
                            out.emplace_back(std::min(site, other), std::max(site, other));
                          }
                        };
                        search_->within(at(site), 2 * reach_[s] * kRounding, scratch[w], add);
                      }
                      total += out.size() - before;
                    });
  if (total > limit) {
    search_.reset();
    return false;
  }
  pairs_ = group_by_key(arena, std::move(found), count,
                        [](const Pair& pair) { return static_cast<std::size_t>(pair.first); });
  arena.for_each(count, kSitesPerGrain, [&](std::size_t s) {
    const auto own = pairs_[s];
    std::sort(own.begin(), own.end());
  });
  return true;
}

bool MeetingPairs::listed(const Pair& pair) const {
  const auto own = pairs_[static_cast<std::size_t>(pair.first)];
  return std::binary_search(own.begin(), own.end(), pair);
}

/// Enters the spheres that have left theirs, and adds the pairs that may now meet. False when that
/// takes longer than to make the list again: small spheres among many, sought as far as most reach.
bool MeetingPairs::extend(const Metric& metric, const SiteState& sites, std::span<const Index> left,
                          const Arena& arena) {
  arena.for_each(left.size(), kSitesPerGrain, [&](std::size_t k) { enter(sites, left[k]); });
  moved_.insert(moved_.end(), left.begin(), left.end());
  std::sort(moved_.begin(), moved_.end());
  moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());

  const Group moved = group(metric, moved_, arena);
  struct Scratch {
    std::vector<Index> found;
    std::size_t near = 0;
  };
  PerWorker<Scratch> scratch(arena);
  std::atomic<std::size_t> near{0};
  const auto search = [&](Index site, std::vector<Pair>& fresh, Scratch& own) {
    const double reach = reach_[static_cast<std::size_t>(site)];
    const auto add = [&](Index other, double squared) {
      ++own.near;
      if (other == site || !may_meet(site, other, squared)) return;
      const Pair pair(std::min(site, other), std::max(site, other));
      if (!listed(pair)) fresh.push_back(pair);
    };
    const auto add_from = [&](std::span<const Index> members, const Group& group) {
      group.search.within(
          at(site), (reach + group.largest_reach) * kRounding, own.found,
          [&](Index k, double squared) { add(members[static_cast<std::size_t>(k)], squared); });
    };
    search_->within(
        at(site), (reach + usual_reach_) * kRounding, own.found,
        [&](Index other, double) { add(other, metric.squared_distance(at(site), at(other))); });
    if (far_group_) add_from(far_, *far_group_);
    add_from(moved_, moved);
  };
  const std::size_t most_near = kMostNear * reach_.size();
  const Buffer<Pair> fresh =
      collect<Pair>(arena, left.size(), kSitesPerSearch,
                    [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int w) {
                      if (near > most_near) return;
                      scratch[w].near = 0;
                      for (std::size_t k = begin; k < end; ++k) search(left[k], out, scratch[w]);
                      near += scratch[w].near;
                    });
  // Whether that is so does not depend on who looked where: every task looks at as many.
  if (near > most_near) return false;
  added_.insert(added_.end(), fresh.begin(), fresh.end());
  std::sort(added_.begin(), added_.end());
  added_.erase(std::unique(added_.begin(), added_.end()), added_.end());
  return true;
}

}  // namespace ccvt
