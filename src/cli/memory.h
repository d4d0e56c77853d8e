#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace ccvt::cli {

/// Throws InvalidInput when `points` points are too many to be numbered, or when tessellating them
/// would need more memory than the machine has: four times their coordinates and 100 MB. Either
/// message starts with `what` and says how much memory it is.
void check_memory(const std::string& what, std::uint64_t points, std::uint64_t dimension,
                  std::size_t scalar_bytes);

/// The most memory that this process has held so far.
[[nodiscard]] std::uint64_t peak_memory_bytes();

}  // namespace ccvt::cli
