#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
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
        ++dimensions_;
        while ((cells - 1) >> bits_ > 0) ++bits_;
      }
      stride *= cells;
    }
    position_.resize(axes_.size());
  }

  /// A stretch of the curve: the cells in a cube of side 2^level, as far as they are in the grid.
  struct Part {
    std::int64_t index;  // of its lowest corner
    std::uint64_t entry;
    unsigned direction;
  };

  /// The parts of a level from 0 (single cells) up, in the order of the curve.
  [[nodiscard]] std::vector<Part> parts(int level) {
    if (level >= bits_) return {{0, 0, 0}};
    std::vector<Part> result;
    std::fill(position_.begin(), position_.end(), 0);
    cube(bits_ - 1, level, 0, 0, 0,
         [&](std::int64_t index, std::uint64_t prefix, std::uint64_t entry, unsigned direction) {
           const auto [inner, turned] = subcube(prefix, entry, direction);
           result.push_back({index, inner, turned});
         });
    return result;
  }

  /// Calls visit(index) once for every cell, where the first dimension varies fastest in `index`.
  /// O(1) amortised a cell for shapes that are not very long and thin.
  template <class Visit>
  void visit(const Visit& visit) {
    this->visit(Part{0, 0, 0}, bits_, visit);
  }
  /// The same for the cells of a part.
  template <class Visit>
  void visit(const Part& part, int level, const Visit& visit) {
    if (limited(level) == 0) return visit(part.index);
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      position_[a] = part.index / axes_[a].stride % axes_[a].cells;
    }
    cube(limited(level) - 1, 0, part.entry, part.direction, part.index,
         [&](std::int64_t index, std::uint64_t, std::uint64_t, unsigned) { visit(index); });
  }

  /// Axes of more than one cell.
  [[nodiscard]] unsigned dimensions() const { return dimensions_; }
  /// That of a part which is the whole curve, if `level` is above it.
  [[nodiscard]] int limited(int level) const { return std::min(level, bits_); }

  /// Calls visit(index, cells, place) for each row of adjacent cells of a part, in the order of
  /// memory; `place`: of the first of them, in that order, in a whole cube of side
  /// 2^limited(level).
  template <class Visit>
  void visit_rows(const Part& part, int level, const Visit& visit) const {
    visit_rows(part, 1, level, visit);
  }
  /// The same for so many parts, one behind the other along the first axis, as one.
  template <class Visit>
  void visit_rows(const Part& first, std::int64_t parts, int level, const Visit& visit) const {
    if (axes_.empty()) return visit(first.index, std::int64_t{1}, std::int64_t{0});
    rows({side(level), parts}, axes_.size() - 1, first.index, 0, visit);
  }
  /// Whether a part of a level lies behind another, along the first axis.
  [[nodiscard]] bool follows(const Part& part, const Part& other, int level) const {
    return !axes_.empty() && part.index - other.index == side(level) &&
           part.index % axes_[0].cells != 0;
  }
  /// How many cells a part of a level has.
  [[nodiscard]] std::int64_t cells(const Part& part, int level) const {
    std::int64_t cells = 1;
    for (const Axis& axis : axes_) cells *= count(axis, side(level), part.index);
    return cells;
  }
  /// The cell at a place, in the order of memory, of the cube that is a part of a level.
  [[nodiscard]] std::int64_t cell(const Part& part, int level, std::int64_t place) const {
    std::int64_t cell = part.index;
    for (const Axis& axis : axes_) {
      cell += place % side(level) * axis.stride;
      place /= side(level);
    }
    return cell;
  }

 private:
  struct Axis {
    std::int64_t cells;
    std::int64_t stride;
  };

  [[nodiscard]] std::int64_t side(int level) const { return std::int64_t{1} << limited(level); }

  // Of cells along an axis, `most` or as many as there are.
  static std::int64_t count(const Axis& axis, std::int64_t most, std::int64_t index) {
    return std::min(most, axis.cells - index / axis.stride % axis.cells);
  }

  struct Cubes {
    std::int64_t side;
    std::int64_t along_first;
  };

  template <class Visit>
  void rows(const Cubes& cubes, std::size_t a, std::int64_t index, std::int64_t place,
            const Visit& visit) const {
    const Axis& axis = axes_[a];
    if (a == 0) return visit(index, count(axis, cubes.side * cubes.along_first, index), place);
    const std::int64_t rows_here = count(axis, cubes.side, index);
    for (std::int64_t i = 0; i < rows_here; ++i) {
      rows(cubes, a - 1, index + i * axis.stride, (place + i) * cubes.side, visit);
    }
  }

  // A cube in the curve's orientation: `entry` is the corner where the curve enters, and
  // `direction` gives the axis along which it leaves. Its subcubes differ in `bit` of the position.
  // Those of bit `last` are the leaves: leaf(index, number along the curve, entry, direction).
  template <class Leaf>
  void cube(int bit, int last, std::uint64_t entry, unsigned direction, std::int64_t index,
            const Leaf& leaf) {
    subcubes(bit, last, entry, direction, dimensions_, 0, index, leaf);
  }

  // The subcubes whose number along the curve starts with the bits in `prefix`; `left` bits follow.
  template <class Leaf>
  void subcubes(int bit, int last, std::uint64_t entry, unsigned direction, unsigned left,
                std::uint64_t prefix, std::int64_t index, const Leaf& leaf) {
    if (left == 0) {
      if (bit == last) return leaf(index, prefix, entry, direction);
      const auto [inner, turned] = subcube(prefix, entry, direction);
      return cube(bit - 1, last, inner, turned, index, leaf);
    }
    --left;
    const unsigned axis = (left + direction + 1) % dimensions_;
    const std::uint64_t above = prefix & 1;
    const std::int64_t half = std::int64_t{1} << bit;
    const std::int64_t before = position_[axis];
    for (std::uint64_t next = 0; next < 2; ++next) {
      const std::uint64_t side = next ^ above ^ ((entry >> axis) & 1);
      const std::int64_t step = side == 0 ? 0 : half;
      if (before + step >= axes_[axis].cells) continue;
      position_[axis] = before + step;
      subcubes(bit, last, entry, direction, left, 2 * prefix + next,
               index + step * axes_[axis].stride, leaf);
    }
    position_[axis] = before;
  }

  // The orientation of the subcube of that number along the curve.
  [[nodiscard]] std::pair<std::uint64_t, unsigned> subcube(std::uint64_t number,
                                                           std::uint64_t entry,
                                                           unsigned direction) const {
    const std::uint64_t corner = number == 0 ? 0 : gray((number - 1) & ~std::uint64_t{1});
    const std::uint64_t odd = (number & 1) != 0 ? number : number - 1;
    const unsigned turn =
        number == 0 ? 0 : static_cast<unsigned>(std::countr_one(odd)) % dimensions_;
    return {entry ^ rotate(corner, direction + 1), (direction + turn + 1) % dimensions_};
  }

  static std::uint64_t gray(std::uint64_t x) { return x ^ (x >> 1); }

  // Rotates a word of as many bits as there are axes to the left.
  [[nodiscard]] std::uint64_t rotate(std::uint64_t x, unsigned by) const {
    by %= dimensions_;
    if (by == 0) return x;
    return ((x << by) | (x >> (dimensions_ - by))) & ((std::uint64_t{1} << dimensions_) - 1);
  }

  std::vector<Axis> axes_;  // those of more than one cell: fewer than 63
  unsigned dimensions_ = 0;
  int bits_ = 0;
  std::vector<std::int64_t> position_;
};

}  // namespace ccvt
