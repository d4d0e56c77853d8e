#include "io/vecs.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "io/formats.h"
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
  return {ScalarType::float32, dimension, count};
}

void check_dimension(const InputFile& file, std::uint64_t vector, std::int32_t dimension,
                     std::int32_t first) {
  if (dimension == first) return;
  file.fail("vector " + std::to_string(vector) + " has " + std::to_string(dimension) +
            " dimensions, but vector 0 has " + std::to_string(first) +
            "; all need the same number");
}

bool holds_bytes(const std::filesystem::path& path) { return extension_of(path) == ".bvecs"; }

template <class Stored, class Scalar>
PointsMap<Scalar> read_records(const std::filesystem::path& path, const ReadOptions& options,
                               const detail::Allocation<Scalar>& allocation) {
  InputFile file(path);
  PointsHeader header = read_header(file, sizeof(Stored));
  const RowRange rows(options, header.count);
  header.count = rows.size();
  require_countable(file, header.count);
  PointsMap<Scalar> points = allocate(allocation, header);
  std::vector<Stored> vector(static_cast<std::size_t>(header.dimension));
  const std::size_t bytes = vector.size() * sizeof(Stored);
  std::int32_t dimension = header.dimension;  // of the vector that comes next
  if (rows.begin > 0 && rows.size() > 0) {
    file.skip(rows.begin * (bytes + sizeof dimension) - sizeof dimension);
    file.read(&dimension, sizeof dimension);
  }
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    if (p > 0) file.read(&dimension, sizeof dimension);
    check_dimension(file, rows.begin + static_cast<std::uint64_t>(p), dimension, header.dimension);
    file.read(vector.data(), bytes);
    std::copy(vector.begin(), vector.end(), points.col(p).data());
  }
  return points;
}

}  // namespace

bool is_vecs(const std::filesystem::path& path) {
  return extension_of(path) == ".fvecs" || holds_bytes(path);
}

PointsHeader inspect_vecs(const std::filesystem::path& path, const ReadOptions& options) {
  InputFile file(path);
  PointsHeader header = read_header(file, holds_bytes(path) ? sizeof(std::uint8_t) : sizeof(float));
  header.count = RowRange(options, header.count).size();
  return header;
}

std::optional<PointLayout> layout_of_vecs(const std::filesystem::path& path) {
  if (holds_bytes(path)) return {};
  const PointsHeader header = inspect_vecs(path, {});
  return PointLayout{header.scalar, header.dimension, header.count, sizeof(std::int32_t),
                     std::ptrdiff_t{header.dimension} + 1};
}

void check_dimensions(const InputFile& file, const std::byte* bytes, const PointLayout& layout,
                      const RowRange& rows) {
  static_assert(sizeof(std::int32_t) == sizeof(float));
  const auto stride = static_cast<std::uint64_t>(layout.stride);
  for (std::uint64_t p = rows.begin; p < rows.end; ++p) {
    std::int32_t dimension = 0;
    std::memcpy(&dimension, bytes + p * stride * sizeof dimension, sizeof dimension);
    check_dimension(file, p, dimension, layout.dimension);
  }
}

template <class Scalar>
PointsMap<Scalar> read_vecs(const std::filesystem::path& path, const ReadOptions& options,
                            const detail::Allocation<Scalar>& allocation) {
  return holds_bytes(path) ? read_records<std::uint8_t>(path, options, allocation)
                           : read_records<float>(path, options, allocation);
}

template PointsMap<float> read_vecs(const std::filesystem::path&, const ReadOptions&,
                                    const detail::Allocation<float>&);
template PointsMap<double> read_vecs(const std::filesystem::path&, const ReadOptions&,
                                     const detail::Allocation<double>&);

}  // namespace ccvt::io
