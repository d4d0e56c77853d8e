#include "relax/balance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "parallel/loops.h"
#include "relax/across.h"
#include "relax/mover.h"
#include "relax/potential.h"
#include "relax/site_graph.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 1024;
/// Rounds after which what is left moves along the tree. A few do, unless a great many points flow
/// through sites of few.
constexpr int kMostRounds = 64;

template <class Scalar>
std::vector<Index> surpluses(const Filling<Scalar>& filling, const Arena& arena) {
  std::vector<Index> surplus(filling.filled.size());
  for_each_site(arena, filling.tiles, [&](SiteNumber s) { surplus[s] = filling.surplus(s); });
  share(filling.tiles, surplus);
  return surplus;
}

/// How many points flow from a site to a neighbour, so that no surplus is left: along the edges of
/// the spanning tree what subtrees have too much, on all others the drop of the potential.
class Flow {
 public:
  Flow(const SiteGraph& graph, const std::vector<Index>& surplus, const Arena& arena)
      : tree_(graph.spanning_tree()),
        phi_(potential(graph, surplus, arena)),
        to_parent_(surplus.size()) {
    const auto charge = arena.phase(Phase::flow);
    for_each_site(arena, surplus.size(), kSitesPerGrain, [&](SiteNumber s) {
      to_parent_[s] = surplus[s];
      for (const SiteNumber t : graph.neighbours(s)) {
        if (!in_tree(s, t)) to_parent_[s] -= drop(s, t);
      }
    });
    tree_.add_subtrees(to_parent_, arena);
    if (to_parent_[0] != 0) throw std::logic_error("balance: surpluses do not sum to zero");
  }

  [[nodiscard]] std::int64_t operator()(SiteNumber from, SiteNumber to) const {
    if (tree_.parent(from) == to) return to_parent_[from];
    if (tree_.parent(to) == from) return -to_parent_[to];
    return drop(from, to);
  }
  [[nodiscard]] double potential_at(SiteNumber site) const { return phi_[site]; }

 private:
  [[nodiscard]] bool in_tree(SiteNumber s, SiteNumber t) const {
    return tree_.parent(s) == t || tree_.parent(t) == s;
  }
  [[nodiscard]] std::int64_t drop(SiteNumber from, SiteNumber to) const {
    return static_cast<std::int64_t>(std::nearbyint(potential_at(from) - potential_at(to)));
  }

  const SpanningTree& tree_;
  std::vector<double> phi_;
  std::vector<std::int64_t> to_parent_;
};

/// Moves points along the edges, in batches of pairs of tiles; in each task from the highest site
/// to the lowest.
template <class Scalar>
class FlowRounds {
 public:
  FlowRounds(const Metric& metric, const SiteState& sites, const SiteGraph& graph, const Flow& flow,
             const Arena& arena, Filling<Scalar>& filling)
      : arena_(arena),
        filling_(filling),
        tiles_(filling.tiles),
        movers_(arena, Mover<Scalar>(metric, sites, filling)) {
    const Buffer<Pair> edges = collect_by_site<Pair>(
        arena, graph.site_count(), kSitesPerGrain, [&](SiteNumber s, std::vector<Pair>& out, int) {
          for (const SiteNumber t : graph.neighbours(s)) {
            if (flow(s, t) > 0) out.emplace_back(s, t);
          }
        });
    schedule_ = schedule_pairs(edges, filling.tiles, arena);
    left_.reset(edges.size());
    ran_.resize(edges.size());
    arena.for_each(schedule_.tasks.size(), 16, [&](std::size_t t) {
      const Schedule::Task& task = schedule_.tasks[t];
      const std::span<Pair> own = schedule_.pairs.span().subspan(task.begin, task.size());
      std::sort(own.begin(), own.end(), [&](const Pair& x, const Pair& y) {
        const double high = flow.potential_at(x.first);
        const double low = flow.potential_at(y.first);
        return high != low ? high > low : x < y;
      });
      for (std::size_t e = task.begin; e < task.end; ++e) {
        left_[e] = flow(schedule_.pairs[e].first, schedule_.pairs[e].second);
      }
    });
  }

  /// Moves what can be moved. Whether there is anything left, and this round has moved something.
  bool run() {
    struct Count {
      std::int64_t moved = 0;
      std::int64_t left = 0;
    };
    PerWorker<Count> counts(arena_);
    const auto work = [&](const Schedule::Task& task, int w) {
      Mover<Scalar>& mover = movers_[w];
      SiteNumber from = SiteNumber::none();
      ran_[task.begin] = 1;
      for (std::size_t e = task.begin; e < task.end; ++e) {
        if (left_[e] == 0) continue;
        const Pair& edge = schedule_.pairs[e];
        if (edge.first != from) {
          if (from != SiteNumber::none()) mover.stay();
          mover.leave(from = edge.first);
        }
        const auto wanted = std::min<std::int64_t>(left_[e], std::numeric_limits<Index>::max());
        const Index moved = mover.move(edge.second, static_cast<Index>(wanted));
        left_[e] -= moved;
        counts[w].moved += moved;
        counts[w].left += left_[e];
      }
      if (from != SiteNumber::none()) mover.stay();
    };
    const FillingLender<Scalar> lender{filling_, schedule_, left_.span()};
    run_batches(arena_, tiles_, schedule_, lender, work, [] { return true; });
    Count all;
    for (int w = 0; w < arena_.threads(); ++w) {
      all.moved += counts[w].moved;
      all.left += counts[w].left;
    }
    share_left();
    return total(tiles_.ranks(), all.left) > 0 && total(tiles_.ranks(), all.moved) > 0;
  }

 private:
  /// What is left is known where it was moved from; now all ranks know.
  void share_left() {
    if (tiles_.ranks() == nullptr) return;
    struct Left {
      std::size_t edge;
      std::int64_t points;
    };
    std::vector<Left> own;
    for (const Schedule::Task& task : schedule_.tasks) {
      if (ran_[task.begin] == 0) continue;
      for (std::size_t e = task.begin; e < task.end; ++e) {
        if (left_[e] != 0) own.push_back({e, left_[e]});
      }
    }
    std::fill(left_.begin(), left_.end(), 0);
    std::fill(ran_.begin(), ran_.end(), std::uint8_t{0});
    for (const Left& all : joined(tiles_.ranks(), std::move(own))) left_[all.edge] = all.points;
  }

  const Arena& arena_;
  Filling<Scalar>& filling_;
  const Tiling& tiles_;
  Schedule schedule_;
  std::vector<std::uint8_t> ran_;  ///< here, by the first edge of a task
  Buffer<std::int64_t> left_;      ///< to move along each edge, which are the schedule's pairs
  PerWorker<Mover<Scalar>> movers_;
};

/// What a subtree has too much goes up to its parent; then what it lacks comes down. A site never
/// has to pass on more points than it has: see the order of both sweeps.
template <class Scalar>
void flow_along_tree(const Metric& metric, const SiteState& sites, const SiteGraph& graph,
                     const Arena& arena, Filling<Scalar>& filling) {
  const std::vector<Index> surplus = surpluses(filling, arena);
  if (std::all_of(surplus.begin(), surplus.end(), [](Index s) { return s == 0; })) return;
  std::vector<std::int64_t> subtree(surplus.begin(), surplus.end());
  const SpanningTree& tree = graph.spanning_tree();
  const std::vector<SiteNumber> order = tree.order();
  Mover<Scalar> mover(metric, sites, filling);
  const auto pass = [&](SiteNumber from, SiteNumber to, std::int64_t count) {
    if (count > std::numeric_limits<Index>::max()) {
      throw std::length_error("balance: more points than can be numbered flow between two sites");
    }
    arena.check();
    pass_along(filling, from, to, [&] {
      mover.leave(from);
      mover.move(to, static_cast<Index>(count));
      mover.stay();
    });
  };
  for (std::size_t k = order.size(); k-- > 1;) {
    const std::int64_t count = subtree[order[k]];
    const SiteNumber parent = tree.parent(order[k]);
    subtree[parent] += count;
    if (count > 0) pass(order[k], parent, count);
  }
  for (std::size_t k = 1; k < order.size(); ++k) {
    const std::int64_t count = subtree[order[k]];
    if (count < 0) pass(tree.parent(order[k]), order[k], -count);
  }
}

}  // namespace

template <class Scalar>
void balance(const Metric& metric, const SiteState& sites, std::span<const Pair> near,
             const Arena& arena, Filling<Scalar>& filling) {
  const auto make_graph = [&] {
    const auto charge = arena.phase(Phase::graph);
    return SiteGraph(sites.count(), gabriel_pairs(metric, sites, near, filling.tiles, arena),
                     arena);
  };
  const SiteGraph graph = make_graph();
  const auto make_flow = [&] {
    const auto charge = arena.phase(Phase::potential);
    return Flow(graph, surpluses(filling, arena), arena);
  };
  const Flow flow = make_flow();
  const auto charge = arena.phase(Phase::flow);
  FlowRounds<Scalar> rounds(metric, sites, graph, flow, arena, filling);
  for (int round = 0; round < kMostRounds && rounds.run(); ++round) {
  }
  flow_along_tree(metric, sites, graph, arena, filling);
}

template void balance(const Metric&, const SiteState&, std::span<const Pair>, const Arena&,
                      Filling<float>&);
template void balance(const Metric&, const SiteState&, std::span<const Pair>, const Arena&,
                      Filling<double>&);

}  // namespace ccvt
