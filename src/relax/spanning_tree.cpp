#include "relax/spanning_tree.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace ccvt {
namespace {

constexpr std::size_t kBlock = 1024;
/// Who is the parent of the root, and of a site that is in no part yet.
constexpr SiteNumber kRoot = SiteNumber::none();
constexpr SiteNumber kOutside(-2);
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// Some nodes of one block, in a run of the order.
struct Run {
  std::size_t begin;
  std::size_t end;
};

/// An edge into another part.
struct Border {
  SiteNumber from;
  SiteNumber to;
};

struct TreeBuilder {
  TreeBuilder(const Groups<SiteNumber>& graph, const Arena& workers)
      : neighbours(graph),
        arena(workers),
        parent(graph.count(), kOutside),
        order(graph.count()),
        part_in_block(graph.count()),
        parts_before((graph.count() + kBlock - 1) / kBlock + 1, 0) {}

  /// Goes breadth first through the part of node order[begin], in its block; returns its end.
  std::size_t search(std::size_t begin) {
    const std::size_t block = order[begin] / kBlock;
    std::size_t end = begin + 1;
    for (std::size_t next = begin; next < end; ++next) {
      for (const SiteNumber t : neighbours[order[next]]) {
        if (t / kBlock != block || parent[t] != kOutside) continue;
        parent[t] = order[next];
        order[end++] = t;
      }
    }
    return end;
  }

  /// The connected parts of all blocks; that of node 0 is the first.
  Buffer<Run> find_parts() {
    Buffer<Run> parts =
        collect<Run>(arena, parent.size(), kBlock,
                     [&](std::size_t begin, std::size_t end, std::vector<Run>& out, int) {
                       std::size_t& count = parts_before[begin / kBlock];
                       std::size_t place = begin;
                       for (std::size_t s = begin; s < end; ++s) {
                         if (parent[s] != kOutside) continue;
                         parent[s] = kRoot;
                         order[place] = SiteNumber(s);
                         const Run part{place, search(place)};
                         for (std::size_t k = part.begin; k < part.end; ++k)
                           part_in_block[order[k]] = count;
                         out.push_back(part);
                         place = part.end;
                         ++count;
                       }
                     });
    exclusive_scan(arena, std::span(parts_before));
    return parts;
  }
  [[nodiscard]] std::size_t part_of(SiteNumber node) const {
    return parts_before[node / kBlock] + part_in_block[node];
  }

  /// Of each part to every other one that it has an edge to, the first such edge.
  Groups<Border> borders(const Buffer<Run>& parts) {
    Groups<Border> result{{}, Buffer<std::size_t>(parts.size() + 1)};
    PerWorker<std::vector<std::size_t>> last_met(arena);  // of each other part: from where, plus 1
    result.items =
        collect<Border>(arena, parts.size(), 1,
                        [&](std::size_t part, std::size_t, std::vector<Border>& out, int worker) {
                          std::vector<std::size_t>& met = last_met[worker];
                          met.resize(parts.size());
                          const std::size_t before = out.size();
                          for (std::size_t k = parts[part].begin; k < parts[part].end; ++k) {
                            for (const SiteNumber t : neighbours[order[k]]) {
                              const std::size_t other = part_of(t);
                              if (other == part || std::exchange(met[other], part + 1) == part + 1)
                                continue;
                              out.push_back({order[k], t});
                            }
                          }
                          result.first[part] = out.size() - before;
                        });
    result.first[parts.size()] = 0;
    exclusive_scan(arena, result.first.span());
    return result;
  }

  const Groups<SiteNumber>& neighbours;
  const Arena& arena;
  std::vector<SiteNumber> parent;
  Buffer<SiteNumber> order;
  std::vector<std::size_t> part_in_block;
  std::vector<std::size_t> parts_before;  ///< the first part of each block
};

}  // namespace

SpanningTree::SpanningTree(const Groups<SiteNumber>& neighbours, const Arena& arena) {
  TreeBuilder builder(neighbours, arena);
  const Buffer<Run> parts = builder.find_parts();
  const Groups<Border> borders = builder.borders(parts);

  // A tree of parts, breadth first from that of the root; and how each is entered.
  std::vector<bool> reached(parts.size(), false);
  std::vector<std::size_t> queue{0};
  std::vector<Border> entry{{kRoot, SiteNumber(0)}};
  reached[0] = true;
  parts_.push_back({parts[0].begin, parts[0].end, kNone});
  for (std::size_t next = 0; next < queue.size(); ++next) {
    for (const Border& border : borders[queue[next]]) {
      const std::size_t part = builder.part_of(border.to);
      if (reached[part]) continue;
      reached[part] = true;
      queue.push_back(part);
      entry.push_back(border);
      parts_.push_back({parts[part].begin, parts[part].end, next});
    }
  }

  // Once more through each, from where it is entered.
  std::fill(builder.parent.begin(), builder.parent.end(), kOutside);
  arena.for_each(parts_.size(), 1, [&](std::size_t p) {
    builder.parent[entry[p].to] = entry[p].from;
    builder.order[parts_[p].begin] = entry[p].to;
    builder.search(parts_[p].begin);
  });
  for (const Part& part : parts_) size_ += part.end - part.begin;
  parent_ = std::move(builder.parent);
  order_ = std::move(builder.order);
}

std::vector<SiteNumber> SpanningTree::order() const {
  std::vector<SiteNumber> order;
  order.reserve(size_);
  for (const Part& part : parts_) {
    order.insert(order.end(), order_.begin() + part.begin, order_.begin() + part.end);
  }
  return order;
}

void SpanningTree::add_subtrees(std::span<std::int64_t> values, const Arena& arena) const {
  std::vector<std::int64_t> sums(parts_.size());
  arena.for_each(parts_.size(), 1, [&](std::size_t p) {
    for (std::size_t k = parts_[p].begin; k < parts_[p].end; ++k) sums[p] += values[order_[k]];
  });
  // What comes from other parts, to the nodes that these are entered from.
  for (std::size_t p = parts_.size(); p-- > 1;) {
    sums[parts_[p].parent] += sums[p];
    values[parent(order_[parts_[p].begin])] += sums[p];
  }
  arena.for_each(parts_.size(), 1, [&](std::size_t p) {
    for (std::size_t k = parts_[p].end; k-- > parts_[p].begin + 1;) {
      values[parent(order_[k])] += values[order_[k]];
    }
  });
}

}  // namespace ccvt
