#include "cli/blocks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ccvt::cli {

namespace {

/// Calls visit(value of the picture, block, value of the block) for all values of all blocks.
template <class Visit>
void for_values(int width, int height, int side, Visit visit) {
  const int across = (width + side - 1) / side;
  const int down = (height + side - 1) / side;
  Eigen::Index block = 0;
  for (int row = 0; row < down; ++row) {
    for (int column = 0; column < across; ++column, ++block) {
      Eigen::Index value = 0;
      for (int y = row * side; y < (row + 1) * side; ++y) {
        for (int x = column * side; x < (column + 1) * side; ++x) {
          const std::ptrdiff_t above = std::min(y, height - 1);
          const std::ptrdiff_t pixel = above * width + std::min(x, width - 1);
          for (int c = 0; c < 3; ++c) {
            visit(3 * pixel + c, block, value++, x < width && y < height);
          }
        }
      }
    }
  }
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0) + 0.5);
}

}  // namespace

Points<float> blocks_of(const ColourImage& image, int side) {
  if (side > image.width || side > image.height) {
    throw InvalidInput("blocks of " + std::to_string(side) + " x " + std::to_string(side) +
                       " pixels do not fit into " + std::to_string(image.width) + " x " +
                       std::to_string(image.height));
  }
  const Eigen::Index across = (image.width + side - 1) / side;
  const Eigen::Index down = (image.height + side - 1) / side;
  Points<float> blocks(Eigen::Index{3} * side * side, across * down);
  for_values(image.width, image.height, side,
             [&](std::ptrdiff_t from, Eigen::Index block, Eigen::Index value, bool) {
               blocks(value, block) = image.rgb.data()[from];
             });
  return blocks;
}

ColourImage picture_of(const Points<double>& blocks, int width, int height, int side) {
  const std::int64_t pixels = std::int64_t{width} * height;
  ColourImage image{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * pixels))};
  for_values(width, height, side,
             [&](std::ptrdiff_t to, Eigen::Index block, Eigen::Index value, bool inside) {
               if (inside) image.rgb.data()[to] = to_byte(blocks(value, block));
             });
  return image;
}

double peak_signal_to_noise(const ColourImage& a, const ColourImage& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.rgb.size(); ++k) {
    sum += std::pow(a.rgb[k] - b.rgb[k], 2);
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.rgb.size()) / sum);
}

}  // namespace ccvt::cli
