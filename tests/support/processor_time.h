#pragma once

#include <ctime>

namespace ccvt::test {

/// Seconds that this process has computed for, all threads together: other than on the clock, it
/// takes no longer beside other programs.
inline double processor_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

}  // namespace ccvt::test
