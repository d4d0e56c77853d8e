#pragma once

namespace ccvt {

/// Of a double: the largest relative error of one rounding.
constexpr double kHalfUlp = 0x1p-53;

}  // namespace ccvt
