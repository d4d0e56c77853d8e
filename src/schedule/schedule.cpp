#include "schedule/schedule.h"

#include <algorithm>
#include <numeric>

namespace ccvt {

Batches greedy_batches(std::span<const Pair> pairs, Index nodes) {
  Batches batches;
  std::vector<std::vector<std::uint8_t>> used;
  std::vector<std::size_t> by_size;  // batch numbers, smallest batch first
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto a = static_cast<std::size_t>(pairs[p].first);
    const auto b = static_cast<std::size_t>(pairs[p].second);
    std::size_t rank = 0;
    while (rank < by_size.size() && (used[by_size[rank]][a] != 0 || used[by_size[rank]][b] != 0)) {
      ++rank;
    }
    if (rank == by_size.size()) {
      by_size.push_back(batches.size());
      batches.emplace_back();
      used.emplace_back(static_cast<std::size_t>(nodes), std::uint8_t{0});
      // The new batch is the smallest; it goes before all others but after none of its size.
      std::rotate(by_size.begin(), by_size.end() - 1, by_size.end());
      rank = 0;
    }
    const std::size_t batch = by_size[rank];
    batches[batch].push_back(static_cast<Index>(p));
    used[batch][a] = used[batch][b] = 1;
    const auto after = [&](std::size_t x, std::size_t y) {
      return batches[x].size() != batches[y].size() ? batches[x].size() > batches[y].size() : x > y;
    };
    for (; rank + 1 < by_size.size() && after(by_size[rank], by_size[rank + 1]); ++rank) {
      std::swap(by_size[rank], by_size[rank + 1]);
    }
  }
  return batches;
}

Schedule schedule_pairs(std::span<const Pair> pairs, Index sites, Index tile_sites) {
  const auto tile_of = [=](Index site) { return site / tile_sites; };
  struct Placed {
    Pair tiles;
    Index pair;
  };
  std::vector<Placed> placed(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Index a = tile_of(pairs[p].first);
    const Index b = tile_of(pairs[p].second);
    placed[p] = {{std::min(a, b), std::max(a, b)}, static_cast<Index>(p)};
  }
  if (tile_sites > 1) {
    std::sort(placed.begin(), placed.end(), [](const Placed& x, const Placed& y) {
      return x.tiles != y.tiles ? x.tiles < y.tiles : x.pair < y.pair;
    });
  }

  // One entry for each run of pairs between the same two tiles.
  std::vector<Pair> tile_pairs;
  std::vector<std::size_t> run_begin;
  for (std::size_t k = 0; k < placed.size(); ++k) {
    if (tile_pairs.empty() || placed[k].tiles != tile_pairs.back() || tile_sites == 1) {
      tile_pairs.push_back(placed[k].tiles);
      run_begin.push_back(k);
    }
  }
  run_begin.push_back(placed.size());

  Schedule schedule;
  schedule.pairs.reserve(pairs.size());
  for (const auto& batch : greedy_batches(tile_pairs, tile_of(sites - 1) + 1)) {
    for (const Index run : batch) {
      const auto r = static_cast<std::size_t>(run);
      const auto begin = static_cast<std::int64_t>(schedule.pairs.size());
      for (std::size_t k = run_begin[r]; k < run_begin[r + 1]; ++k) {
        schedule.pairs.push_back(pairs[static_cast<std::size_t>(placed[k].pair)]);
      }
      schedule.tasks.push_back({begin, static_cast<std::int64_t>(schedule.pairs.size())});
    }
    schedule.batch_begin.push_back(static_cast<std::int64_t>(schedule.tasks.size()));
  }
  return schedule;
}

}  // namespace ccvt
