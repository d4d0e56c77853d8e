#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace ccvt {

/// The cells of a grid of any shape in the order of a Hilbert curve: in a grid of equal powers of
/// two, each cell shares a face with the one before. Other grids take the part of the curve through
/// the least enclosing such grid that lies inside. Curves by Gray codes as in [Hamilton,
/// Rau-Chaplin 2008]; here each bit of a Gray code is one step of the recursion, so parts outside
/// are skipped as soon as one bit shows it, in any number of dimensions.
class HilbertCurve {
 public:
  /// Positive numbers of cells along each dimension, with a product below 2^63.
  explicit HilbertCurve(std::span<const std::int64_t> shape) {
    std::int64_t stride = 1;
    for (const std::int64_t cells : shape) {
      if (cells > 1) {
        axes_.push_back({cells, stride});
        bits_ = std::max(bits_,
                         static_cast<int>(std::bit_width(static_cast<std::uint64_t>(cells - 1))));
      }
      stride *= cells;
    }
    position_.resize(axes_.size());
  }

  /// Calls visit(index) once for every cell, where the first dimension varies fastest in `index`.
  /// O(1) amortised a cell for shapes that are not very long and thin.
  template <class Visit>
  void visit(const Visit& visit) {
    if (axes_.empty()) return visit(std::int64_t{0});
    std::fill(position_.begin(), position_.end(), 0);
    cube(bits_ - 1, 0, 0, 0, visit);
  }

 private:
  struct Axis {
    std::int64_t cells;
    std::int64_t stride;
  };

  // A cube in the curve's orientation: `entry` is the corner where the curve enters, and
  // `direction` gives the axis along which it leaves. Its subcubes differ in `bit` of the position.
  template <class Visit>
  void cube(int bit, std::uint64_t entry, unsigned direction, std::int64_t index,
            const Visit& visit) {
    subcubes(bit, entry, direction, static_cast<unsigned>(axes_.size()), 0, index, visit);
  }

  // The subcubes whose number along the curve starts with the bits in `prefix`; `left` bits follow.
  template <class Visit>
  void subcubes(int bit, std::uint64_t entry, unsigned direction, unsigned left,
                std::uint64_t prefix, std::int64_t index, const Visit& visit) {
    const auto dimensions = static_cast<unsigned>(axes_.size());
    if (left == 0) {
      if (bit == 0) return visit(index);
      const std::uint64_t corner = prefix == 0 ? 0 : gray((prefix - 1) & ~std::uint64_t{1});
      const std::uint64_t odd = (prefix & 1) != 0 ? prefix : prefix - 1;
      const unsigned turn =
          prefix == 0 ? 0 : static_cast<unsigned>(std::countr_one(odd)) % dimensions;
      cube(bit - 1, entry ^ rotate(corner, direction + 1), (direction + turn + 1) % dimensions,
           index, visit);
      return;
    }
    --left;
    const unsigned axis = (left + direction + 1) % dimensions;
    const std::uint64_t above = prefix & 1;
    const std::int64_t before = position_[axis];
    for (std::uint64_t next = 0; next < 2; ++next) {
      const std::uint64_t side = next ^ above ^ ((entry >> axis) & 1);
      const std::int64_t step = static_cast<std::int64_t>(side) << bit;
      if (before + step >= axes_[axis].cells) continue;
      position_[axis] = before + step;
      subcubes(bit, entry, direction, left, 2 * prefix + next, index + step * axes_[axis].stride,
               visit);
    }
    position_[axis] = before;
  }

  static std::uint64_t gray(std::uint64_t x) { return x ^ (x >> 1); }

  // Rotates a word of as many bits as there are axes to the left.
  [[nodiscard]] std::uint64_t rotate(std::uint64_t x, unsigned by) const {
    const auto bits = static_cast<unsigned>(axes_.size());
    by %= bits;
    if (by == 0) return x;
    return ((x << by) | (x >> (bits - by))) & ((std::uint64_t{1} << bits) - 1);
  }

  std::vector<Axis> axes_;  // those of more than one cell: fewer than 63
  int bits_ = 0;
  std::vector<std::int64_t> position_;
};

}  // namespace ccvt
