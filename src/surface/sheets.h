#pragma once

#include <cstdint>
#include <vector>

#include "ccvt/surface.h"
#include "parallel/stop.h"

namespace ccvt {

/// Which triangles hang together, and which of them face the other way.
struct Sheets {
  std::vector<Index> sheet;          ///< of each triangle, from 0; -1: it has no area
  std::vector<std::uint8_t> turned;  ///< not 0: the triangle faces the other way than its sheet
  Index count = 0;
};

/// Triangles hang together by edges that exactly two of them share; vertices at one place are one.
/// They are turned such that neighbours agree, as far as that is possible, and that less than half
/// of the area of a sheet is. `areas`: of each triangle; those without have no sheet, and no edges.
/// O((V + F) log(V + F)).
Sheets find_sheets(const TriangleMesh& mesh, const std::vector<double>& areas, Stop& stop);

}  // namespace ccvt
