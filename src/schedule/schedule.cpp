#include "schedule/schedule.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>

#include "counting_sort.h"

namespace ccvt {

void sort_pairs(std::vector<Pair>& pairs, Index nodes) {
  const auto keys = static_cast<std::size_t>(nodes);
  counting_sort(pairs, keys, [](const Pair& pair) { return pair.second; });
  counting_sort(pairs, keys, [](const Pair& pair) { return pair.first; });
}

Batches greedy_batches(std::span<const Pair> pairs, Index nodes) {
  Batches batches;
  std::vector<std::vector<std::uint8_t>> used;            // [batch][node]
  std::set<std::pair<std::size_t, std::size_t>> by_size;  // (size, batch)
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto a = static_cast<std::size_t>(pairs[p].first);
    const auto b = static_cast<std::size_t>(pairs[p].second);
    auto smallest = std::find_if(by_size.begin(), by_size.end(), [&](const auto& entry) {
      return used[entry.second][a] == 0 && used[entry.second][b] == 0;
    });
    if (smallest == by_size.end()) {
      smallest = by_size.emplace(0, batches.size()).first;
      batches.emplace_back();
      used.emplace_back(static_cast<std::size_t>(nodes), std::uint8_t{0});
    }
    auto entry = by_size.extract(smallest);
    const std::size_t batch = entry.value().second;
    batches[batch].push_back(static_cast<Index>(p));
    used[batch][a] = used[batch][b] = 1;
    entry.value().first = batches[batch].size();
    by_size.insert(std::move(entry));
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
    const auto tiles = static_cast<std::size_t>(tile_of(sites - 1)) + 1;
    counting_sort(placed, tiles, [](const Placed& p) { return p.tiles.second; });
    counting_sort(placed, tiles, [](const Placed& p) { return p.tiles.first; });
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

Schedule schedule_rounds(std::span<const Pair> pairs, Index sites) {
  const auto round_of = [=](const Pair& pair) {
    return static_cast<std::size_t>((std::int64_t{pair.first} + pair.second) % sites);
  };
  std::vector<std::int64_t> begin(static_cast<std::size_t>(sites) + 1, 0);
  for (const Pair& pair : pairs) ++begin[round_of(pair) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());

  Schedule schedule;
  for (std::size_t round = 0; round + 1 < begin.size(); ++round) {
    if (begin[round + 1] > begin[round]) schedule.batch_begin.push_back(begin[round + 1]);
  }
  schedule.pairs.resize(pairs.size());
  for (const Pair& pair : pairs) {
    schedule.pairs[static_cast<std::size_t>(begin[round_of(pair)]++)] = pair;
  }
  schedule.tasks.reserve(pairs.size());
  for (std::int64_t p = 0; p < static_cast<std::int64_t>(pairs.size()); ++p) {
    schedule.tasks.push_back({p, p + 1});
  }
  return schedule;
}

}  // namespace ccvt
