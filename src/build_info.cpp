#include "ccvt/build_info.h"

#include <hwy/highway.h>

#include <string>

#include "ccvt/version.h"
#include "io/hdf5_particles.h"
#include "parallel/arena.h"

namespace ccvt {

namespace {

std::string compiler() {
#if defined(__clang__)
  return "Clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__) + "." +
         std::to_string(__clang_patchlevel__);
#elif defined(__GNUC__)
  return "GCC " + std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__) + "." +
         std::to_string(__GNUC_PATCHLEVEL__);
#else
  return "another compiler";
#endif
}

/// Of the targets that kernels are compiled for, the best one here: better ones have lower bits.
std::string instruction_set() {
  const std::int64_t usable = hwy::SupportedTargets() & std::int64_t{HWY_TARGETS};
  return hwy::TargetName(usable & -usable);
}

}  // namespace

BuildInfo build_info() {
  return {CCVT_VERSION, compiler(), instruction_set(), thread_library(), io::has_hdf5()};
}

}  // namespace ccvt
