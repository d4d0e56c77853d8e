// What several ranks find out together for an exchange graph. All search the same; each knows its
// own points of the cells only, or all, and takes its turns in bounding cells.
#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "exact/exchange.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// Cells whose edges are bounded at a time.
constexpr std::size_t kCells = 64;
/// Edges that are weighed in one message, as far as so many may matter: one more takes a rank less
/// time than a message.
constexpr std::size_t kEdges = 16;

}  // namespace

/// Of the edges that each rank found, those that cost least for the points of all.
void ExchangeGraph::find_edges_together(std::size_t edges, Scratch& scratch) const {
  ByteWriter message;
  put_edges(message, scratch);
  const std::vector<Ranks::Bytes> bytes = part_.ranks->gather(message.bytes);
  std::vector<ByteReader> readers;
  for (const Ranks::Bytes& of_rank : bytes) readers.emplace_back(of_rank);
  join_edges(readers, edges, scratch);
}

void ExchangeGraph::put_edges(ByteWriter& message, const Scratch& scratch) {
  message.put(scratch.rest);
  message.put(std::uint64_t{scratch.edges.size()});
  for (const auto& [reduced, to, bound] : scratch.edges) {
    message.put(to.index());
    message.put(bound);
  }
}

void ExchangeGraph::join_edges(std::span<ByteReader> ranks, std::size_t edges,
                               Scratch& scratch) const {
  std::vector<Edge>& all = scratch.edges;
  all.clear();
  double rest = kNone;  // on any rank
  for (ByteReader& reader : ranks) {
    rest = std::min(rest, reader.get<double>());
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
      const SiteNumber to(reader.get<Index>());
      const auto bound = reader.get<double>();
      all.push_back({bound - weights_[to], to, bound});
    }
  }
  std::sort(all.begin(), all.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.to, a.bound) < std::tie(b.to, b.bound);
  });
  // Where a rank has not found an edge, it weighs no less than the rest there.
  std::size_t kept = 0;
  for (std::size_t k = 0; k < all.size();) {
    Edge edge = all[k];
    std::size_t found = 0;
    for (; k < all.size() && all[k].to == edge.to; ++k) ++found;
    if (found < ranks.size() && rest < edge.reduced) {
      edge.reduced = rest;
      edge.bound = lowered(rest, weights_[edge.to]);
    }
    all[kept++] = edge;
  }
  all.resize(kept);
  scratch.rest = rest;
  keep_nearest(edges, scratch);
}

/// The edges of all sites, some sites at a time.
void ExchangeGraph::bound_all_together(const Arena& arena) {
  PerWorker<Scratch> scratch(arena);
  for (std::size_t first = 0; first < cells_.size(); first += kCells) {
    const std::size_t count = std::min(cells_.size() - first, kCells);
    const auto for_cells = [&](const auto& look) {
      arena.for_ranges(count, 1, [&](std::size_t begin, std::size_t end, int worker) {
        for (std::size_t k = begin; k < end; ++k) {
          arena.check();
          look(k, SiteNumber(first + k), scratch[worker]);
        }
      });
    };
    std::vector<ByteWriter> messages(count);
    for_cells([&](std::size_t k, SiteNumber s, Scratch& own) {
      find_edges(s, slots_of_each(), own);
      put_edges(messages[k], own);
    });
    ByteWriter message;
    for (const ByteWriter& of_cell : messages) message.put(std::uint64_t{of_cell.bytes.size()});
    for (const ByteWriter& of_cell : messages) message.put(std::span(of_cell.bytes));
    const std::vector<Ranks::Bytes> bytes = part_.ranks->gather(message.bytes);
    std::vector<std::vector<ByteReader>> readers(count);  // of each cell, one for each rank
    for (const Ranks::Bytes& of_rank : bytes) {
      ByteReader sizes(of_rank);
      std::size_t place = count * sizeof(std::uint64_t);
      for (std::vector<ByteReader>& of_cell : readers) {
        const auto size = sizes.get<std::uint64_t>();
        of_cell.emplace_back(std::span(of_rank).subspan(place, size));
        place += size;
      }
    }
    for_cells([&](std::size_t k, SiteNumber s, Scratch& own) {
      if (cells_[s].size == 0) return;
      join_edges(readers[k], slots_of_each(), own);
      set_edges(s, own);
    });
  }
}

void ExchangeGraph::get_edges(ByteReader& message, Scratch& scratch) const {
  scratch.edges.clear();
  scratch.rest = message.get<double>();
  for (auto left = message.get<std::uint64_t>(); left > 0; --left) {
    const SiteNumber to(message.get<Index>());
    const auto bound = message.get<double>();
    scratch.edges.push_back({bound - weights_[to], to, bound});
  }
}

/// The edges that the rank finds whose turn it is. All ask for the same: when, hangs on bounds,
/// some of which are rounded as a processor's vectors are long.
void ExchangeGraph::find_edges_in_turns(SiteNumber site, std::size_t edges, Scratch& scratch) {
  if (!turns_.own(site)) {
    const Ranks::Bytes message = sharing_->receive(static_cast<int>(turns_.rank_of(site)));
    ByteReader reader(message);
    const auto of = reader.get<Index>();
    const auto wanted = reader.get<std::uint64_t>();
    if (of != site.index() || wanted != edges) {
      throw std::runtime_error("ranks have come to search apart: processors differ too much");
    }
    get_edges(reader, scratch);
    return;
  }
  find_edges(site, edges, scratch);
  ByteWriter message;
  message.put(site.index());
  message.put(std::uint64_t{edges});
  put_edges(message, scratch);
  for (int rank = 0; rank < sharing_->count(); ++rank) {
    if (rank != sharing_->rank()) sharing_->send(rank, message.bytes);
  }
}

/// The edges of all sites, each of which is bounded by one rank.
void ExchangeGraph::bound_all_in_turns(const Arena& arena) {
  PerWorker<Scratch> scratch(arena);
  std::vector<ByteWriter> messages(cells_.size());
  const auto for_cells = [&](const auto& look) {
    arena.for_ranges(cells_.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
      for (const SiteNumber s : sites_between(begin, end)) {
        if (cells_[s].size > 0) look(s, scratch[worker]);
      }
    });
  };
  for_cells([&](SiteNumber s, Scratch& own) {
    if (!turns_.own(s)) return;
    arena.check();
    find_edges(s, slots_of_each(), own);
    put_edges(messages[s], own);
  });
  ByteWriter message;
  for (const ByteWriter& of_cell : messages) {
    if (!of_cell.bytes.empty()) message.put(of_cell.bytes);
  }
  read_in_turns(*sharing_, message.bytes, cells_.size(), [&](std::size_t k, ByteReader& reader) {
    if (cells_[k].size > 0) reader.get(messages[k].bytes);
  });
  for_cells([&](SiteNumber s, Scratch& own) {
    ByteReader reader(messages[s].bytes);
    get_edges(reader, own);
    set_edges(s, own);
  });
}

/// Of the cheapest moves of each rank along an edge that is not weighed, and along others in the
/// same message, those of all.
void ExchangeGraph::weigh_together(SiteNumber site, std::size_t slot) {
  choose_slots(site, slot, kEdges);
  const auto put = [](ByteWriter& message, const Move& move) {
    message.put(move.cost);
    message.put(move.point);
  };
  const auto get = [](ByteReader& reader) {
    const auto cost = reader.get<double>();
    return Move{cost, reader.get<Index>()};
  };
  weigh_own(site);
  ByteWriter message;
  for (const std::size_t chosen : slots_) {
    Moves& moves = moves_of(site, chosen);
    put(message, moves.beyond);
    message.put(std::uint64_t{moves.cheapest.size()});
    for (const Move& move : moves.cheapest) put(message, move);
    moves.cheapest.clear();
  }
  const std::vector<Ranks::Bytes> bytes = part_.ranks->gather(message.bytes);
  std::vector<ByteReader> readers;
  for (const Ranks::Bytes& of_rank : bytes) readers.emplace_back(of_rank);
  for (const std::size_t chosen : slots_) {
    Moves& moves = moves_of(site, chosen);
    std::vector<Move>& cheapest = moves.cheapest;
    for (ByteReader& reader : readers) {
      moves.beyond = std::min(moves.beyond, get(reader));
      for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
        cheapest.push_back(get(reader));
      }
    }
    std::sort(cheapest.begin(), cheapest.end());
    // What is beyond on one rank may come before what others have.
    const auto end = std::lower_bound(cheapest.begin(), cheapest.end(), moves.beyond);
    const auto count = std::min(moves.kept, static_cast<std::size_t>(end - cheapest.begin()));
    if (count < cheapest.size()) {
      moves.beyond = std::min(moves.beyond, cheapest[count]);
      cheapest.resize(count);
    }
    set_weighed(site, chosen);
  }
}

/// Tells all ranks the positions of points that move.
void ExchangeGraph::bring(std::vector<Mover>& movers) {
  std::vector<Index> points;
  for (const Mover& mover : movers) points.push_back(mover.point);
  const std::vector<PointNumber> places = costs_.bring(points, part_);
  for (std::size_t k = 0; k < movers.size(); ++k) movers[k].place = places[k];
}

}  // namespace ccvt
