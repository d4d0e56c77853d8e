#pragma once

#include <string>

#include "ccvt/volume.h"

namespace ccvt {

/// Throws InvalidInput unless a mask, where there is one, has an entry for each cell.
inline void require_entries(const VolumeHeader& volume, MaskView mask) {
  if (mask.empty() || mask.size() == volume.cells()) return;
  throw InvalidInput("mask: has " + std::to_string(mask.size()) + " entries for " +
                     std::to_string(volume.cells()) + " cells; needs one for each");
}

}  // namespace ccvt
