#include "schedule/own_pairs.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "parallel/together.h"

namespace ccvt {

Buffer<Pair> with_pairs_of_others(const Tiling& tiling, Buffer<Pair> found) {
  Ranks* const ranks = tiling.ranks();
  if (ranks == nullptr) return found;
  std::vector<ByteWriter> to(static_cast<std::size_t>(ranks->count()));
  for (const Pair& pair : found) {
    for (const SiteNumber site : {pair.first, pair.second}) {
      const Tile tile = tiling.tile_of(site);
      if (!tiling.is_own(tile)) to[static_cast<std::size_t>(tiling.rank_of(tile))].put(pair);
    }
  }
  const std::vector<Ranks::Bytes> come = exchanged(*ranks, std::move(to));
  std::size_t count = found.size();
  for (const Ranks::Bytes& bytes : come) count += bytes.size() / sizeof(Pair);
  Buffer<Pair> both(count);
  std::size_t next = found.size();
  std::copy(found.begin(), found.end(), both.begin());
  for (const Ranks::Bytes& bytes : come) {
    for (ByteReader message(bytes); !message.done();) both[next++] = message.get<Pair>();
  }
  return both;
}

/// Each rank gives those whose first site is its own: its sites follow those of the rank before.
Buffer<Pair> pairs_of_all(const Tiling& tiling, std::span<const Pair> own) {
  const NumberRange<SiteNumber> sites = tiling.own_sites();
  const auto from = [&](SiteNumber site) {
    return std::partition_point(own.begin(), own.end(),
                                [site](const Pair& pair) { return pair.first < site; });
  };
  const std::span<const Pair> given(from(*sites.begin()), from(*sites.end()));
  std::vector<std::size_t> counts = of_all(tiling.ranks(), given.size());
  Buffer<Pair> all;
  agree(tiling.ranks(),
        [&] { all.reset(std::accumulate(counts.begin(), counts.end(), std::size_t{0})); });
  if (tiling.ranks() == nullptr) {
    std::copy(given.begin(), given.end(), all.begin());
  } else {
    put_together<Pair>(*tiling.ranks(), given, std::move(counts), all.span());
  }
  return all;
}

}  // namespace ccvt
