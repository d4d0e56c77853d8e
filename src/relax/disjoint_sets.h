#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace ccvt {

/// Sets of things with numbers, each alone at first.
template <class Number>
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), Number(0));
  }
  /// Whether a and b were apart.
  bool join(Number a, Number b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    parent_[std::max(a, b)] = std::min(a, b);
    return true;
  }

  /// The lowest of the set that a is in.
  Number root(Number a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }

 private:
  std::vector<Number> parent_;
};

}  // namespace ccvt
