#pragma once

#include <vector>

#include "ccvt/types.h"
#include "relax/cells.h"

namespace ccvt {

/// Cells that are being filled with points. A site may take more points than its cell has room
/// for; those are its excess, and must move on before the tessellation is complete.
template <class Scalar>
struct Filling {
  Filling(Cells<Scalar>& target, const PointsView<Scalar>& all_points)
      : cells(target),
        points(all_points),
        filled(static_cast<std::size_t>(target.site_count()), 0),
        excess(static_cast<std::size_t>(target.site_count())) {}

  /// Takes over the points of a cell; the site must have none yet, and room for all of them.
  void add_cell(const Cells<Scalar>& from, Index site) {
    cells.copy_points(from, site);
    filled[static_cast<std::size_t>(site)] = from.size(site);
  }

  void add(Index site, Index point) {
    Index& count = filled[static_cast<std::size_t>(site)];
    if (count < cells.size(site)) {
      cells.put(site, count++, point, points[point]);
    } else {
      excess[static_cast<std::size_t>(site)].push_back(point);
    }
  }

  /// Takes the point at place k out of a cell; the last point takes its place.
  Index take(Index site, Index k) {
    Index& count = filled[static_cast<std::size_t>(site)];
    const Index point = cells.points(site)[k];
    --count;
    if (k != count) cells.copy_within(site, count, k);
    return point;
  }

  /// Moves as much of a site's excess into its cell as there is room for.
  void settle(Index site) {
    auto& waiting = excess[static_cast<std::size_t>(site)];
    Index& count = filled[static_cast<std::size_t>(site)];
    while (!waiting.empty() && count < cells.size(site)) {
      cells.put(site, count++, waiting.back(), points[waiting.back()]);
      waiting.pop_back();
    }
  }

  /// Points of a site beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(Index site) const {
    const auto s = static_cast<std::size_t>(site);
    return filled[s] + static_cast<Index>(excess[s].size()) - cells.size(site);
  }

  Cells<Scalar>& cells;
  const PointsView<Scalar>& points;
  std::vector<Index> filled;               ///< points in each cell
  std::vector<std::vector<Index>> excess;  ///< points of each site that its cell has no room for
};

}  // namespace ccvt
