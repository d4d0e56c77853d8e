#pragma once

#include <filesystem>
#include <memory>

#include "ccvt/export.h"
#include "ccvt/io.h"
#include "ccvt/types.h"

namespace ccvt {

/// The points of a file, read-only, where they lie on the disk if that can be: the system then
/// fetches what is looked at, and drops it where memory is short.
///
///     const ccvt::MappedPoints<float> vectors("vectors.fvecs");
///     const auto training = ccvt::train_codebook(vectors.view(), 1024, {});
///     vectors.check_unchanged();
///
/// Mapped are .fvecs as float, and .npy in C order of native float32 as float, of float64 as
/// double, unless columns are chosen. All other files of points are read, as by read_points().
///
/// A file that another process makes shorter while it is mapped ends this one by SIGBUS, unless
/// that is handled; one that is replaced by another of its name does no harm.
template <class Scalar>
class CCVT_EXPORT MappedPoints {
 public:
  /// O(#points #dimensions): all points are looked at. Throws as read_points() does, with the same
  /// messages.
  explicit MappedPoints(const std::filesystem::path& path, const ReadOptions& options = {});
  MappedPoints(MappedPoints&&) noexcept;
  MappedPoints& operator=(MappedPoints&&) noexcept;
  ~MappedPoints();

  /// #dimensions by #points, all finite; valid while this object lives. At least one point, unless
  /// the options ask for a part of the rows, of which the others are not looked at.
  [[nodiscard]] PointsView<Scalar> view() const;
  /// False: the points are in memory of this object.
  [[nodiscard]] bool mapped() const;
  /// Throws InvalidInput if the file has been written to since it was mapped: what has been
  /// computed then holds for no file that ever was. Does nothing where it was read.
  void check_unchanged() const;

  /// Whether a file will be mapped, without reading the points.
  [[nodiscard]] static bool can_map(const std::filesystem::path& path,
                                    const ReadOptions& options = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

extern template class MappedPoints<float>;
extern template class MappedPoints<double>;

}  // namespace ccvt
