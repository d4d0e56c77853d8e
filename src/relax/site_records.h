#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "parallel/together.h"
#include "relax/site_state.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Tells all ranks what has become of each rank's own sites that have changed, and which these are.
inline void share_records(const Tiling& tiling, SiteState& sites,
                          std::vector<std::uint8_t>& changed) {
  Ranks* const ranks = tiling.ranks();
  if (ranks == nullptr) return;
  const std::size_t dimension = sites.dimension;
  // Of each site its number and whether it is compact, position, radius and energy.
  const std::size_t width = dimension + 3;
  const NumberRange<SiteNumber> own = tiling.own_sites();
  std::size_t count = 0;
  for (const SiteNumber s : own) count += changed[s];
  std::vector<double> records(count * width);
  double* record = records.data();
  for (const SiteNumber s : own) {
    if (changed[s] == 0) continue;
    *record++ = 2.0 * s.index() + sites.compact[s];
    record = std::copy_n(sites.at(s), dimension, record);
    *record++ = sites.radius[s];
    *record++ = sites.energy[s];
  }
  records = joined(ranks, std::move(records));
  changed.assign(changed.size(), 0);
  for (const double* r = records.data(); r != records.data() + records.size(); r += width) {
    const auto head = static_cast<std::int64_t>(*r);
    const SiteNumber site(head / 2);
    changed[site] = 1;
    sites.compact[site] = static_cast<std::uint8_t>(head % 2);
    std::copy_n(r + 1, dimension, sites.at(site));
    sites.radius[site] = r[dimension + 1];
    sites.energy[site] = r[dimension + 2];
  }
}

}  // namespace ccvt
