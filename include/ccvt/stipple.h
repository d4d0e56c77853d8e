#pragma once

#include <filesystem>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/io.h"
#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// How a picture becomes dots.
struct CCVT_EXPORT StippleOptions {
  /// Points drawn from the darkness for each dot. At least 1.
  Index points_per_site = 256;
  /// Dots where the picture is light, instead of dark.
  bool invert = false;
  /// Exponent on the darkness; above 1 there are fewer dots in the light parts. Positive, finite.
  double gamma = 1;
  /// In pixels of the picture; 0: the radius of dot_radius_for(). At least 0, finite.
  double dot_radius = 0;
  /// Its seed also fixes the points that are drawn. Until blue_noise, as dots are wanted irregular.
  Options tessellation = Options::samples();

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// A picture made of equal black dots on white, in the pixel coordinates of the image it was made
/// from: x to the right, y down, pixel (x, y) covers [x, x+1) by [y, y+1).
template <class Scalar>
struct Stippling {
  int width = 0;
  int height = 0;
  /// 2 by #sites: the centres of the dots.
  Columns<Scalar> dots;
  double dot_radius = 0;
  Summary summary;
  /// Dots on pixels that are not dark at all, as between two letters, were moved to the nearest of
  /// their own points: how many, and how far at most, in pixels.
  Index put_back = 0;
  double farthest_put_back = 0;
};

/// How dark each pixel is, row by row: (1 - value)^gamma, or value^gamma when inverted. Values are
/// taken as stored, so that a picture looks as dark as its dots: a grey that is stored as 0.5 is
/// half covered with ink. Throws InvalidInput unless there is a value in [0, 1] for each pixel,
/// gamma is positive and finite, and `threads` (0: one per processor) is at most 4096.
CCVT_EXPORT std::vector<float> darkness(const Image& image, bool invert = false, double gamma = 1,
                                        int threads = 1);

/// Draws sites * points_per_site points from the darkness of `image` and tessellates them in
/// Euclidean space: the sites are the dots, but for those put back. Throws InvalidInput when no
/// pixel is dark, when `sites` is less than 1, and for bad options; Cancelled when the run is
/// cancelled before all points are drawn.
template <class Scalar = float>
CCVT_EXPORT Stippling<Scalar> stipple(const Image& image, Index sites,
                                      const StippleOptions& options = {});

/// The radius at which equal dots cover `ink` pixels of the picture, where overlapping dots count
/// once and what lies outside the picture not at all. A radius covers the places that are no
/// farther than that from their nearest dot, so it is a quantile of that distance over the picture,
/// measured on a raster of at most 8 million places. When dots cover too few of these, or lie
/// outside the picture, it is the radius for dots that do not overlap, sqrt(ink / (pi #dots)).
/// `dots`: 2 by #dots, finite, at least one. `ink`: in (0, width * height].
template <class Scalar>
CCVT_EXPORT double dot_radius_for(PointsView<Scalar> dots, int width, int height, double ink);
template <class Derived>
double dot_radius_for(const Eigen::DenseBase<Derived>& dots, int width, int height, double ink) {
  return dot_radius_for(view_points(dots), width, height, ink);
}

/// A stand-alone SVG document in pixel coordinates: one circle a dot on a white ground.
template <class Scalar>
CCVT_EXPORT void write_svg(const std::filesystem::path& path, const Stippling<Scalar>& stippling);

/// Draws the dots, antialiased, `scale` times the size of the picture. `scale` 0: as large as it
/// takes for dots of radius 3, but not below the picture's size nor beyond 33 million pixels.
/// Throws InvalidInput for a scale that is negative, not finite or makes more than 268435456
/// pixels.
template <class Scalar>
CCVT_EXPORT Image render(const Stippling<Scalar>& stippling, double scale = 0);

}  // namespace ccvt
