#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ccvt/types.h"

namespace ccvt::cli {

/// How much memory tessellating `points` points takes, such as "1.2 GiB": four times their
/// coordinates, 100 MB, and `other_bytes`. Throws InvalidInput when that is more than the machine
/// has, or there are more points than `processes` of it can number. Either message starts with
/// `what` and says how much memory it is.
std::string check_memory(const std::string& what, std::uint64_t points, int dimension,
                         std::size_t scalar_bytes, std::uint64_t other_bytes = 0,
                         std::uint64_t processes = 1);
/// The same for points that are drawn; the message starts with --sites.
std::string check_memory(Index sites, Index points_per_site, int dimension,
                         std::size_t scalar_bytes, std::uint64_t other_bytes = 0);

/// The same for any need.
std::string check_bytes(const std::string& what, std::uint64_t points, int dimension, double needed,
                        std::uint64_t processes = 1);

/// Throws InvalidInput when the cells of a volume, in so many bytes, are more than the machine has
/// memory for.
void check_cells(const std::filesystem::path& volume, std::uint64_t cells, std::uint64_t bytes);

/// Vectors of a file. Mapped ones take no memory.
struct VectorsHeld {
  std::uint64_t count = 0;
  int dimension = 0;
  std::size_t scalar_bytes = 0;  ///< a coordinate
  bool mapped = false;
};

/// About what train_codebook() holds at most, the vectors among it. `exact`: exact assignments
/// occur.
[[nodiscard]] double training_bytes(const VectorsHeld& vectors, Index codewords, bool exact);
/// About what Codebook::encode() holds at most, the vectors among it.
[[nodiscard]] double encoding_bytes(const VectorsHeld& vectors);

/// The most memory that this process has held so far.
[[nodiscard]] std::uint64_t peak_memory_bytes();

}  // namespace ccvt::cli
