#include "io/vecs.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "io/input_file.h"

namespace ccvt::io {

static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::int32_t kMostDimensions = 1 << 24;

/// Reads the first dimension, and checks the size of the file by it.
PointsHeader read_header(InputFile& file, std::size_t item_bytes) {
  std::int32_t dimension = 0;
  file.read(&dimension, sizeof dimension);
  if (dimension < 1 || dimension > kMostDimensions) {
    file.fail("vector 0 has " + std::to_string(dimension) +
              " dimensions; from 1 to 16777216 are supported");
  }
  const std::uint64_t record =
      sizeof dimension + static_cast<std::uint64_t>(dimension) * item_bytes;
  if (file.size() % record != 0) {
    file.fail("has " + std::to_string(file.size()) + " bytes, not a multiple of the " +
              std::to_string(record) + " that a vector of " + std::to_string(dimension) +
              " dimensions takes");
  }
  const std::uint64_t count = file.size() / record;
  if (count > std::numeric_limits<Index>::max()) {
    file.fail("has " + std::to_string(count) + " vectors; at most 2147483647 are supported");
  }
  return {ScalarType::float32, dimension, count};
}

bool holds_bytes(const std::filesystem::path& path) { return extension_of(path) == ".bvecs"; }

template <class Stored, class Scalar>
PointsMap<Scalar> read_records(InputFile& file, const detail::Allocation<Scalar>& allocation) {
  const PointsHeader header = read_header(file, sizeof(Stored));
  PointsMap<Scalar> points = allocate(allocation, header);
  std::vector<Stored> vector(static_cast<std::size_t>(header.dimension));
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    if (p > 0) {
      std::int32_t dimension = 0;
      file.read(&dimension, sizeof dimension);
      if (dimension != header.dimension) {
        file.fail("vector " + std::to_string(p) + " has " + std::to_string(dimension) +
                  " dimensions, but vector 0 has " + std::to_string(header.dimension) +
                  "; all need the same number");
      }
    }
    file.read(vector.data(), vector.size() * sizeof(Stored));
    std::copy(vector.begin(), vector.end(), points.col(p).data());
  }
  return points;
}

}  // namespace

bool is_vecs(const std::filesystem::path& path) {
  return extension_of(path) == ".fvecs" || holds_bytes(path);
}

PointsHeader inspect_vecs(const std::filesystem::path& path) {
  InputFile file(path);
  return read_header(file, holds_bytes(path) ? sizeof(std::uint8_t) : sizeof(float));
}

template <class Scalar>
PointsMap<Scalar> read_vecs(const std::filesystem::path& path,
                            const detail::Allocation<Scalar>& allocation) {
  InputFile file(path);
  return holds_bytes(path) ? read_records<std::uint8_t>(file, allocation)
                           : read_records<float>(file, allocation);
}

template PointsMap<float> read_vecs(const std::filesystem::path&, const detail::Allocation<float>&);
template PointsMap<double> read_vecs(const std::filesystem::path&,
                                     const detail::Allocation<double>&);

}  // namespace ccvt::io
