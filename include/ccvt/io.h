#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "ccvt/export.h"
#include "ccvt/types.h"

/// Points, owners and pictures in files, by extension:
///
///   .npy        NumPy arrays, versions 1.0 to 3.0. Points: float32 or float64 of shape
///               (#points, #dimensions), read also from bool, float16 and whole numbers that Scalar
///               holds exactly, of either byte order, in C or Fortran order, which takes no more
///               memory. Owners: int32 of shape (#points,), read also from other whole numbers.
///   .fvecs,     Points, read only: of each its dimension (int32), then as many float32 or uint8.
///   .bvecs
///   .csv, .txt  One point, or one whole number, a line. Fields are separated by blanks, or by
///               one comma or one semicolon. '#' starts a comment, blank lines count for nothing,
///               and a first line in which no field is a number is a header. It names the columns,
///               if there is one name for each: those called x, y and z, as many as there are of
///               them, or else x0, x1, …, are then the coordinates, in that order, in either case.
///               All columns are where there is neither x nor x0. Numbers are written with as many
///               digits as it takes to read the same bits back.
///   .ply        Read only: the vertices of a PLY file, ascii or binary of either byte order: x and
///               y, and z if there is one. Other properties and elements are skipped.
///   .gadget,    Particles of simulations, in one file: see particles.h. The points are the
///   .hdf5       positions of all types, float32 or float64.
///   .png, .jpg  Pictures.
///
/// ReadOptions::columns says which columns are coordinates where this is not what is meant.
///
/// Readers throw InvalidInput with one line that names the file, the place (rows of .npy and
/// columns from 0, lines of text from 1), the value and the rule. They compare what a header
/// promises with the size of the file before they allocate.
///
/// Writers replace a file as a whole: they write a new one beside it, flush that to its disk, and
/// rename it. Whoever opens the file, and whenever the process or the machine stops, finds all of
/// the old one or all of the new one. The directory is flushed after the rename, where that can be.
/// Of several that write one file at a time, the last to end wins. The new file has the permissions
/// of the old one (but not its owner, further links and attributes), else those that the umask
/// leaves. A symbolic link stays one: what it leads to is replaced, or made. Directories, devices,
/// pipes and files without permission to write are refused.
///
/// Until its renaming a file is called .ccvt-*.part, the star being 16 random hexadecimal digits,
/// in the directory of the file to be replaced. A writer that fails removes it; after a signal see
/// remove_unfinished_files() in publication.h. What SIGKILL or a power failure leaves of that name
/// belongs to no one, and may be deleted when no process writes there.
///
/// Writers throw InvalidInput for an unknown extension, IoError when the system refuses; either way
/// a file of that name that was there before is still there. To make several files appear together,
/// see publication.h.
namespace ccvt {

/// Thrown when the operating system fails a read or a write. The message names the file.
class IoError : public std::runtime_error {
 public:
  explicit IoError(const std::string& message) : std::runtime_error(message) {}
};

/// How a file stores its coordinates; of others than these, what holds all numbers of their type
/// exactly, or else float64.
enum class ScalarType { float32, float64 };

/// What a file of points promises to hold.
struct PointsHeader {
  ScalarType scalar = ScalarType::float64;  ///< float64 for text
  int dimension = 0;
  std::uint64_t count = 0;  ///< points; of text the number of lines, an upper bound
  /// What the header of a text file, or of a PLY file, calls the coordinates; empty where there is
  /// none.
  std::vector<std::string> columns = {};
  /// Other columns of a text file, where nobody said which are coordinates.
  std::vector<std::string> left_out = {};
  /// Nobody said which are, and names do not tell: all columns are taken.
  bool unknown = false;
  /// Their names put them in another order than the file has.
  bool reordered = false;
  /// Of particles: the extents of the periodic box, from 0, that they fill; empty when the file
  /// says nothing of one.
  std::vector<double> box = {};
};

/// How a file of points is read where its format leaves a choice.
struct ReadOptions {
  /// The columns that are coordinates, in this order: names of a text file's header or of
  /// properties of PLY vertices, or numbers, from 1, in any file. Empty: as the format has it.
  std::vector<std::string> columns = {};
  /// Only the points first_row.. to end_row - 1, of those that there are; none is an empty set. In
  /// .npy files in C order, .fvecs and .bvecs, without a look at the others: what one of several
  /// processes reads. Other files must be read whole: InvalidInput.
  std::uint64_t first_row = 0;
  std::uint64_t end_row = UINT64_MAX;
};

namespace detail {
/// Memory of the caller for #dimensions * count coordinates: what allocate(owner, dimension, count)
/// returns.
template <class Scalar>
struct Allocation {
  void* owner = nullptr;
  Scalar* (*allocate)(void* owner, int dimension, Index count) = nullptr;
};
template <class Scalar>
Allocation<Scalar> allocate_in(Points<Scalar>& points) {
  return {&points, [](void* owner, int dimension, Index count) {
            auto& sized = *static_cast<Points<Scalar>*>(owner);
            sized.resize(dimension, count);
            return sized.data();
          }};
}
/// Allocates once, when the numbers of points and dimensions are known, and fills.
CCVT_EXPORT void read_points(const std::filesystem::path& path, const ReadOptions& options,
                             Allocation<float> points);
CCVT_EXPORT void read_points(const std::filesystem::path& path, const ReadOptions& options,
                             Allocation<double> points);
}  // namespace detail

/// Looks at a file of points without reading the points.
CCVT_EXPORT PointsHeader inspect_points(const std::filesystem::path& path,
                                        const ReadOptions& options = {});

/// #dimensions by #points, all finite, at least one point. A float64 file read as float is
/// rounded; a coordinate too large for float is refused, and so is a whole number of an .npy file
/// that Scalar does not hold exactly.
template <class Scalar>
Points<Scalar> read_points(const std::filesystem::path& path, const ReadOptions& options = {}) {
  Points<Scalar> points;
  detail::read_points(path, options, detail::allocate_in(points));
  return points;
}

/// `points`: one a row or line, float32 or float64 as Scalar is; all finite, else InvalidInput.
template <class Scalar>
CCVT_EXPORT void write_points(const std::filesystem::path& path, PointsView<Scalar> points);
template <class Derived>
void write_points(const std::filesystem::path& path, const Eigen::DenseBase<Derived>& points) {
  write_points(path, view_points(points));
}
template <class Scalar>
void write_points(const std::filesystem::path& path, const Columns<Scalar>& points) {
  write_points(path, view_points(points));
}

/// Whole numbers, such as capacities or owners: one a line, or of shape (#,) or (#, 1); written in
/// whatever way and of any type but bool, as 1e2 and floats, too. At least one. Throws InvalidInput
/// for those that are not whole or do not fit Index.
CCVT_EXPORT std::vector<Index> read_indices(const std::filesystem::path& path);

/// Numbers, such as masses: one a line, or of any real type and shape (#,) or (#, 1). At least one,
/// all finite; 64-bit whole numbers of shape (#,) are rounded.
CCVT_EXPORT std::vector<double> read_numbers(const std::filesystem::path& path);

/// One a line, or int32 of shape (#owners,). At least one; else InvalidInput.
CCVT_EXPORT void write_owners(const std::filesystem::path& path, std::span<const Index> owners);

/// Writes `text` as it is, whatever the extension.
CCVT_EXPORT void write_text(const std::filesystem::path& path, std::string_view text);

/// A grey picture, row by row from the top: 0 is black, 1 is white, as stored (perceptual values,
/// not linear light). Pixel (x, y), x to the right and y down, covers [x, x+1) by [y, y+1).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> values;  ///< width * height of them, in [0, 1]

  [[nodiscard]] float operator()(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// Reads PNG or JPEG, 8 or 16 bits, told by the file's contents. Colours become grey by the luma
/// weights of Rec. 709 (0.2126, 0.7152, 0.0722); alpha is composited on white. White stays 1
/// exactly. Pictures are turned upright as their Exif data say. Throws InvalidInput for truncated
/// and damaged files too; for more than 2^28 pixels, or more than the file can hold (1032 bytes of
/// rows a byte of PNG, 1024 pixels a byte of JPEG), before it allocates any; and for JPEGs in CMYK,
/// with other than 8 bits a sample, lossless, of arithmetic codes, or of more than 100 scans.
CCVT_EXPORT Image read_image(const std::filesystem::path& path);

/// Writes 8-bit grey; `path` ends in .png. Throws InvalidInput unless the image has pixels and as
/// many values; values outside [0, 1] are clamped, and NaN is black.
CCVT_EXPORT void write_png(const std::filesystem::path& path, const Image& image);

/// A picture in colour, row by row from the top.
struct ColourImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height of them
};

/// The same in 8-bit colour.
CCVT_EXPORT void write_png(const std::filesystem::path& path, const ColourImage& image);

/// Like read_image(), but keeps colours, in 8 bits; grey becomes colour of three equal values.
CCVT_EXPORT ColourImage read_colour_image(const std::filesystem::path& path);

/// The file that a writer given `path` makes or replaces: `path` itself, or what it leads to if it
/// is a symbolic link. It need not exist. Throws IoError for links in a circle.
CCVT_EXPORT std::filesystem::path output_target(const std::filesystem::path& path);

}  // namespace ccvt
