#pragma once

#include <array>
#include <functional>
#include <nlohmann/json.hpp>

namespace ccvt::bench {

using Json = nlohmann::ordered_json;

/// Runs `work` in a process of its own, a copy of this one, and returns what it returns, with the
/// peak memory of that process as "peak_memory_bytes". Memory that this process holds counts, so
/// keep no more than the points. This process must have no threads. Throws std::runtime_error when
/// `work` throws, with its message, or when the process dies.
Json run_in_child(const std::function<Json()>& work);

/// The same in two processes at the same time.
std::array<Json, 2> run_side_by_side(const std::function<Json()>& work);

}  // namespace ccvt::bench
