#include "ccvt/domain.h"

#include <cmath>
#include <string>
#include <utility>

#include "ccvt/types.h"
#include "number_text.h"

namespace ccvt {

Domain::Domain(Box box, bool periodic) : box_(std::move(box)), periodic_(periodic) {
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

Domain Domain::euclidean(Box box) { return {std::move(box), false}; }

Domain Domain::periodic(Box box) { return {std::move(box), true}; }

}  // namespace ccvt
