#include "ccvt/domain.h"

#include <cmath>
#include <string>
#include <utility>

#include "ccvt/types.h"
#include "number_text.h"

namespace ccvt {

Domain::Domain(Box box, std::vector<bool> periodic)
    : box_(std::move(box)), periodic_(std::move(periodic)) {
  if (box_.lower.size() != box_.upper.size() || box_.lower.size() == 0) {
    throw InvalidInput("box: the lower corner has " + std::to_string(box_.lower.size()) +
                       " coordinates and the upper one " + std::to_string(box_.upper.size()) +
                       ": both need one per dimension");
  }
  for (std::ptrdiff_t d = 0; d < box_.lower.size(); ++d) {
    const double extent = box_.upper[d] - box_.lower[d];
    if (!(extent > 0) || !std::isfinite(extent)) {
      throw InvalidInput("box: dimension " + std::to_string(d) + " runs from " +
                         text(box_.lower[d]) + " to " + text(box_.upper[d]) +
                         ": the extent must be positive and finite");
    }
  }
}

Domain Domain::euclidean(Box box) {
  std::vector<bool> along(static_cast<std::size_t>(box.lower.size()), false);
  return {std::move(box), std::move(along)};
}

Domain Domain::periodic(Box box) {
  std::vector<bool> along(static_cast<std::size_t>(box.lower.size()), true);
  return {std::move(box), std::move(along)};
}

Domain Domain::periodic(Box box, const std::vector<bool>& along) {
  if (std::ssize(along) != box.lower.size()) {
    throw InvalidInput("along: has " + std::to_string(along.size()) + " entries, the box " +
                       std::to_string(box.lower.size()) +
                       " dimensions: there must be one for each");
  }
  return {std::move(box), along};
}

}  // namespace ccvt
