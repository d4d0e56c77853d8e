#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/density.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/io.h"
#include "ccvt/options.h"
#include "ccvt/ranks.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// A regular grid of cells in the world, in any number of dimensions D. The cell with the index
/// (i, j, …), from 0, has its centre at origin + axes * (i, j, …).
struct CCVT_EXPORT Grid {
  /// Cells along each axis; the first one varies fastest in memory.
  std::vector<std::int64_t> shape;
  /// D: the centre of the first cell.
  Coordinates origin;
  /// D by D: column a leads from a cell to the next one along axis a: the direction of the axis
  /// times the spacing along it. Not singular.
  Columns<double> axes;

  /// A grid along the axes of the world. Throws InvalidInput unless both vectors have as many
  /// entries as `shape`, and all spacings are positive and finite.
  static Grid spaced(std::vector<std::int64_t> shape, const Coordinates& spacing,
                     const Coordinates& origin);

  [[nodiscard]] int dimension() const { return static_cast<int>(shape.size()); }
  /// The distance of neighbouring centres along each axis.
  [[nodiscard]] Eigen::VectorXd spacing() const {
    return axes.eigen().colwise().norm().transpose();
  }
  /// |det(axes)|.
  [[nodiscard]] double cell_volume() const;

  /// The view of a density, with the default options, from which points are drawn in the world.
  [[nodiscard]] DensityGrid density(GridValues values,
                                    Interpolation interpolation = Interpolation::linear) const;
};

/// How the values of a field become densities.
struct CCVT_EXPORT ValueMap {
  enum class Kind {
    linear,     ///< v, as it is
    window,     ///< 0 at `low` and below, 1 at `high` and above, linear in between
    threshold,  ///< 1 at `low` and above, 0 below
    gamma,      ///< (v / greatest)^gamma
  };
  Kind kind = Kind::linear;
  double low = 0;
  double high = 1;
  double gamma = 1;
  /// Dense where the values are low: greatest - v takes the place of v in `linear` and `gamma`, and
  /// 1 - d that of d in the others.
  bool invert = false;

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
  /// Whether the greatest value matters.
  [[nodiscard]] bool needs_greatest() const {
    return kind == Kind::gamma || (kind == Kind::linear && invert);
  }
  /// `greatest` is that of the field. Throws InvalidInput where `kind` is no enumerator.
  [[nodiscard]] double operator()(double value, double greatest) const;
};

/// The types of values that files of volumes hold.
enum class VoxelType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// What one value takes, 1 to 8. As to_string(), throws InvalidInput for what is no enumerator.
CCVT_EXPORT std::size_t bytes_of(VoxelType type);
/// "int8", "uint8", …
CCVT_EXPORT const char* to_string(VoxelType type);

/// What a file of a volume promises to hold, known before its values are read.
struct CCVT_EXPORT VolumeHeader {
  Grid grid;
  VoxelType type = VoxelType::uint8;
  /// A stored number s stands for the value slope * s + intercept.
  double slope = 1;
  double intercept = 0;
  /// The file that holds the values: the volume's own, or the one that it names.
  std::filesystem::path data_file = {};

  [[nodiscard]] std::uint64_t cells() const;
  [[nodiscard]] std::uint64_t bytes() const { return cells() * bytes_of(type); }
};

/// A scalar field in three dimensions, as a file holds it. Its numbers keep their type: a volume
/// takes as much memory as the file, unpacked.
struct CCVT_EXPORT Volume : VolumeHeader {
  std::vector<std::byte> data;  ///< bytes() of them

  /// The stored numbers: a view.
  [[nodiscard]] GridValues stored() const&;
  [[nodiscard]] GridValues stored() const&& = delete;
  /// The greatest value where the mask, if there is one, is not 0; minus infinity where it is 0
  /// everywhere. Throws InvalidInput when a value there is NaN or infinite, naming it by its index,
  /// and unless the mask is empty or has an entry for each cell. O(#cells).
  [[nodiscard]] double greatest(std::span<const std::uint8_t> mask = {}) const;
  /// The density that `map` makes of the values, multilinear, masked: a view, and so not to be had
  /// of a temporary.
  [[nodiscard]] DensityGrid density(const ValueMap& map = {}, MaskView mask = {}) const&;
  [[nodiscard]] DensityGrid density(const ValueMap& map = {}, MaskView mask = {}) const&& = delete;
  /// The same of a part of a volume, `greatest` being that of the whole.
  [[nodiscard]] DensityGrid density(const ValueMap& map, double greatest, MaskView mask) const&;
};

/// What a file does not say itself.
struct VolumeLayout {
  /// Cells along x, y and z, x fastest. Needed for raw files, and for these only.
  std::vector<std::int64_t> shape = {};
  /// Of a raw file.
  std::optional<VoxelType> type = {};
  bool big_endian = false;
  /// One for each axis; 1 where empty. For raw and .npy files only.
  std::vector<double> spacing = {};
  /// The centre of the first cell; 0 where empty. For raw and .npy files only.
  std::vector<double> origin = {};
};

/// Reads a volume, told by the extension:
///
///   .nii, .nii.gz  NIfTI-1 and NIfTI-2, either byte order, all scalar types of up to 64 bits.
///                  World coordinates are those of the sform, else of the qform, else index times
///                  pixdim. One volume: 4D series, colours and complex numbers are refused.
///   .nrrd, .nhdr   NRRD 1 to 5, the data in the same file or in one other; raw or gzip; world
///                  coordinates as in the file's own space.
///   .npy           Shape (A, B, C), C or Fortran order, either byte order; bool becomes uint8,
///                  float16 becomes float32. World coordinates are in the order of the array's
///                  axes: entry [a, b, c] is at origin + spacing * (a, b, c).
///   .raw           With the shape and type from `layout`.
///
/// What a header promises is compared with the size of the file, and with the most that gzip can
/// pack into it, before anything is allocated. Throws InvalidInput, with one line that names file
/// and rule, for files that are truncated, too long, damaged or hold something else, and for a
/// layout that the file does not need; IoError when the system refuses.
CCVT_EXPORT Volume read_volume(const std::filesystem::path& path, const VolumeLayout& layout = {});
/// The same without the values, which are not looked at.
CCVT_EXPORT VolumeHeader inspect_volume(const std::filesystem::path& path,
                                        const VolumeLayout& layout = {});

/// Of a volume, these layers, as a volume of its own that is where they are. Of files that are not
/// packed, other layers are not read. Throws as read_volume() does, and unless 0 <= begin <= end <=
/// #layers.
CCVT_EXPORT Volume read_volume(const std::filesystem::path& path, const VolumeLayout& layout,
                               const LayerRange& layers);
/// The density of a volume of which each rank has read `part`, the layers of layers_of_rank(), and
/// `mask`, where there is one, with an entry for each cell of these. A view of both. All ranks call
/// this together; throws InvalidInput, on all, as Volume::density() does.
CCVT_EXPORT DensityLayers density_layers(Ranks& ranks, const VolumeHeader& whole,
                                         const Volume& part, const ValueMap& map = {},
                                         MaskView mask = {});

/// How a density becomes samples.
struct CCVT_EXPORT VolumeOptions {
  /// Points drawn from the density for each site. At least 1.
  Index points_per_site = 256;
  DensitySampling sampling = DensitySampling::stratified;
  /// Whether VolumeSamples hold the points that were drawn, and their owners.
  bool keep_points = false;
  /// Its seed also fixes the points that are drawn, and its threads draw them. Until blue_noise, as
  /// samples are wanted irregular.
  Options tessellation = Options::samples();

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// Samples that spread evenly through a density.
struct VolumeSamples {
  /// D by #sites, in the world. None lies in a cell of density 0, such as one outside the mask.
  Columns<double> sites;
  /// How many points each site owns.
  std::vector<Index> capacities;
  /// The mass of each cell: its share of the points times the integral of the density over the
  /// world. The sum over sites of weight * f(site) approximates the integral of density * f.
  std::vector<double> weights;
  /// The local spacing, sqrt((D + 2) / D * mean |p - s|^2) over the points p of site s: of a ball
  /// with uniform points it is the radius.
  std::vector<double> radii;
  /// Centroids of bent cells may lie where the density is 0. So many were, once all else was done,
  /// put on the nearest point of their own cell, and that far at most. Summary, weights and radii
  /// describe the centroids.
  Index put_back = 0;
  double farthest_put_back = 0;
  /// With VolumeOptions::keep_points only: D by #points, in the world, and the site that owns
  /// each. 8 D + 4 bytes a point.
  Columns<double> points;
  std::vector<Index> owners;
  /// What was computed in.
  ScalarType scalar = ScalarType::float32;
  Summary summary;
};

/// Draws sites * points_per_site points from a density and tessellates them in Euclidean space, in
/// world units: voxels need not be cubes. Computes in Scalar, relative to the middle of the grid:
/// how far that is from the origin of the world does not matter. Memory, beside the grid: about 4
/// times the coordinates of the points. Throws InvalidInput for what sample_density() refuses, when
/// `sites` is less than 1, and for bad options; Cancelled when the run is cancelled before all
/// points are drawn.
template <class Scalar = float>
CCVT_EXPORT VolumeSamples sample_volume(const DensityGrid& density, Index sites,
                                        const VolumeOptions& options = {});

/// The same by all ranks together, to the bit; each has its layers of the density, its share of the
/// points, at most 2^31 - 1 of 2^40 in all, and all samples. `points` and `owners`, where they are
/// kept, are those of sample_density() on this rank. Drawing is not cancelled.
template <class Scalar = float>
CCVT_EXPORT VolumeSamples sample_volume(Ranks& ranks, const DensityLayers& density, Index sites,
                                        const VolumeOptions& options = {});

/// Writes samples in two or three dimensions by extension:
///
///   .ply        binary, little endian: x, y, z, radius, capacity, weight for each vertex
///   .vtp        VTK XML poly data, binary: points with the arrays radius, capacity, weight
///   .vtk        the same in the legacy format
///   .csv, .txt  a header line, then x, y, z, radius, capacity, weight; in D dimensions x0, x1, …
///   .npy        the sites alone, (#sites, D), float64
///
/// Numbers are float64 when the samples were computed in that, or when float32 would move a site
/// by more than a thousandth of the mean radius; else float32, in text with as many digits as that
/// takes. Errors are those of the other writers, see io.h.
CCVT_EXPORT void write_samples(const std::filesystem::path& path, const VolumeSamples& samples);

/// Three pictures side by side: the density of a 3D grid summed along its third, second and first
/// axis, in grey, with the samples over it in orange. Where these would cover each other, a picture
/// shows a slab around the middle of the samples, so thin that they stay apart. Pixels are square
/// in the world. `size`: of the longest side of a picture, in pixels, from 16 to 4096. Throws
/// InvalidInput for other sizes and dimensions.
template <class Scalar>
CCVT_EXPORT ColourImage preview(const DensityGrid& density, PointsView<Scalar> sites,
                                int size = 480);
template <class Derived>
ColourImage preview(const DensityGrid& density, const Eigen::DenseBase<Derived>& sites,
                    int size = 480) {
  return preview(density, view_points(sites), size);
}
template <class Scalar>
ColourImage preview(const DensityGrid& density, const Columns<Scalar>& sites, int size = 480) {
  return preview(density, view_points(sites), size);
}

}  // namespace ccvt
