#include "relax/potential.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccvt {
namespace {

constexpr double kResidual = 0.25;
/// Consecutive nodes that become one on the next coarser level: by spatial_order() they lie close
/// together.
constexpr std::size_t kAggregate = 4;
/// A graph no larger is not made coarser.
constexpr std::size_t kCoarsest = 32;
constexpr int kCoarsestSweeps = 8;
/// Consecutive nodes that are smoothed one after the other; the blocks at the same time.
constexpr std::size_t kBlock = 512;
constexpr std::size_t kNodesPerGrain = 2 * kBlock;

using Vector = std::vector<double>;
using Node = Number<struct OfGraphNodes>;

/// The Laplacian of a weighted graph: row s is degree(s) on the diagonal, and -weight off it.
struct Laplacian {
  struct Edge {
    Node neighbour;
    float weight;  ///< a count of edges, perhaps rounded: the preconditioner may be another matrix
  };
  Buffer<Edge> edges;
  Buffer<std::size_t> first;  ///< edge of each node, and one more
  Vector degree;
  Vector outer_degree;  ///< of edges that lead out of the node's block

  [[nodiscard]] std::size_t size() const { return degree.size(); }
  [[nodiscard]] std::span<const Edge> row(std::size_t s) const {
    return edges.span().subspan(first[s], first[s + 1] - first[s]);
  }

  /// The off-diagonal part of row s times x, less its sign.
  [[nodiscard]] double pull(std::size_t s, const Vector& x) const {
    double sum = 0;
    for (const auto [t, weight] : row(s)) sum += weight * x[t];
    return sum;
  }

  void add_degrees(const Arena& arena) {
    degree.resize(first.size() - 1);
    outer_degree.resize(degree.size());
    arena.for_each(size(), kNodesPerGrain, [&](std::size_t s) {
      degree[s] = outer_degree[s] = 0;
      for (const auto [t, weight] : row(s)) {
        degree[s] += weight;
        if (t / kBlock != s / kBlock) outer_degree[s] += weight;
      }
    });
  }
};

Laplacian laplacian_of(const SiteGraph& graph, const Arena& arena) {
  const Groups<SiteNumber>& neighbours = graph.all_neighbours();
  Laplacian result;
  result.edges.reset(neighbours.items.size());
  result.first.reset(neighbours.first.size());
  arena.for_each(neighbours.items.size(), kNodesPerGrain, [&](std::size_t k) {
    result.edges[k] = {Node(neighbours.items[k].index()), 1};
  });
  std::copy(neighbours.first.begin(), neighbours.first.end(), result.first.begin());
  result.add_degrees(arena);
  return result;
}

Laplacian laplacian_of(const WeightedGraph& graph, const Arena& arena) {
  Laplacian result;
  result.edges.reset(graph.neighbour.size());
  result.first.reset(graph.first.size());
  for (std::size_t k = 0; k < graph.neighbour.size(); ++k) {
    result.edges[k] = {Node(graph.neighbour[k].index()), graph.weight[k]};
  }
  std::copy(graph.first.begin(), graph.first.end(), result.first.begin());
  result.add_degrees(arena);
  return result;
}

/// The graph of aggregates of consecutive nodes: weights between them are sums.
Laplacian coarser(const Laplacian& fine, const Arena& arena) {
  using Edge = Laplacian::Edge;
  const std::size_t count = (fine.size() + kAggregate - 1) / kAggregate;
  Laplacian coarse;
  coarse.first.reset(count + 1);
  PerWorker<std::vector<Edge>> scratch(arena);
  coarse.edges = collect_together<Edge>(
      arena, count, kNodesPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<Edge>& out, int worker) {
        std::vector<Edge>& row = scratch[worker];
        for (std::size_t own = begin; own < end; ++own) {
          row.clear();
          const std::size_t last = std::min((own + 1) * kAggregate, fine.size());
          for (std::size_t s = own * kAggregate; s < last; ++s) {
            for (const Edge& edge : fine.row(s)) {
              const std::size_t other = edge.neighbour / kAggregate;
              if (other != own) row.push_back({Node(other), edge.weight});
            }
          }
          std::sort(row.begin(), row.end(),
                    [](const Edge& a, const Edge& b) { return a.neighbour < b.neighbour; });
          const std::size_t before = out.size();
          for (const Edge& edge : row) {
            if (out.size() == before || out.back().neighbour != edge.neighbour) {
              out.push_back(edge);
            } else {
              out.back().weight += edge.weight;
            }
          }
          coarse.first[own] = out.size() - before;
        }
      });
  // collect_together() divides blocks in the same way.
  share_ranges(arena, coarse.first.span().first(count), kNodesPerGrain);
  coarse.first[count] = 0;
  exclusive_scan(arena, coarse.first.span());
  coarse.add_degrees(arena);
  return coarse;
}

/// A symmetric approximation of the inverse of a Laplacian: a multigrid cycle.
///
/// Smoothed by Gauss-Seidel inside blocks of nodes and Jacobi between them; edges between blocks
/// count twice in the diagonal, which makes it converge however many there are [Baker, Falgout,
/// Kolev, Yang 2011, "l1" smoothers].
class Multigrid {
 public:
  Multigrid(Laplacian finest, const Arena& arena) : arena_(arena) {
    add_level(std::move(finest));
    while (levels_.back().matrix.size() > kCoarsest) {
      add_level(coarser(levels_.back().matrix, arena));
    }
  }

  [[nodiscard]] const Laplacian& finest() const { return levels_.front().matrix; }

  /// x becomes about L^-1 b.
  void apply(const Vector& b, Vector& x) { cycle(0, b, x); }

 private:
  struct Level {
    Laplacian matrix;
    Vector before;  ///< the last sweep
    // Of a level that is solved for another one, which the finest is not.
    Vector right;
    Vector solution;
    Vector first;  ///< of two solutions, which are added
    Vector rest;
  };

  void add_level(Laplacian matrix) {
    Level level;
    level.before.resize(matrix.size());
    if (!levels_.empty()) {
      for (Vector* own : {&level.right, &level.solution, &level.first, &level.rest}) {
        own->resize(matrix.size());
      }
    }
    level.matrix = std::move(matrix);
    levels_.push_back(std::move(level));
  }

  template <class Body>
  void for_nodes(std::size_t count, const Body& body) const {
    arena_.for_each(count, kNodesPerGrain, body);
  }

  /// The first sweep, from x = 0, through each block upwards.
  void sweep_up(const Laplacian& matrix, const Vector& b, Vector& x) const {
    set_together(arena_, std::span(x), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        double pull = 0;
        for (const auto [t, weight] : matrix.row(s)) {
          if (t >= begin && t < s) pull += weight * x[t];
        }
        const double diagonal = matrix.degree[s] + matrix.outer_degree[s];
        x[s] = diagonal > 0 ? (b[s] + pull) / diagonal : 0;
      }
    });
  }

  /// The last sweep, downwards: the first one's transpose. `before` is what it starts from.
  void sweep_down(const Laplacian& matrix, const Vector& b, Vector& x, const Vector& before) const {
    set_together(arena_, std::span(x), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = end; s-- > begin;) {
        double pull = matrix.outer_degree[s] * before[s];
        for (const auto [t, weight] : matrix.row(s)) {
          pull += weight * (t > s && t < end ? x[t] : before[t]);
        }
        const double diagonal = matrix.degree[s] + matrix.outer_degree[s];
        x[s] = diagonal > 0 ? (b[s] + pull) / diagonal : before[s];
      }
    });
  }

  static void sweep_coarsest(const Laplacian& matrix, const Vector& b, Vector& x) {
    std::fill(x.begin(), x.end(), 0.0);
    const auto relax = [&](std::size_t s) {
      if (matrix.degree[s] > 0) x[s] = (b[s] + matrix.pull(s, x)) / matrix.degree[s];
    };
    for (int sweep = 0; sweep < kCoarsestSweeps; ++sweep) {
      for (std::size_t s = 0; s < x.size(); ++s) relax(s);
      for (std::size_t s = x.size(); s-- > 0;) relax(s);
    }
  }

  void cycle(std::size_t l, const Vector& b, Vector& x) {
    Level& level = levels_[l];
    const Laplacian& matrix = level.matrix;
    if (l + 1 == levels_.size()) return sweep_coarsest(matrix, b, x);
    sweep_up(matrix, b, x);
    Level& coarse = levels_[l + 1];
    fill_together(arena_, std::span(coarse.right), kNodesPerGrain, [&](std::size_t g) {
      double sum = 0;
      const std::size_t last = std::min((g + 1) * kAggregate, matrix.size());
      for (std::size_t s = g * kAggregate; s < last; ++s) {
        sum += b[s] - matrix.degree[s] * x[s] + matrix.pull(s, x);
      }
      return sum;
    });
    // Twice: piecewise constant corrections fall short of smooth ones.
    cycle(l + 1, coarse.right, coarse.solution);
    correct(l + 1);
    for_nodes(x.size(),
              [&](std::size_t s) { level.before[s] = x[s] + coarse.solution[s / kAggregate]; });
    sweep_down(matrix, b, x, level.before);
  }

  /// A second cycle, for what the first has left.
  void correct(std::size_t l) {
    if (l + 1 == levels_.size()) return;
    Level& level = levels_[l];
    const Laplacian& matrix = level.matrix;
    std::swap(level.solution, level.first);
    const Vector& first = level.first;
    fill_together(arena_, std::span(level.rest), kNodesPerGrain, [&](std::size_t s) {
      return level.right[s] - matrix.degree[s] * first[s] + matrix.pull(s, first);
    });
    cycle(l, level.rest, level.solution);
    for_nodes(first.size(), [&](std::size_t s) { level.solution[s] += first[s]; });
  }

  const Arena& arena_;
  std::vector<Level> levels_;
};

/// Conjugate gradients, to `share` of the largest e or to kResidual.
Vector solve(Laplacian laplacian, Vector residual, double share, const Arena& arena) {
  const std::size_t n = residual.size();
  Vector phi(n, 0.0);
  if (n < 2) return phi;
  Multigrid inverse(std::move(laplacian), arena);
  const Laplacian& matrix = inverse.finest();
  Vector direction(n, 0.0);
  Vector image(n);
  Vector improved(n);
  const auto largest = [](double a, double b) { return std::max(a, b); };
  double most = reduce(
      arena, n, kNodesPerGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double in_range = 0;
        for (std::size_t s = begin; s < end; ++s) {
          in_range = std::max(in_range, std::abs(residual[s]));
        }
        return in_range;
      },
      largest);
  const double enough = std::max(kResidual, share * most);
  double before = 0;
  for (std::size_t iteration = 0; iteration < 2 * n && most > enough; ++iteration) {
    arena.check();
    inverse.apply(residual, improved);
    const double rho =
        sum_of(arena, n, kNodesPerGrain, [&](std::size_t s) { return residual[s] * improved[s]; });
    const double beta = iteration == 0 ? 0 : rho / before;
    before = rho;
    arena.for_each(n, kNodesPerGrain,
                   [&](std::size_t s) { direction[s] = improved[s] + beta * direction[s]; });
    fill_together(arena, std::span(image), kNodesPerGrain, [&](std::size_t s) {
      return matrix.degree[s] * direction[s] - matrix.pull(s, direction);
    });
    const double curvature =
        sum_of(arena, n, kNodesPerGrain, [&](std::size_t s) { return direction[s] * image[s]; });
    if (!(curvature > 0)) break;  // nothing left but rounding
    const double step = rho / curvature;
    most = reduce(
        arena, n, kNodesPerGrain, 0.0,
        [&](std::size_t begin, std::size_t end) {
          double in_range = 0;
          for (std::size_t s = begin; s < end; ++s) {
            phi[s] += step * direction[s];
            residual[s] -= step * image[s];
            in_range = std::max(in_range, std::abs(residual[s]));
          }
          return in_range;
        },
        largest);
  }
  return phi;
}

}  // namespace

std::vector<double> potential(const SiteGraph& graph, std::span<const Index> e,
                              const Arena& arena) {
  return solve(laplacian_of(graph, arena), Vector(e.begin(), e.end()), 0, arena);
}

std::vector<double> potential(const WeightedGraph& graph, std::span<const double> e,
                              const Arena& arena) {
  constexpr double kShare = 0.01;
  return solve(laplacian_of(graph, arena), Vector(e.begin(), e.end()), kShare, arena);
}

}  // namespace ccvt
