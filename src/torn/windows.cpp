#include "torn/windows.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "relax/disjoint_sets.h"

namespace ccvt {
namespace {

/// So many sites are one window: parts of them end higher, by 3 hundredths in the mean.
constexpr std::size_t kFewSites = 256;
/// A window that has been linked is grown to so many times the sites, and to as many at least:
/// those beside a chain make room for what moves along it.
constexpr std::size_t kAroundLinks = 3;
constexpr std::size_t kLeastSites = 128;
/// Of its sites, torn ones and those that are nearest to their points are a part that leaves as
/// many for links.
constexpr std::size_t kShareOfLinks = 2;
/// Links are looked for among so many times as many sites as a window may have.
constexpr std::size_t kReach = 32;
/// Neighbours of a site: beyond these, others lie between.
constexpr int kNeighbours = 8;

/// What is next to sites, looked up once.
class Neighbours {
 public:
  Neighbours(const SiteState& sites, const SiteTree& tree) : sites_(sites), tree_(tree) {}

  [[nodiscard]] const std::vector<Index>& operator()(SiteNumber site) {
    std::vector<Index>& near = of_[site];
    if (near.empty()) tree_.nearest(sites_.at(site), 1 + kNeighbours, near);
    return near;
  }

 private:
  const SiteState& sites_;
  const SiteTree& tree_;
  std::unordered_map<std::size_t, std::vector<Index>> of_;
};

/// A window that is being put together.
class Growth {
 public:
  Growth(std::span<const Index> capacities, const WindowLimits& most)
      : capacities_(capacities),
        sites_left_(most.sites),
        points_left_(most.points),
        most_capacity_(most.capacity) {}

  /// Whether it is in the window now: there may be no room.
  bool add(SiteNumber site) {
    if (inside_.contains(site)) return true;
    const Index capacity = capacities_[site];
    if (sites_left_ == 0 || points_left_ < capacity || most_capacity_ < capacity) return false;
    inside_.insert(site);
    --sites_left_;
    points_left_ -= capacity;
    return true;
  }
  /// Adds one that is to be linked with others, or from which the window grows.
  void add_solid(SiteNumber site) {
    if (add(site) && solid_.insert(site).second) order_.push_back(site);
  }
  [[nodiscard]] bool full() const { return sites_left_ == 0; }
  [[nodiscard]] bool has(SiteNumber site) const { return inside_.contains(site); }

  /// Adds chains of neighbours between the solid sites, shorter ones first, until all of them are
  /// linked that can be.
  void link(Neighbours& neighbours, std::size_t most_reached) {
    using End = Number<struct OfEnds>;
    struct Link {
      SiteNumber before;  ///< towards the end where the chain begins; none there
      End end;
    };
    std::vector<SiteNumber> reached = order_;
    std::unordered_map<std::size_t, Link> links;
    for (const End end : numbers_below<End>(reached.size())) {
      links[reached[end]] = {SiteNumber::none(), end};
    }
    DisjointSets<End> linked(reached.size());
    const auto add_chain = [&](SiteNumber site) {
      for (; site != SiteNumber::none(); site = links[site].before) add_solid(site);
    };
    for (std::size_t k = 0; k < std::min(reached.size(), most_reached) && !full(); ++k) {
      const SiteNumber s = reached[k];
      for (const Index near : neighbours(s)) {
        const SiteNumber t(near);
        if (links.try_emplace(t, Link{s, links[s].end}).second) {
          reached.push_back(t);
        } else if (linked.join(links[s].end, links[t].end)) {
          add_chain(s);
          add_chain(t);
        }
      }
    }
  }
  /// Adds neighbours of the solid sites, and theirs, until there are so many.
  void grow(Neighbours& neighbours) {
    const std::size_t enough = std::max(kLeastSites, kAroundLinks * inside_.size());
    for (std::size_t k = 0; k < order_.size() && inside_.size() < enough; ++k) {
      const std::vector<Index>& near = neighbours(order_[k]);
      for (const Index s : near) add_solid(SiteNumber(s));
    }
  }
  [[nodiscard]] Window window() const {
    Window window;
    for (const std::size_t s : inside_) window.emplace_back(s);
    std::sort(window.begin(), window.end());
    return window;
  }

 private:
  std::span<const Index> capacities_;
  std::size_t sites_left_;
  std::int64_t points_left_;
  Index most_capacity_;
  std::unordered_set<std::size_t> inside_;
  std::unordered_set<std::size_t> solid_;
  std::vector<SiteNumber> order_;  ///< of the solid ones
};

}  // namespace

std::vector<Window> windows_around(const SiteState& sites, const SiteTree& tree,
                                   std::span<const Index> capacities,
                                   std::span<const TornSite> torn, const WindowLimits& most) {
  if (torn.empty()) return {};
  const std::int64_t points =
      std::accumulate(capacities.begin(), capacities.end(), std::int64_t{0});
  if (sites.count() <= std::min(kFewSites, most.sites) && points <= most.points) {
    Window all;
    for (const SiteNumber s : sites.all()) all.push_back(s);
    return {all};
  }
  Neighbours neighbours(sites, tree);
  std::vector<Window> windows;
  std::unordered_set<std::size_t> covered;
  double work = 0;
  for (std::size_t next = 0; next < torn.size() && work < most.work;) {
    Growth growth(capacities, most);
    const std::size_t begin = next;
    // What is next to a torn site, between its points, says nothing: it is not a solid one.
    std::size_t wanted = 0;
    for (; next < torn.size() && wanted < most.sites / kShareOfLinks; ++next) {
      if (covered.contains(torn[next].site) || !growth.add(torn[next].site)) continue;
      wanted += 1 + torn[next].nearest.size();
    }
    if (wanted == 0) continue;
    for (const TornSite& t : torn.subspan(begin, next - begin)) {
      if (!growth.has(t.site)) continue;
      for (const SiteNumber s : t.nearest) growth.add_solid(s);
    }
    growth.link(neighbours, kReach * most.sites);
    growth.grow(neighbours);
    windows.push_back(growth.window());
    const auto size = static_cast<double>(windows.back().size());
    work += size * size;
    for (const TornSite& t : torn) {
      const auto inside = [&](SiteNumber s) { return growth.has(s); };
      if (inside(t.site) && std::all_of(t.nearest.begin(), t.nearest.end(), inside)) {
        covered.insert(t.site);
      }
    }
  }
  return windows;
}

}  // namespace ccvt
