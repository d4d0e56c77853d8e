#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

/// A spanning tree of the part of a graph of sites that is connected with site 0, its root. Breadth
/// first inside the connected parts of blocks of consecutive nodes, which are done at the same
/// time.
class SpanningTree {
 public:
  SpanningTree() = default;
  /// `neighbours` of each node. O(nodes + edges).
  SpanningTree(const Groups<SiteNumber>& neighbours, const Arena& arena);

  /// Nodes in the tree.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Of the root none(), of a site that is not in the tree no site's number either.
  [[nodiscard]] SiteNumber parent(SiteNumber site) const { return parent_[site]; }
  /// The nodes of the tree, each after its parent.
  [[nodiscard]] std::vector<SiteNumber> order() const;

  /// Adds to the value of each node those of all below it. O(nodes).
  void add_subtrees(std::span<std::int64_t> values, const Arena& arena) const;

 private:
  /// Part of the tree within a block: entered through its first node. A parent comes before.
  struct Part {
    std::size_t begin = 0;  ///< of its nodes, in order_
    std::size_t end = 0;
    std::size_t parent = 0;
  };

  std::vector<SiteNumber> parent_;
  Buffer<SiteNumber> order_;  ///< by part
  std::vector<Part> parts_;
  std::size_t size_ = 0;
};

}  // namespace ccvt
