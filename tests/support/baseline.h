#pragma once

#include <cstdlib>
#include <string_view>

namespace ccvt::test {

/// Whether kernels are to be those of the instruction set that the tests are compiled for, as on a
/// processor that has no better one: CCVT_TEST_KERNELS=baseline in the environment.
inline bool asks_for_baseline() {
  const char* const kernels = std::getenv("CCVT_TEST_KERNELS");
  return kernels != nullptr && std::string_view(kernels) == "baseline";
}

}  // namespace ccvt::test
