#pragma once

#include <string>

#include "ccvt/export.h"

namespace ccvt {

/// What the library is made of, in words for people.
struct BuildInfo {
  std::string version;          ///< "0.1.0"
  std::string compiler;         ///< "GCC 12.2.0"
  std::string instruction_set;  ///< what the kernels use on this processor: "AVX2"; results are the
                                ///< same with any
  std::string threads;          ///< "oneTBB 2021.8" or "std::thread"
  bool hdf5 = false;            ///< whether .hdf5 is read and written
};

/// Of the library that the program runs with.
[[nodiscard]] CCVT_EXPORT BuildInfo build_info();

}  // namespace ccvt
