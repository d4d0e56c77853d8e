#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt::io {

/// Divides a polygon into triangles on its side of its border, where the fan around its first
/// corner would have some on the other side: by cutting off one corner after the other whose
/// triangle holds no other corner [Meisters 1975]. `face`: three corners or more of a polygon that
/// is about flat and does not cross itself, numbers of vertices, of which `coordinates` are three
/// each. Three corners for each of #corners - 2 triangles, which have the polygon's area together;
/// none where the fan is as good, or where none are found. O(#corners^2) as a rule.
std::vector<Index> divide_concave(std::span<const Index> face, std::span<const double> coordinates);

}  // namespace ccvt::io
