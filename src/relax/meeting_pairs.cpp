#include "relax/meeting_pairs.h"

#include <algorithm>

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

/// Pairs are searched from the site with the larger reach, so that one far-reaching site does not
/// make every search wide.
bool searches(const std::vector<double>& reach, Index site, Index other) {
  const double own = reach[static_cast<std::size_t>(site)];
  const double others = reach[static_cast<std::size_t>(other)];
  return own != others ? own > others : site < other;
}

}  // namespace

std::vector<Index> MeetingPairs::outgrown(const Metric& metric, const SiteState& sites) const {
  std::vector<Index> left;
  for (Index s = 0; s < sites.count(); ++s) {
    const auto k = static_cast<std::size_t>(s);
    const double room = reach_[k] - sites.radius[k];
    const bool inside =
        room >= 0 && metric.squared_distance(sites.at(s), at(s)) * kRounding <= room * room;
    if (!inside) left.push_back(s);
  }
  return left;
}

void MeetingPairs::enter(const SiteState& sites, Index site) {
  std::copy_n(sites.at(site), dimension_,
              position_.begin() + static_cast<std::ptrdiff_t>(site) * dimension_);
  reach_[static_cast<std::size_t>(site)] =
      sites.radius[static_cast<std::size_t>(site)] * (1 + kSkin);
}

/// Some of the sites, to be searched where they have been entered.
MeetingPairs::Group MeetingPairs::group(const Metric& metric,
                                        const std::vector<Index>& sites) const {
  std::vector<double> positions;
  double largest_reach = 0;
  for (const Index s : sites) {
    positions.insert(positions.end(), at(s), at(s) + dimension_);
    largest_reach = std::max(largest_reach, reach_[static_cast<std::size_t>(s)]);
  }
  return {SiteSearch(metric, positions), largest_reach};
}

/// Of two spheres as far apart as this where they have been entered.
bool MeetingPairs::may_meet(Index a, Index b, double squared) const {
  const double both = reach_[static_cast<std::size_t>(a)] + reach_[static_cast<std::size_t>(b)];
  return squared <= both * both * kRounding;
}

MeetingPairs::Refreshed MeetingPairs::refresh(const Metric& metric, const SiteState& sites,
                                              const Arena& arena, std::size_t limit) {
  if (search_) {
    const std::vector<Index> left = outgrown(metric, sites);
    if (left.empty()) return Refreshed::unchanged;
    const auto moved = static_cast<Index>(moved_.size() + left.size());
    if (moved <= sites.count() / kMovedShare && extend(metric, sites, left)) {
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
  for (Index s = 0; s < sites.count(); ++s) enter(sites, s);
  pairs_.clear();
  added_.clear();
  moved_.clear();
  search_.emplace(metric, sites.position);

  std::vector<double> sorted = reach_;
  const auto rank = static_cast<std::ptrdiff_t>(count - 1 - count / kFarShare);
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  usual_reach_ = sorted[static_cast<std::size_t>(rank)];
  far_.clear();
  for (Index s = 0; s < sites.count(); ++s) {
    if (reach_[static_cast<std::size_t>(s)] > usual_reach_) far_.push_back(s);
  }
  far_group_.reset();
  if (!far_.empty()) far_group_.emplace(group(metric, far_));

  constexpr std::size_t kChunk = 256;
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::vector<Pair>> found(chunks);
  // In groups of chunks, so that a list beyond its limit is noticed early.
  constexpr std::size_t kGroup = 16;
  std::size_t total = 0;
  for (std::size_t group = 0; group < chunks; group += kGroup) {
    const std::size_t group_end = std::min(group + kGroup, chunks);
    arena.for_each(group_end - group, 1, [&](std::size_t c) {
      std::vector<Index> scratch;
      const std::size_t begin = (group + c) * kChunk;
      for (std::size_t s = begin; s < std::min(begin + kChunk, count); ++s) {
        const auto site = static_cast<Index>(s);
        const auto add = [&](Index other, double squared) {
          if (searches(reach_, site, other) && may_meet(site, other, squared)) {
            found[group + c].emplace_back(std::min(site, other), std::max(site, other));
          }
        };
        search_->within(at(site), 2 * reach_[s] * kRounding, scratch, add);
      }
    });
    for (std::size_t c = group; c < group_end; ++c) total += found[c].size();
    if (total > limit) {
      search_.reset();
      return false;
    }
  }
  pairs_.reserve(total);
  for (const auto& part : found) pairs_.insert(pairs_.end(), part.begin(), part.end());
  sort_pairs(pairs_, sites.count());
  return true;
}

/// Enters the spheres that have left theirs, and adds the pairs that may now meet. False when that
/// takes longer than to make the list again: small spheres among many, sought as far as most reach.
bool MeetingPairs::extend(const Metric& metric, const SiteState& sites,
                          const std::vector<Index>& left) {
  for (const Index site : left) {
    enter(sites, site);
    moved_.push_back(site);
  }
  std::sort(moved_.begin(), moved_.end());
  moved_.erase(std::unique(moved_.begin(), moved_.end()), moved_.end());

  const Group moved = group(metric, moved_);
  std::vector<Index> scratch;
  std::vector<Pair> fresh;
  std::size_t near = 0;
  for (const Index site : left) {
    if (near > kMostNear * reach_.size()) return false;
    const double reach = reach_[static_cast<std::size_t>(site)];
    const auto add = [&](Index other, double squared) {
      ++near;
      if (other == site || !may_meet(site, other, squared)) return;
      const Pair pair(std::min(site, other), std::max(site, other));
      if (!std::binary_search(pairs_.begin(), pairs_.end(), pair)) fresh.push_back(pair);
    };
    const auto add_from = [&](const std::vector<Index>& members, const Group& group) {
      group.search.within(
          at(site), (reach + group.largest_reach) * kRounding, scratch,
          [&](Index k, double squared) { add(members[static_cast<std::size_t>(k)], squared); });
    };
    search_->within(
        at(site), (reach + usual_reach_) * kRounding, scratch,
        [&](Index other, double) { add(other, metric.squared_distance(at(site), at(other))); });
    if (far_group_) add_from(far_, *far_group_);
    add_from(moved_, moved);
  }
  added_.insert(added_.end(), fresh.begin(), fresh.end());
  std::sort(added_.begin(), added_.end());
  added_.erase(std::unique(added_.begin(), added_.end()), added_.end());
  return true;
}

}  // namespace ccvt
