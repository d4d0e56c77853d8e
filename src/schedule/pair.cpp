#include "schedule/pair.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace ccvt {
namespace {

constexpr std::size_t kNodesPerGrain = 256;

}  // namespace

Groups<Pair> pairs_by_first(const Arena& arena, Buffer<Pair> pairs, std::size_t nodes) {
  auto by_first = group_by_key(arena, std::move(pairs), nodes, [](const Pair& pair) {
    return static_cast<std::size_t>(pair.first);
  });
  arena.for_each(nodes, kNodesPerGrain, [&](std::size_t s) {
    const auto own = by_first[s];
    std::sort(own.begin(), own.end());
  });
  return by_first;
}

Buffer<Pair> sorted_pairs(const Arena& arena, Buffer<Pair> pairs, std::size_t nodes) {
  const auto by_first = pairs_by_first(arena, std::move(pairs), nodes);
  return collect<Pair>(arena, nodes, kNodesPerGrain,
                       [&](std::size_t begin, std::size_t end, std::vector<Pair>& out, int) {
                         const auto& first = by_first.first;
                         const auto here =
                             by_first.items.span().subspan(first[begin], first[end] - first[begin]);
                         std::unique_copy(here.begin(), here.end(), std::back_inserter(out));
                       });
}

}  // namespace ccvt
