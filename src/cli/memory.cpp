#include "cli/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "cli/values.h"

namespace ccvt::cli {

namespace {

/// "12.3 GiB".
std::string bytes_text(double bytes) {
  const char* const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  std::size_t unit = 0;
  while (bytes >= 1024 && unit < 6) {
    bytes /= 1024;
    ++unit;
  }
  return concat(std::round(bytes * 10) / 10) + " " + units[unit];
}

/// What training holds: bytes a vector beside its coordinates; a pair of codewords, up to so many
/// codewords; see train_codebook().
constexpr double kTrainingVector = 120;
constexpr double kExactPair = 80;
constexpr double kBound = 8;
constexpr double kMostWithBounds = 5792;
/// What encoding holds of a vector beside its coordinates.
constexpr double kEncodingVector = 64;

void require_memory(const std::string& would_need, double needed) {
  const auto pages = static_cast<double>(::sysconf(_SC_PHYS_PAGES));
  const auto page = static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (pages > 0 && page > 0 && needed > pages * page) {
    throw InvalidInput(would_need + ", but this machine has " + bytes_text(pages * page));
  }
}

}  // namespace

std::string check_bytes(const std::string& what, std::uint64_t points, int dimension, double needed,
                        std::uint64_t processes) {
  const std::string would_need = what + ": " + std::to_string(points) + " points in " +
                                 std::to_string(dimension) + " dimensions would need about " +
                                 bytes_text(needed) + " of memory" +
                                 (processes > 1 ? " on this machine" : "");
  const std::uint64_t most = processes * std::uint64_t{std::numeric_limits<Index>::max()};
  if (points > most) {
    const std::string by =
        processes > 1 ? " by " + std::to_string(processes) + " processes" : std::string();
    throw InvalidInput(would_need + ", and are more than the " + std::to_string(most) +
                       " points supported" + by);
  }
  require_memory(would_need, needed);
  return bytes_text(needed);
}

void check_cells(const std::filesystem::path& volume, std::uint64_t cells, std::uint64_t bytes) {
  const auto needed = static_cast<double>(bytes);
  require_memory(volume.string() + ": " + std::to_string(cells) + " cells would need " +
                     bytes_text(needed) + " of memory",
                 needed);
}

std::string check_memory(Index sites, Index points_per_site, int dimension,
                         std::size_t scalar_bytes, std::uint64_t other_bytes) {
  const std::int64_t points = std::int64_t{sites} * points_per_site;
  return check_memory("--sites " + std::to_string(sites), static_cast<std::uint64_t>(points),
                      dimension, scalar_bytes, other_bytes);
}

std::string check_memory(const std::string& what, std::uint64_t points, int dimension,
                         std::size_t scalar_bytes, std::uint64_t other_bytes,
                         std::uint64_t processes) {
  // In double, which no product of three such numbers overflows.
  const double needed =
      4.0 * static_cast<double>(points) * dimension * static_cast<double>(scalar_bytes) + 100e6 +
      static_cast<double>(other_bytes);
  return check_bytes(what, points, dimension, needed, processes);
}

double training_bytes(const VectorsHeld& vectors, Index codewords, bool exact) {
  const auto m = static_cast<double>(vectors.count);
  const double n = codewords;
  const double coordinates = static_cast<double>(vectors.scalar_bytes) * vectors.dimension;
  const double pairs = n <= kMostWithBounds ? n * n : kMostWithBounds * n / 4;
  // Of samples the largest is the last level of an exact training, or what breeding looks at.
  const double level = exact ? m / 2 * (coordinates + kTrainingVector) : 0;
  const double bred = std::min(m, 1024 * n) * (4.0 * vectors.dimension + kTrainingVector);
  return m * (kTrainingVector + (vectors.mapped ? 0 : coordinates)) + std::max(level, bred) +
         pairs * (exact ? kExactPair : kBound) + 20e6;
}

double encoding_bytes(const VectorsHeld& vectors) {
  const auto m = static_cast<double>(vectors.count);
  const double coordinates = static_cast<double>(vectors.scalar_bytes) * vectors.dimension;
  return m * (kEncodingVector + (vectors.mapped ? 0 : coordinates)) + 100e6;
}

std::uint64_t peak_memory_bytes() {
  // Not getrusage(): what it says of a program is no less than what started it had held.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    std::istringstream words(line);
    std::string name;
    std::uint64_t kilobytes = 0;
    if (words >> name >> kilobytes && name == "VmHWM:") return kilobytes * 1024;
  }
  struct rusage usage = {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace ccvt::cli
