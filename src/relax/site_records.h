#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "parallel/bytes.h"
#include "relax/site_state.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Tells all ranks what has become of each rank's own sites that have changed, and which these are.
inline void share_records(const Tiling& tiling, SiteState& sites,
                          std::vector<std::uint8_t>& changed) {
  Ranks* const ranks = tiling.ranks();
  if (ranks == nullptr) return;
  struct Records {
    std::vector<SiteNumber> site;
    std::vector<double> values;  ///< position, radius and energy of each
    std::vector<std::uint8_t> compact;
  };
  const std::size_t dimension = sites.dimension;
  Records own;
  for (const SiteNumber s : tiling.own_sites()) {
    if (changed[s] == 0) continue;
    own.site.push_back(s);
    own.values.insert(own.values.end(), sites.at(s), sites.at(s) + dimension);
    own.values.insert(own.values.end(), {sites.radius[s], sites.energy[s]});
    own.compact.push_back(sites.compact[s]);
  }
  ByteWriter message;
  message.put(own.site);
  message.put(own.values);
  message.put(own.compact);
  changed.assign(changed.size(), 0);
  for (const Ranks::Bytes& bytes : ranks->gather(message.bytes)) {
    ByteReader come(bytes);
    const auto site = come.get_all<SiteNumber>();
    const auto values = come.get_all<double>(site.size() * (dimension + 2));
    const auto compact = come.get_all<std::uint8_t>(site.size());
    const double* value = values.data();
    for (std::size_t k = 0; k < site.size(); ++k, value += dimension + 2) {
      std::copy_n(value, dimension, sites.at(site[k]));
      sites.radius[site[k]] = value[dimension];
      sites.energy[site[k]] = value[dimension + 1];
      sites.compact[site[k]] = compact[k];
      changed[site[k]] = 1;
    }
  }
}

}  // namespace ccvt
