#pragma once

#include <span>

#include "parallel/buffer.h"
#include "schedule/pair.h"
#include "schedule/tiling.h"

/// Lists of pairs where several ranks have the tiles: each lists those in which there is a site of
/// its own. No rank has all of them. Of one process, which has all sites, they are all.
namespace ccvt {

[[nodiscard]] inline bool has_own_site(const Tiling& tiling, const Pair& pair) {
  const NumberRange<SiteNumber> own = tiling.own_sites();
  const auto is_own = [&](SiteNumber s) { return *own.begin() <= s && s < *own.end(); };
  return is_own(pair.first) || is_own(pair.second);
}

/// Each rank has found pairs in which there is a site of its own, which the rank of the other site
/// may not have found: now both have them, in no order, twice where both had found them. All ranks.
Buffer<Pair> with_pairs_of_others(const Tiling& tiling, Buffer<Pair> found);

/// The lists of all ranks, each in order, put together: in order, each pair once. All ranks; where
/// one has no memory for them, all throw std::bad_alloc.
Buffer<Pair> pairs_of_all(const Tiling& tiling, std::span<const Pair> own);

}  // namespace ccvt
