#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "ccvt/surface.h"
#include "normalize.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "point_count.h"
#include "surface/draw.h"
#include "surface/settle.h"
#include "surface/sheets.h"
#include "surface/triangles.h"
#include "surface/turns.h"

namespace ccvt {

namespace {

/// Sheets of fewer cells have none of their own.
constexpr double kLeastCells = 8;

/// The area of each triangle, and its integral of the density.
struct Sizes {
  std::vector<double> areas;
  std::vector<double> masses;
  double area = 0;
  double mass = 0;
};

Sizes measure(const Triangles& triangles, const Arena& arena) {
  constexpr std::size_t kGrain = std::size_t{1} << 12;
  Sizes sizes;
  sizes.areas.resize(triangles.count());
  sizes.masses.resize(triangles.count());
  arena.for_each(triangles.count(), kGrain, [&](std::size_t t) {
    const auto triangle = static_cast<Index>(t);
    if (!triangles.has_area(triangle)) return;
    sizes.areas[t] = area_vector(triangles.corners(triangle)).norm() / 2;
    sizes.masses[t] = sizes.areas[t] * triangles.densities(triangle).mean();
  });
  const auto sum = [&](const std::vector<double>& values) {
    return sum_of(arena, values.size(), kGrain, [&](std::size_t t) { return values[t]; });
  };
  sizes.area = sum(sizes.areas);
  sizes.mass = sum(sizes.masses);
  if (!(sizes.area > 0)) {
    throw InvalidInput(
        concat("mesh: none of its ", triangles.count(), " triangles has an area; needs one"));
  }
  if (!(sizes.mass > 0) || !std::isfinite(sizes.mass)) {
    throw InvalidInput(concat("mesh: the integral of the density over the surface is ", sizes.mass,
                              "; must be positive and finite"));
  }
  return sizes;
}

/// The points as they are tessellated, and what is known of them.
template <class Scalar>
struct Drawn {
  Points<Scalar> lifted;
  std::vector<Index> triangles;
  std::vector<Index> groups;
};

/// `cell`: the mass of one. Spacing is that of the cell's own place, and never more than the
/// extent of the surface.
template <class Scalar>
Drawn<Scalar> draw(const Triangles& triangles, const Sheets& sheets, const TriangleLine& line,
                   Index count, double cell, double weight, std::uint64_t seed,
                   const Arena& arena) {
  const double most = triangles.extent().maxCoeff();
  Drawn<Scalar> drawn;
  drawn.lifted.resize(weight > 0 ? 6 : 3, count);
  drawn.triangles.resize(static_cast<std::size_t>(count));
  drawn.groups.resize(static_cast<std::size_t>(count));
  const SurfaceDraws draws(triangles, line, count, seed);
  draws.visit(arena, [&](std::size_t number, const SurfacePoint& point) {
    const Eigen::Matrix3d corners = triangles.corners(point.triangle);
    auto column = drawn.lifted.col(static_cast<Eigen::Index>(number));
    column.template head<3>() = (corners * point.shares).template cast<Scalar>();
    if (weight > 0) {
      const double density = triangles.densities(point.triangle).dot(point.shares);
      const double spacing = std::min(std::sqrt(cell / density), most);
      const double side = sheets.turned[static_cast<std::size_t>(point.triangle)] != 0 ? -1 : 1;
      column.template tail<3>() =
          (side * weight * spacing * area_vector(corners).normalized()).template cast<Scalar>();
    }
    drawn.triangles[number] = point.triangle;
    drawn.groups[number] = point.group;
  });
  return drawn;
}

template <class Scalar>
SurfaceSamples sample(const TriangleMesh& mesh, Index sites, const SurfaceOptions& options) {
  mesh.validate();
  options.validate();
  const Index count = checked_point_count(sites, options.points_per_site);
  const int threads = options.tessellation.threads;
  Stop stop(options.tessellation.cancelled);
  const Triangles triangles(mesh);
  const double drawn_weight =
      options.normal_weight > 0 ? std::max(options.normal_weight, kFirstWeight) : 0;
  SurfaceSamples samples;
  Sheets sheets;
  Drawn<Scalar> drawn;
  {
    const Arena arena(threads, &stop);
    const Sizes sizes = measure(triangles, arena);
    sheets = find_sheets(mesh, sizes.areas, stop);
    samples.area = sizes.area;
    samples.mass = sizes.mass;
    const double cell = sizes.mass / sites;
    const TriangleLine line = line_up(triangles, sheets, sizes.masses, kLeastCells * cell);
    drawn = draw<Scalar>(triangles, sheets, line, count, cell, drawn_weight,
                         options.tessellation.seed, arena);
  }
  const double shrink = drawn_weight > 0 ? options.normal_weight / drawn_weight : 1;
  Outcome<Scalar> outcome =
      tessellate_in_turns(drawn.lifted, drawn.groups, sites, shrink, options.tessellation);

  samples.scalar = sizeof(Scalar) == sizeof(float) ? ScalarType::float32 : ScalarType::float64;
  samples.summary = std::move(outcome.summary);
  count_normals(samples.summary.dimension - 3, samples.summary);
  samples.sheets = sheets.count;
  samples.turned = static_cast<Index>(
      std::count_if(sheets.turned.begin(), sheets.turned.end(), [](auto t) { return t != 0; }));
  samples.owners = std::move(outcome.owners);
  settle(triangles, sheets, view_points(drawn.lifted), drawn.triangles, view_points(outcome.sites),
         Arena(threads), samples);
  if (!options.keep_points) {
    samples.owners = {};
    return samples;
  }
  samples.points =
      drawn.lifted.template topRows<3>().template cast<double>().colwise() + triangles.middle();
  samples.point_triangles = std::move(drawn.triangles);
  return samples;
}

}  // namespace

template <class Scalar>
SurfaceSamples sample_surface(const TriangleMesh& mesh, Index sites,
                              const SurfaceOptions& options) try {
  return sample<Scalar>(mesh, sites, options);
} catch (const Stopped&) {
  throw Cancelled();
}

template CCVT_EXPORT SurfaceSamples sample_surface<float>(const TriangleMesh&, Index,
                                                          const SurfaceOptions&);
template CCVT_EXPORT SurfaceSamples sample_surface<double>(const TriangleMesh&, Index,
                                                           const SurfaceOptions&);

}  // namespace ccvt
