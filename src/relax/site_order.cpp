#include "relax/site_order.h"

#include <algorithm>
#include <numeric>

namespace ccvt {

std::vector<Index> spatial_order(const std::vector<double>& positions, int dimension,
                                 Index tile_sites) {
  std::vector<Index> order(positions.size() / static_cast<std::size_t>(dimension));
  std::iota(order.begin(), order.end(), 0);
  const auto coordinate = [&](Index site, int d) {
    return positions[static_cast<std::size_t>(site) * static_cast<std::size_t>(dimension) +
                     static_cast<std::size_t>(d)];
  };
  const auto bisect = [&](auto& self, std::size_t begin, std::size_t end) -> void {
    const auto tile = static_cast<std::size_t>(tile_sites);
    if (end - begin <= tile) return;
    int widest = 0;
    double width = -1;
    for (int d = 0; d < dimension; ++d) {
      double low = coordinate(order[begin], d);
      double high = low;
      for (std::size_t k = begin + 1; k < end; ++k) {
        low = std::min(low, coordinate(order[k], d));
        high = std::max(high, coordinate(order[k], d));
      }
      if (high - low > width) {
        width = high - low;
        widest = d;
      }
    }
    const std::size_t tiles = (end - begin + tile - 1) / tile;
    const std::size_t middle = begin + tiles / 2 * tile;
    const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(begin), at(middle), at(end), [&](Index a, Index b) {
      const double x = coordinate(a, widest);
      const double y = coordinate(b, widest);
      return x != y ? x < y : a < b;
    });
    self(self, begin, middle);
    self(self, middle, end);
  };
  bisect(bisect, 0, order.size());
  return order;
}

}  // namespace ccvt
