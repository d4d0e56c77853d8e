#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/loops.h"

namespace ccvt {

/// A spanning tree of the part of a graph that is connected with node 0, its root. Breadth first
/// inside the connected parts of blocks of consecutive nodes, which are done at the same time.
class SpanningTree {
 public:
  SpanningTree() = default;
  /// `neighbours` of each node. O(nodes + edges).
  SpanningTree(const Groups<Index>& neighbours, const Arena& arena);

  /// Nodes in the tree.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Of the root -1, of a node that is not in the tree less.
  [[nodiscard]] Index parent(Index node) const { return parent_[static_cast<std::size_t>(node)]; }
  /// The nodes of the tree, each after its parent.
  [[nodiscard]] std::vector<Index> order() const;

  /// Adds to the value of each node those of all below it. O(nodes).
  void add_subtrees(std::span<std::int64_t> values, const Arena& arena) const;

 private:
  /// Part of the tree within a block: entered through its first node. A parent comes before.
  struct Part {
    std::size_t begin = 0;  ///< of its nodes, in order_
    std::size_t end = 0;
    std::size_t parent = 0;
  };

  std::vector<Index> parent_;
  Buffer<Index> order_;  ///< by part
  std::vector<Part> parts_;
  std::size_t size_ = 0;
};

}  // namespace ccvt
