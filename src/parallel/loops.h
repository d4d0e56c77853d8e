#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/ranks.h"
#include "parallel/arena.h"
#include "parallel/buffer.h"
#include "parallel/together.h"

/// What phases do in parallel. All results are those of a serial loop, or are put together in an
/// order that depends on the number of items alone.
namespace ccvt {

/// A value for each worker of an arena, for scratch memory and counts. A loop inside another's body
/// has the worker of that one: it must not use the same values.
template <class T>
class PerWorker {
 public:
  PerWorker() = default;
  explicit PerWorker(const Arena& arena) : values_(static_cast<std::size_t>(arena.threads())) {}
  /// A copy of `value` for each.
  PerWorker(const Arena& arena, const T& value)
      : values_(static_cast<std::size_t>(arena.threads()), Own{value}) {}
  [[nodiscard]] T& operator[](int worker) {
    return values_[static_cast<std::size_t>(worker)].value;
  }
  [[nodiscard]] std::size_t size() const { return values_.size(); }

 private:
  struct alignas(128) Own {  // on cache lines of its own
    T value{};
  };
  std::vector<Own> values_;
};

/// Combines map(begin, end) of consecutive blocks of `grain` items: pairs of neighbours first, then
/// pairs of these, so that rounding grows as the logarithm of the blocks. `identity` for no items.
template <class T, class Map, class Combine>
T reduce(const Arena& arena, std::size_t count, std::size_t grain, T identity, const Map& map,
         const Combine& combine) {
  if (count == 0) return identity;
  std::vector<T> part((count + grain - 1) / grain, identity);
  arena.for_ranges(count, grain, [&](std::size_t begin, std::size_t end, int) {
    part[begin / grain] = map(begin, end);
  });
  for (std::size_t width = 1; width < part.size(); width *= 2) {
    for (std::size_t k = 0; k + width < part.size(); k += 2 * width) {
      part[k] = combine(part[k], part[k + width]);
    }
  }
  return part[0];
}

/// The sum of term(k), in this order.
template <class Term>
double sum_of(const Arena& arena, std::size_t count, std::size_t grain, const Term& term) {
  return reduce(
      arena, count, grain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t k = begin; k < end; ++k) sum += term(k);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

/// Each value becomes the sum of those before it; returns the sum of all.
template <class T>
T exclusive_scan(const Arena& arena, std::span<T> values) {
  constexpr std::size_t kBlock = std::size_t{1} << 15;
  std::vector<T> before((values.size() + kBlock - 1) / kBlock, T{});
  arena.for_ranges(values.size(), kBlock, [&](std::size_t begin, std::size_t end, int) {
    T sum{};
    for (std::size_t k = begin; k < end; ++k) sum += values[k];
    before[begin / kBlock] = sum;
  });
  T all{};
  for (T& sum : before) all += std::exchange(sum, all);
  arena.for_ranges(values.size(), kBlock, [&](std::size_t begin, std::size_t end, int) {
    T sum = before[begin / kBlock];
    for (std::size_t k = begin; k < end; ++k) sum += std::exchange(values[k], sum);
  });
  return all;
}

/// Copies of lists, in pieces of memory that stay where they are: a vector of all would be copied
/// each time it grows, into memory that has not been touched.
template <class T>
class Kept {
 public:
  std::span<const T> keep(std::span<const T> list) {
    if (list.size() > room_.size()) {
      const bool own_piece = list.size() > next_ / 4;
      const std::span<T> piece = pieces_.emplace_back(own_piece ? list.size() : next_).span();
      next_ = std::min(next_ < kLarge ? 8 * next_ : 2 * next_, 16 * kLarge);
      if (own_piece) return copied(list, piece);
      room_ = piece;
    }
    const std::span<const T> copy = copied(list, room_);
    room_ = room_.subspan(list.size());
    return copy;
  }

 private:
  static constexpr std::size_t kLarge = (std::size_t{1} << 21) / sizeof(T) + 1;
  static std::span<const T> copied(std::span<const T> list, std::span<T> to) {
    std::copy(list.begin(), list.end(), to.begin());
    return to.first(list.size());
  }

  std::vector<Buffer<T>> pieces_;
  std::span<T> room_;  ///< in one of them
  std::size_t next_ = kLarge / 512 + 1;
};

/// What body(begin, end, out, worker) appends to the vector `out`, for blocks of `grain` items, one
/// block after the other.
template <class T, class Body>
Buffer<T> collect(const Arena& arena, std::size_t count, std::size_t grain, const Body& body) {
  struct Found {
    std::vector<T> block;
    Kept<T> kept;
  };
  PerWorker<Found> found(arena);
  std::vector<std::span<const T>> parts((count + grain - 1) / grain);
  arena.for_ranges(count, grain, [&](std::size_t begin, std::size_t end, int worker) {
    auto& [block, kept] = found[worker];
    block.clear();
    body(begin, end, block, worker);
    parts[begin / grain] = parts.size() == 1 ? std::span<const T>(block) : kept.keep(block);
  });
  std::vector<std::size_t> place;
  std::size_t total = 0;
  for (const std::span<const T> part : parts) {
    place.push_back(total);
    total += part.size();
  }
  Buffer<T> all(total);
  const std::size_t parts_each = 1 + parts.size() * (std::size_t{1} << 14) / (total + 1);
  arena.for_each(parts.size(), parts_each, [&](std::size_t k) {
    std::copy(parts[k].begin(), parts[k].end(), all.data() + place[k]);
  });
  return all;
}

/// Of `count` things in blocks of `grain`, those of a rank; without ranks, all.
struct RankRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  RankRange(const Ranks* ranks, std::size_t count, std::size_t grain)
      : RankRange(ranks, count, grain, ranks == nullptr ? 0 : ranks->rank()) {}
  RankRange(const Ranks* ranks, std::size_t count, std::size_t grain, int rank) : end(count) {
    if (ranks == nullptr) return;
    const std::size_t blocks = (count + grain - 1) / grain;
    const auto all = static_cast<std::size_t>(ranks->count());
    const auto own = static_cast<std::size_t>(rank);
    begin = std::min(count, blocks * own / all * grain);
    end = std::min(count, blocks * (own + 1) / all * grain);
  }
};

/// What each rank has found, one rank's after the other's: on all of them.
template <class T>
Buffer<T> found_together(Ranks* ranks, Buffer<T> found) {
  if (ranks == nullptr) return found;
  std::vector<std::size_t> counts = of_all(ranks, found.size());
  Buffer<T> together(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  put_together<T>(*ranks, found.span(), std::move(counts), together.span());
  return together;
}

/// The same as collect(), divided among ranks; what body() appends must be all that it does.
template <class T, class Body>
Buffer<T> collect_together(const Arena& arena, std::size_t count, std::size_t grain,
                           const Body& body) {
  const RankRange own(arena.ranks(), count, grain);
  return found_together(
      arena.ranks(),
      collect<T>(arena, own.end - own.begin, grain,
                 [&](std::size_t begin, std::size_t end, std::vector<T>& out, int worker) {
                   body(own.begin + begin, own.begin + end, out, worker);
                 }));
}

/// Of values in blocks of `grain`, each rank has set those of its RankRange: now all have all.
template <class T>
void share_ranges(const Arena& arena, std::span<T> values, std::size_t grain) {
  Ranks* const ranks = arena.ranks();
  if (ranks == nullptr) return;
  std::vector<std::size_t> sizes;
  for (int r = 0; r < ranks->count(); ++r) {
    const RankRange range(ranks, values.size(), grain, r);
    sizes.push_back((range.end - range.begin) * sizeof(T));
  }
  ranks->share(std::as_writable_bytes(values), sizes);
}

/// Calls body(begin, end), which sets the values of a range, for ranges of `grain` of them; ranks
/// divide the ranges, unless there are too few for that, and tell each other.
template <class T, class Body>
void set_together(const Arena& arena, std::span<T> values, std::size_t grain, const Body& body) {
  constexpr std::size_t kWorthMessages = 1 << 12;
  const auto set = [&](std::size_t first, std::size_t count) {
    arena.for_ranges(count, grain, [&](std::size_t begin, std::size_t end, int) {
      body(first + begin, first + end);
    });
  };
  if (arena.ranks() == nullptr || values.size() < kWorthMessages) return set(0, values.size());
  const RankRange own(arena.ranks(), values.size(), grain);
  set(own.begin, own.end - own.begin);
  share_ranges(arena, values, grain);
}

/// The same for values[k] = value(k).
template <class T, class Value>
void fill_together(const Arena& arena, std::span<T> values, std::size_t grain, const Value& value) {
  set_together(arena, values, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) values[k] = value(k);
  });
}

/// Has the workers touch memory that is not written to in order, a part each: whoever comes first
/// would wait for the system to clear nearly all of it.
template <class T>
void touch(const Arena& arena, Buffer<T>& buffer) {
  constexpr std::size_t kPage = 4096 / sizeof(T) + 1;
  arena.for_each(buffer.size() / kPage, 64, [&](std::size_t k) { buffer[k * kPage] = T{}; });
}

/// Items in groups: those of group g are items[first[g]] to items[first[g + 1] - 1].
template <class Item>
struct Groups {
  Buffer<Item> items;
  Buffer<std::size_t> first;

  [[nodiscard]] std::size_t count() const { return first.size() - 1; }
  [[nodiscard]] std::span<const Item> operator[](std::size_t group) const {
    return items.span().subspan(first[group], first[group + 1] - first[group]);
  }
  [[nodiscard]] std::span<Item> operator[](std::size_t group) {
    return items.span().subspan(first[group], first[group + 1] - first[group]);
  }
};

/// Groups items by their key < keys, in their order inside a group: the stable counting sort, in
/// two passes where there are many keys. Calls prepare(k, items[k]) for each once before its key.
/// O(items + keys), and the memory of another copy of the items: `spare`, which is swapped with
/// theirs as need be, when loops do the same many times.
///
/// Items go into buckets of consecutive keys first, so many that the ends of all are in the cache,
/// and then into groups.
template <class Item, class Prepare, class Key>
Groups<Item> group_by_key(const Arena& arena, Buffer<Item> items, std::size_t keys,
                          const Prepare& prepare, const Key& key, Buffer<Item>& spare) {
  constexpr std::size_t kMostBuckets = 1024;
  const std::size_t count = items.size();
  // Enough slices for many workers, each with more items than there are buckets.
  const std::size_t slice = std::clamp(count / 128, std::size_t{1} << 12, std::size_t{1} << 15);
  int shift = 0;
  while ((keys - 1) >> shift >= kMostBuckets) ++shift;
  const std::size_t buckets = ((keys - 1) >> shift) + 1;
  const std::size_t slices = (count + slice - 1) / slice;

  // Of the items of a slice in a bucket, the first place: by bucket, and in it by slice.
  std::vector<std::size_t> place(buckets * slices + 1, 0);
  arena.for_ranges(count, slice, [&](std::size_t begin, std::size_t end, int) {
    std::vector<std::size_t> held(buckets, 0);
    for (std::size_t k = begin; k < end; ++k) {
      prepare(k, items[k]);
      ++held[key(items[k]) >> shift];
    }
    for (std::size_t b = 0; b < buckets; ++b) place[b * slices + begin / slice] = held[b];
  });
  exclusive_scan(arena, std::span(place));
  const auto begin_of = [&](std::size_t b) { return place[b * slices]; };

  if (spare.reset(count)) touch(arena, spare);
  arena.for_ranges(count, slice, [&](std::size_t begin, std::size_t end, int) {
    std::vector<std::size_t> next(buckets);
    for (std::size_t b = 0; b < buckets; ++b) next[b] = place[b * slices + begin / slice];
    for (std::size_t k = begin; k < end; ++k) spare[next[key(items[k]) >> shift]++] = items[k];
  });

  Groups<Item> groups{{}, Buffer<std::size_t>(keys + 1)};
  groups.first[keys] = count;
  if (shift == 0) {
    groups.items = std::exchange(spare, std::move(items));
    for (std::size_t b = 0; b < buckets; ++b) groups.first[b] = begin_of(b);
    return groups;
  }
  groups.items = std::move(items);
  const std::size_t grain = 1 + buckets * (std::size_t{1} << 12) / (count + keys);
  arena.for_each(buckets, grain, [&](std::size_t b) {
    const std::size_t first_key = b << shift;
    const std::size_t own = std::min(std::size_t{1} << shift, keys - first_key);
    const auto here = spare.span().subspan(begin_of(b), begin_of(b + 1) - begin_of(b));
    std::size_t* const next = groups.first.data() + first_key;
    std::fill_n(next, own, std::size_t{0});
    for (const Item& i : here) ++next[key(i) - first_key];
    std::size_t sum = begin_of(b);
    for (std::size_t k = 0; k < own; ++k) sum += std::exchange(next[k], sum);
    for (const Item& i : here) groups.items[next[key(i) - first_key]++] = i;
    // Each is now where the next one begins.
    for (std::size_t k = own; k-- > 1;) next[k] = next[k - 1];
    next[0] = begin_of(b);
  });
  return groups;
}

/// The same of items as they are, and of count items item(k).
template <class Item, class Key>
Groups<Item> group_by_key(const Arena& arena, Buffer<Item> items, std::size_t keys,
                          const Key& key) {
  Buffer<Item> spare;
  return group_by_key(
      arena, std::move(items), keys, [](std::size_t, const Item&) {}, key, spare);
}
template <class Item, class MakeItem, class Key>
Groups<Item> group_by_key(const Arena& arena, std::size_t count, std::size_t keys,
                          const MakeItem& item, const Key& key) {
  Buffer<Item> spare;
  return group_by_key(
      arena, Buffer<Item>(count), keys, [&](std::size_t k, Item& made) { made = item(k); }, key,
      spare);
}

}  // namespace ccvt
