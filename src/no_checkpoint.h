#pragma once

#include <string>

#include "ccvt/options.h"
#include "ccvt/types.h"

namespace ccvt {

/// Throws InvalidInput where a checkpoint is asked of a function that keeps none.
inline void require_no_checkpoint(const Options& options, const char* function) {
  if (options.checkpoint.empty()) return;
  throw InvalidInput("Options::checkpoint is " + options.checkpoint.string() + ": " + function +
                     " keeps none");
}

}  // namespace ccvt
