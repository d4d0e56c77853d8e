#include "torn/windows.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "spatial/site_tree.h"

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
  Neighbours(const Metric& metric, const SiteState& sites)
      : sites_(sites), tree_(metric, sites.position), of_(sites.count()) {}

  [[nodiscard]] const std::vector<Index>& operator()(SiteNumber site) {
    std::vector<Index>& near = of_[site];
    if (near.empty()) tree_.nearest(sites_.at(site), 1 + kNeighbours, near);
    return near;
  }

 private:
  const SiteState& sites_;
  SiteTree tree_;
  std::vector<std::vector<Index>> of_;
};

/// Which sites have been linked with each other.
class Groups {
 public:
  explicit Groups(std::size_t sites) : next_(sites) {
    for (const SiteNumber s : sites_below(sites)) next_[s] = s;
  }
  /// Whether they had not been.
  bool join(SiteNumber a, SiteNumber b) {
    a = head(a);
    b = head(b);
    next_[a] = b;
    return a != b;
  }

 private:
  SiteNumber head(SiteNumber site) {
    while (next_[site] != site) site = next_[site] = next_[next_[site]];
    return site;
  }

  std::vector<SiteNumber> next_;
};

/// A window that is being put together.
class Growth {
 public:
  Growth(std::size_t sites, std::size_t most) : most_(most), inside_(sites, 0) {}

  /// Unless it is full.
  void add(SiteNumber site) {
    if (inside_[site] != 0 || full()) return;
    inside_[site] = 1;
    window_.push_back(site);
  }
  [[nodiscard]] std::size_t size() const { return window_.size(); }
  [[nodiscard]] bool full() const { return size() >= most_; }
  [[nodiscard]] bool has(SiteNumber site) const { return inside_[site] != 0; }

  /// Adds chains of neighbours between the sites from the `first` on, shorter ones first, until all
  /// of them are linked that can be.
  void link(Neighbours& neighbours, std::size_t first) {
    const std::size_t sites = inside_.size();
    std::vector<SiteNumber> origin(sites, SiteNumber::none());  // of the chain that a site is on
    std::vector<SiteNumber> before(sites, SiteNumber::none());
    std::vector<SiteNumber> reached(window_.begin() + static_cast<std::ptrdiff_t>(first),
                                    window_.end());
    for (const SiteNumber s : reached) origin[s] = s;
    Groups groups(sites);
    const auto add_chain = [&](SiteNumber s) {
      for (; s != SiteNumber::none(); s = before[s]) add(s);
    };
    for (std::size_t k = 0; k < std::min(reached.size(), kReach * most_) && !full(); ++k) {
      const SiteNumber s = reached[k];
      for (const Index near : neighbours(s)) {
        const SiteNumber t(near);
        if (origin[t] == SiteNumber::none()) {
          origin[t] = origin[s];
          before[t] = s;
          reached.push_back(t);
        } else if (groups.join(origin[s], origin[t])) {
          add_chain(s);
          add_chain(t);
        }
      }
    }
  }
  /// Adds neighbours of the sites from the `first` on, and theirs, until there are `enough`.
  void grow(Neighbours& neighbours, std::size_t first, std::size_t enough) {
    for (std::size_t k = first; k < size() && size() < enough; ++k) {
      for (const Index s : neighbours(window_[k])) add(SiteNumber(s));
    }
  }
  /// What it is now; the next one is empty.
  [[nodiscard]] Window take() {
    for (const SiteNumber s : window_) inside_[s] = 0;
    std::sort(window_.begin(), window_.end());
    return std::exchange(window_, {});
  }

 private:
  std::size_t most_;
  std::vector<std::uint8_t> inside_;
  Window window_;
};

}  // namespace

std::vector<Window> windows_around(const Metric& metric, const SiteState& sites,
                                   std::span<const TornSite> torn, std::size_t most) {
  if (torn.empty()) return {};
  Growth growth(sites.count(), most);
  if (sites.count() <= std::min(kFewSites, most)) {
    for (const SiteNumber s : sites.all()) growth.add(s);
    return {growth.take()};
  }
  Neighbours neighbours(metric, sites);
  std::vector<Window> windows;
  std::vector<std::uint8_t> covered(sites.count(), 0);
  for (std::size_t next = 0; next < torn.size();) {
    // Torn sites come first: what is next to one, between its points, says nothing.
    const std::size_t begin = next;
    for (std::size_t wanted = 0; next < torn.size() && wanted < most / kShareOfLinks; ++next) {
      if (covered[torn[next].site] != 0) continue;
      growth.add(torn[next].site);
      wanted += 1 + torn[next].nearest.size();
    }
    const std::size_t first = growth.size();
    if (first == 0) continue;
    for (std::size_t k = begin; k < next; ++k) {
      if (!growth.has(torn[k].site)) continue;
      for (const SiteNumber s : torn[k].nearest) growth.add(s);
    }
    growth.link(neighbours, first);
    growth.grow(neighbours, first, std::max(kLeastSites, kAroundLinks * growth.size()));
    windows.push_back(growth.take());
    for (const SiteNumber s : windows.back()) covered[s] = 1;
  }
  return windows;
}

}  // namespace ccvt
