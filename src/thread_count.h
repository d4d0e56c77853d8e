#pragma once

#include <string>

#include "ccvt/types.h"

namespace ccvt {

/// Throws InvalidInput unless so many threads may be asked for.
inline void require_threads(int threads) {
  if (threads >= 0 && threads <= 4096) return;
  throw InvalidInput("threads: is " + std::to_string(threads) +
                     "; must be from 0 (one per processor) to 4096");
}

}  // namespace ccvt
