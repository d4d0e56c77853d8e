#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace ccvt::io {

/// How a picture lies in its file, as the Exif tag Orientation has it [CIPA DC-008, 4.6.5]: where
/// its first row and its first column are when it is upright.
class Orientation {
 public:
  /// Upright.
  Orientation() = default;
  /// Of Exif data: a TIFF header, as a chunk of PNG has it, or "Exif", two zeros and that, as a
  /// segment of JPEG does. Upright where these do not say.
  explicit Orientation(std::span<const unsigned char> exif);

  [[nodiscard]] bool upright() const { return tag_ == 1; }

  /// The pixels of a picture, row by row and of so many values each, as they are when it is
  /// upright; so are then its width and height.
  template <class Value, class Size>
  [[nodiscard]] std::vector<Value> turned(const std::vector<Value>& values, std::size_t per_pixel,
                                          Size& width, Size& height) const {
    const bool on_side = tag_ >= 5;
    const bool from_right = tag_ == 2 || tag_ == 3 || tag_ == 7 || tag_ == 8;
    const bool from_below = tag_ == 3 || tag_ == 4 || tag_ == 6 || tag_ == 7;
    const auto columns = static_cast<std::size_t>(width);
    const auto rows = static_cast<std::size_t>(height);
    if (on_side) std::swap(width, height);
    std::vector<Value> result;
    result.reserve(values.size());
    for (std::size_t y = 0; y < (on_side ? columns : rows); ++y) {
      for (std::size_t x = 0; x < (on_side ? rows : columns); ++x) {
        const std::size_t column = on_side ? y : x;
        const std::size_t row = on_side ? x : y;
        const std::size_t at = (from_below ? rows - 1 - row : row) * columns +
                               (from_right ? columns - 1 - column : column);
        for (std::size_t k = 0; k < per_pixel; ++k) result.push_back(values[at * per_pixel + k]);
      }
    }
    return result;
  }

 private:
  int tag_ = 1;
};

}  // namespace ccvt::io
