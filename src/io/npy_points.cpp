#include "io/npy_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "io/columns.h"
#include "io/input_file.h"
#include "io/npy.h"
#include "io/npy_numbers.h"
#include "io/points_map.h"
#include "io/text.h"

namespace ccvt::io {

namespace {

constexpr std::uint64_t kMostDimensions = std::uint64_t{1} << 24;
constexpr auto kNone = std::numeric_limits<std::size_t>::max();

/// Whether float holds every number of the type.
bool is_narrow(NpyType type) {
  switch (type) {
    case NpyType::int32:
    case NpyType::uint32:
    case NpyType::int64:
    case NpyType::uint64:
    case NpyType::float64:
      return false;
    default:
      return true;
  }
}

/// What is wrong with a number as a coordinate, or nothing. `value` is what it becomes.
template <class Scalar, class Stored>
const char* convert(Stored stored, Scalar& value) {
  constexpr bool single = std::is_same_v<Scalar, float>;
  value = static_cast<Scalar>(stored);
  if constexpr (std::is_floating_point_v<Stored>) {
    if (std::isfinite(value)) return nullptr;
    return std::isfinite(stored) ? "is out of the range of float32"
                                 : "is not finite; coordinates must be finite";
  } else {
    // 2^digits itself would not fit; nothing above it is reached by a smaller number.
    const Scalar end = std::ldexp(Scalar{1}, std::numeric_limits<Stored>::digits);
    if (value < end && static_cast<Stored>(value) == stored) return nullptr;
    return single ? "is a whole number that float32 does not hold exactly; float64 may"
                  : "is a whole number that float64 does not hold exactly";
  }
}

/// An open file, at its data.
class NpyPoints {
 public:
  NpyPoints(const std::filesystem::path& path, const ReadOptions& options)
      : file_(path), npy_(read_npy_header(file_)) {
    check();
    columns_ = choose_columns(file_, options.columns, {}, extent(1)).at;
    const RowRange asked(options, npy_.shape[0]);
    first_ = asked.begin;
    end_ = asked.end;
    if (npy_.fortran_order && rows() < npy_.shape[0]) {
      file_.fail("is in Fortran order; a part of its rows is read of files in C order only");
    }
  }

  [[nodiscard]] PointsHeader header() const {
    return {is_narrow(item_.type) ? ScalarType::float32 : ScalarType::float64,
            static_cast<int>(columns_.size()), rows()};
  }

  [[nodiscard]] std::optional<PointLayout> layout() const {
    const bool floats = item_.type == NpyType::float32 || item_.type == NpyType::float64;
    if (!floats || item_.big_endian || npy_.fortran_order) return {};
    const auto width = static_cast<int>(npy_.shape[1]);
    return PointLayout{header().scalar, width, npy_.shape[0], file_.size() - npy_.data_bytes,
                       width};
  }

  template <class Scalar>
  void read(const detail::Allocation<Scalar>& allocation);

 private:
  void check();
  [[nodiscard]] std::uint64_t rows() const { return end_ - first_; }
  [[nodiscard]] std::size_t extent(std::size_t axis) const { return npy_.shape[axis]; }
  /// Of each column of the file, which coordinate it is, or kNone.
  [[nodiscard]] std::vector<std::size_t> targets() const;
  template <class Scalar>
  void read_rows(PointsMap<Scalar>& points);
  template <class Scalar>
  void read_columns(PointsMap<Scalar>& points);
  template <class Stored, class Scalar>
  void put(Stored stored, std::size_t row, std::size_t column, Scalar& coordinate) const;

  InputFile file_;
  NpyHeader npy_;
  NpyItem item_;
  std::vector<std::size_t> columns_;  ///< those that are coordinates
  std::uint64_t first_ = 0;           ///< rows that are read
  std::uint64_t end_ = 0;
};

/// Checks all that the header says; the data behind it is then as long as it has to be.
void NpyPoints::check() {
  const auto item = parse_npy_descr(npy_.descr);
  if (!item) {
    file_.fail("has dtype " + io::quoted(npy_.descr) +
               "; points must be bool, whole numbers of 8 to 64 bits, or floats of 16 to 64");
  }
  item_ = *item;
  const std::string shape = "has the shape " + shape_text(npy_.shape);
  if (npy_.shape.size() != 2) {
    file_.fail(shape + "; points need two extents: (points, dimensions)");
  }
  check_npy_size(file_, npy_, item_.bytes);
  if (npy_.shape[0] == 0) file_.fail(shape + ": no points");
  if (npy_.shape[1] == 0) file_.fail(shape + ": no dimensions");
  if (npy_.shape[1] > kMostDimensions) {
    file_.fail(shape + "; at most 16777216 dimensions are supported");
  }
}

template <class Stored, class Scalar>
void NpyPoints::put(Stored stored, std::size_t row, std::size_t column, Scalar& coordinate) const {
  const char* const wrong = convert(stored, coordinate);
  if (wrong == nullptr) return;
  std::string value;
  if constexpr (std::is_floating_point_v<Stored>) {
    append(value, stored);
  } else {
    value = std::to_string(stored);
  }
  file_.fail("row " + std::to_string(row) + ", column " + std::to_string(column) + ": " + value +
             " " + wrong);
}

std::vector<std::size_t> NpyPoints::targets() const {
  std::vector<std::size_t> target(extent(1), kNone);
  for (std::size_t k = 0; k < columns_.size(); ++k) target[columns_[k]] = k;
  return target;
}

/// In C order: point by point.
template <class Scalar>
void NpyPoints::read_rows(PointsMap<Scalar>& points) {
  const std::vector<std::size_t> target = targets();
  std::size_t row = first_;
  std::size_t column = 0;
  Scalar* point = points.data();
  file_.skip(first_ * extent(1) * item_.bytes);
  read_npy_numbers(file_, item_, rows() * extent(1), [&](auto number) {
    if (target[column] != kNone) put(number, row, column, point[target[column]]);
    if (++column < target.size()) return;
    column = 0;
    ++row;
    point += columns_.size();
  });
}

/// In Fortran order: one coordinate of all points after the other, each to its place at once.
template <class Scalar>
void NpyPoints::read_columns(PointsMap<Scalar>& points) {
  const std::vector<std::size_t> target = targets();
  for (std::size_t column = 0; column < target.size(); ++column) {
    if (target[column] == kNone) {
      file_.skip(npy_.shape[0] * item_.bytes);
      continue;
    }
    Scalar* coordinate = points.data() + target[column];
    std::size_t row = 0;
    read_npy_numbers(file_, item_, npy_.shape[0], [&](auto number) {
      put(number, row++, column, *coordinate);
      coordinate += columns_.size();
    });
  }
}

template <class Scalar>
void NpyPoints::read(const detail::Allocation<Scalar>& allocation) {
  require_countable(file_, rows());
  PointsMap<Scalar> points = allocate(allocation, header());
  if (npy_.fortran_order) {
    read_columns(points);
  } else {
    read_rows(points);
  }
}

}  // namespace

PointsHeader inspect_npy_points(const std::filesystem::path& path, const ReadOptions& options) {
  return NpyPoints(path, options).header();
}

std::optional<PointLayout> layout_of_npy(const std::filesystem::path& path) {
  return NpyPoints(path, {}).layout();
}

template <class Scalar>
void read_npy_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation) {
  NpyPoints(path, options).read(allocation);
}

template void read_npy_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<float>&);
template void read_npy_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<double>&);

}  // namespace ccvt::io
