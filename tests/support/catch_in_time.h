#pragma once

#include <chrono>

namespace ccvt::test {

/// When what ends a run came.
enum class Caught { too_early, too_late, in_time };

/// Tries delays until one is in time, from `delay` on: longer after one that was too early, shorter
/// after one that was too late, by steps that grow finer. The machine's speed may change meanwhile.
template <class Try>
bool catch_in_time(std::chrono::duration<double> delay, const Try& attempt) {
  double factor = 2;
  Caught before = Caught::in_time;
  for (int tries = 0; tries < 60; ++tries) {
    const Caught now = attempt(delay);
    if (now == Caught::in_time) return true;
    if (before != Caught::in_time && now != before) factor = 1 + (factor - 1) / 1.5;
    delay = now == Caught::too_early ? delay * factor : delay / factor;
    before = now;
  }
  return false;
}

}  // namespace ccvt::test
