#pragma once

#include <span>
#include <vector>

#include "parallel/arena.h"
#include "surface/sheets.h"
#include "surface/triangles.h"

namespace ccvt {

/// Puts sites on the surface, and measures their cells: fills in all of `samples` that is given for
/// each site, from samples.owners, area and mass. `points` and `centroids` are relative to the
/// middle of the triangles, in three coordinates or more; `on`: the triangle that each point lies
/// on. A site goes to the nearest point of its points' triangles: of several, that of the lowest
/// number.
template <class Scalar>
void settle(const Triangles& triangles, const Sheets& sheets, PointsView<Scalar> points,
            std::span<const Index> on, PointsView<Scalar> centroids, const Arena& arena,
            SurfaceSamples& samples);

}  // namespace ccvt
