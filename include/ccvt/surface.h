#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/io.h"
#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// A surface made of triangles, in three dimensions. It need be neither closed nor a manifold:
/// triangles may be slivers or without area (nothing is put on those), vertices may lie on each
/// other, and any number of triangles may share an edge.
struct CCVT_EXPORT TriangleMesh {
  /// 3 by #vertices.
  Columns<double> vertices;
  /// 3 by #triangles: the numbers of the corners, from 0; seen from outside, counter-clockwise.
  Columns<Index> triangles;
  /// How dense samples are at each vertex, linear over triangles. Empty: the same everywhere.
  std::vector<double> density;

  /// Throws InvalidInput, naming the first that is wrong, unless there are vertices and triangles,
  /// coordinates are finite, corners are numbers of vertices, densities are finite, not negative
  /// and one for each vertex, and the surface extends over 1e-25 to 1e15. O(V + F).
  void validate() const;
};

/// Reads a mesh, told by the extension:
///
///   .ply  ascii or binary of either byte order: x, y, z of the element `vertex`, and the list
///         vertex_indices, or vertex_index, of the element `face`. Other elements and properties
///         are skipped. `density`: the vertex property that is the density.
///   .obj  Lines `v x y z`, and `f` with corners i, i/j, i//k or i/j/k, of which i counts, from 1
///   or
///         from the last vertex back; '#' starts a comment, a backslash at the end of a line
///         continues it. Other lines are skipped. `density`: red, green or blue, the colours
///         that all vertices then must have (`v x y z red green blue`).
///
/// A face of more than three corners becomes a fan of triangles around its first one or, where some
/// of these would lie outside, as in a concave face, others that fill it; the fan still where it
/// crosses itself, or has so many corners that these would take minutes to find. Throws
/// InvalidInput, with one line that names file and rule, for files that are truncated, damaged or
/// hold no triangle, and for what TriangleMesh::validate() refuses; IoError when the system
/// refuses.
CCVT_EXPORT TriangleMesh read_mesh(const std::filesystem::path& path,
                                   const std::string& density = "");

/// How a surface becomes samples.
struct CCVT_EXPORT SurfaceOptions {
  /// Points drawn on the surface for each site. At least 1.
  Index points_per_site = 256;
  /// The points that are tessellated have six coordinates: where they are, and the normal of their
  /// triangle times `normal_weight` times the local spacing of the sites, the square root of a
  /// cell's area. So sheets that lie near each other, or on each other, but face apart, are far
  /// apart, and share no cell. On a smooth surface the normal changes little over a cell, and so
  /// does this. From .5 on cells of
  /// usual shape gain nothing by an exchange with one that faces the other way. Weights below 2 are
  /// come to by way of 2, with which cells become full of points of one side. 0: positions alone.
  /// Not negative, at most 100.
  double normal_weight = 0.5;
  /// Whether SurfaceSamples hold the points that were drawn, their triangles and their owners.
  bool keep_points = false;
  /// Its seed also fixes the points that are drawn, and its threads draw them. Where sheets are
  /// tessellated by themselves first, max_iterations is that of each, and then of all together.
  /// Until blue_noise, as samples are wanted irregular.
  Options tessellation = Options::samples();

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// Samples that spread evenly over a surface.
struct SurfaceSamples {
  /// 3 by #sites: on the surface. Site s is the sum of barycentric(i, s) times corner i of the
  /// triangle triangles[s].
  Columns<double> sites;
  std::vector<Index> triangles;
  /// 3 by #sites, not negative, of sum 1.
  Columns<double> barycentric;
  /// 3 by #sites: unit normals of those triangles, to the side from which they are
  /// counter-clockwise, or most triangles of their sheet are: see `turned`.
  Columns<double> normals;
  /// How many points each site owns.
  std::vector<Index> capacities;
  /// The mass of each cell: its share of the points times the integral of the density (of 1, where
  /// there is none: the area). The sum over sites of weight * f(site) approximates the integral of
  /// density * f over the surface.
  std::vector<double> weights;
  /// The local spacing, sqrt(2 * mean |p - c|^2) over the points p of a cell with the centroid c:
  /// of a flat disk with uniform points it is the radius.
  std::vector<double> radii;
  /// Of all triangles, and the integral of the density over them.
  double area = 0;
  double mass = 0;
  /// A sheet is what hangs together by edges that two triangles share, vertices at the same place
  /// being one. With a normal_weight, sheets of eight cells and more get whole numbers of sites and
  /// are tessellated by themselves first, so that cells of different sheets mix only where that
  /// lowers the energy; capacities of different sheets then differ: those of a sheet, but for whole
  /// points, by a share of less than 1 / #sites of the sheet from points_per_site. All smaller
  /// sheets together are treated as one, or, where they do not come to a site, as a part of the
  /// last of the others, which may then differ by as much again.
  Index sheets = 0;
  /// Triangles that face the other way than most, by area, of their sheet: their normals are those
  /// of the rest. A sheet with one side only, such as a Möbius strip, keeps a seam.
  Index turned = 0;
  /// Centroids of bent cells lie beside the surface: each was put on the nearest point of the
  /// triangles that its own points lie on, and that far at most. Summary and radii describe the
  /// centroids.
  double farthest_moved = 0;
  /// With SurfaceOptions::keep_points only: 3 by #points, the triangle that each lies on, and the
  /// site that owns it. 32 bytes a point.
  Columns<double> points;
  std::vector<Index> point_triangles;
  std::vector<Index> owners;
  /// What was computed in.
  ScalarType scalar = ScalarType::float32;
  /// Of the tessellation in six dimensions, or three where normal_weight is 0; where that took two
  /// turns, of the second, but for seconds_total.
  Summary summary;
};

/// Draws sites * points_per_site points on the surface, by area times density, and tessellates
/// them. Points are stratified: triangles are lined up along a Hilbert curve, large ones are halved
/// along their longest edges until a part holds no more than about one point, and one point is
/// drawn, exactly by the density, from each of as many parts of equal mass of that line. Computes
/// in Scalar, relative to the middle of the surface: how far that is from the origin does not
/// matter.
///
/// Time: that of tessellate(), and O((V + F) log(V + F)) for V vertices and F triangles. Memory,
/// beside the mesh: about 4 times the coordinates of the points, six each, and 80 bytes a triangle.
/// Throws InvalidInput for what validate() refuses, when no triangle has an area and a density,
/// when `sites` is less than 1, and for bad options; Cancelled when the run is cancelled before all
/// points are drawn.
template <class Scalar = float>
CCVT_EXPORT SurfaceSamples sample_surface(const TriangleMesh& mesh, Index sites,
                                          const SurfaceOptions& options = {});

/// Writes samples by extension, as those of a volume are, see volume.h, with more columns:
///
///   .ply              x, y, z, nx, ny, nz, radius, capacity, weight, triangle, u, v
///   .vtp, .vtk        points with the arrays normal, radius, capacity, weight, triangle, uv
///   .csv, .txt        the columns of .ply
///   .npy              the sites alone, (#sites, 3), float64
///
/// u and v are the barycentric coordinates of the second and the third corner. Throws InvalidInput
/// when there are no samples, or not as many of all.
CCVT_EXPORT void write_samples(const std::filesystem::path& path, const SurfaceSamples& samples);

/// A picture of the surface, shaded, seen from the right, in front and above, with the samples that
/// can be seen on it. `size`: of its longest side, in pixels, from 16 to 4096. `up`: the dimension
/// that points up, 0 to 2; the one after it, and x after z, points to the right, and the third one
/// to the back: with 2 x to the right and y to the back, with 1 z to the right and x to the back.
/// Throws InvalidInput for other sizes and dimensions, for what validate() refuses, and for samples
/// that are not finite, or not as many of all.
CCVT_EXPORT ColourImage preview(const TriangleMesh& mesh, const SurfaceSamples& samples,
                                int size = 720, int up = 2);

}  // namespace ccvt
