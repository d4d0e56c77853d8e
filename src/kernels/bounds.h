#pragma once

#include "ccvt/types.h"

/// Bounds of a cell for one site after the other, compiled for each instruction set and chosen at
/// run time. Callers allow for rounding.
namespace ccvt::kernels {

/// Of sites that moved: bound[k] grows by shift[k] + scale * dot[k] - reach * length[k] - growth,
/// and is less than that by what rounding does to these terms.
struct BoundChange {
  double scale;
  double reach;
  double growth;
};
void change_bounds(const float* dot, const double* shift, const double* length, Index count,
                   const BoundChange& change, double* bound);

/// Those k < count, ascending, where bound[k] + own - weight[k] is not above zero, by more than
/// rounding does to these terms; returns how many there are. `places` has room for `count`.
Index bounds_within(const double* bound, const double* weight, double own, Index count,
                    Index* places);

}  // namespace ccvt::kernels
