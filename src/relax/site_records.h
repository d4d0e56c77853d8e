#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "relax/site_state.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Tells all ranks what has become of each rank's own sites that have changed, and which these are.
inline void share_records(const Tiling& tiling, SiteState& sites,
                          std::vector<std::uint8_t>& changed) {
  if (tiling.ranks() == nullptr) return;
  ByteWriter own;
  for (const SiteNumber s : tiling.own_sites()) {
    if (changed[s] == 0) continue;
    own.put(s);
    own.put(std::span(std::as_const(sites).at(s), sites.dimension));
    own.put(sites.radius[s]);
    own.put(sites.energy[s]);
    own.put(sites.compact[s]);
  }
  changed.assign(changed.size(), 0);
  for (const Ranks::Bytes& bytes : tiling.ranks()->gather(own.bytes)) {
    ByteReader records(bytes);
    while (!records.done()) {
      const auto s = records.get<SiteNumber>();
      records.get(std::span(sites.at(s), sites.dimension));
      sites.radius[s] = records.get<double>();
      sites.energy[s] = records.get<double>();
      sites.compact[s] = records.get<std::uint8_t>();
      changed[s] = 1;
    }
  }
}

}  // namespace ccvt
