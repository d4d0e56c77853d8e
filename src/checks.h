#pragma once

#include <memory>
#include <string>

#include "ccvt/domain.h"
#include "ccvt/types.h"

namespace ccvt {

/// Throws InvalidInput, which begins with `name`, unless a value that may have been made of any
/// number is one of an enumeration's, from 0 to `last`.
template <class Enum>
void require_enumerator(const std::string& name, Enum value, Enum last) {
  const auto number = static_cast<long long>(value);
  if (number >= 0 && number <= static_cast<long long>(last)) return;
  throw InvalidInput(name + " is " + std::to_string(number) +
                     ": it must be one of the enumerators");
}

/// Throws InvalidInput, which begins with `name`, unless points can be read through the view.
template <class Scalar>
void require_data(const std::string& name, const PointsView<Scalar>& points) {
  if (points.count > 0 && points.data == nullptr) {
    throw InvalidInput(name + ": the view has no data");
  }
  if (points.dimension > 1 && points.count > 1 && points.stride < points.dimension) {
    throw InvalidInput(name + ": the stride is " + std::to_string(points.stride) +
                       ": it must be at least the dimension, " + std::to_string(points.dimension));
  }
}

/// Throws InvalidInput where an object has no implementation, since it was moved from.
template <class Implementation>
Implementation& whole(const char* name, const std::unique_ptr<Implementation>& implementation) {
  if (implementation == nullptr) throw InvalidInput(std::string(name) + ": was moved from");
  return *implementation;
}

/// Throws InvalidInput unless both corners have as many dimensions.
inline void require_corners(const Box& box) {
  if (box.lower.size() == box.upper.size()) return;
  throw InvalidInput("box: lower has " + std::to_string(box.lower.size()) +
                     " dimensions and upper has " + std::to_string(box.upper.size()) +
                     ", but both must have the same number");
}

}  // namespace ccvt
