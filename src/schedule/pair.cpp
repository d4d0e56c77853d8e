#include "schedule/pair.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "schedule/tiling.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 256;

}  // namespace

Groups<Pair> pairs_by_first(const Arena& arena, Buffer<Pair> pairs, std::size_t sites) {
  auto by_first =
      group_by_key(arena, std::move(pairs), sites, [](const Pair& pair) { return pair.first; });
  for_each_site(arena, sites, kSitesPerGrain, [&](SiteNumber s) {
    const auto own = by_first[s];
    std::sort(own.begin(), own.end());
  });
  return by_first;
}

Buffer<Pair> sorted_pairs(const Arena& arena, Buffer<Pair> pairs, std::size_t sites) {
  const auto by_first = pairs_by_first(arena, std::move(pairs), sites);
  return collect<Pair>(arena, sites, kSitesPerGrain,
                       [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int) {
                         const auto& first = by_first.first;
                         const auto here =
                             by_first.items.span().subspan(first[begin], first[end] - first[begin]);
                         std::unique_copy(here.begin(), here.end(), std::back_inserter(out));
                       });
}

}  // namespace ccvt
