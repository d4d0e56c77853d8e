#pragma once

#include <chrono>
#include <thread>

namespace ccvt::test {

/// Waits until `done` or a minute has passed.
template <class Condition>
bool wait_for(Condition&& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace ccvt::test
