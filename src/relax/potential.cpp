#include "relax/potential.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "counting_sort.h"

namespace ccvt {
namespace {

constexpr double kResidual = 0.25;
/// A graph no larger is not made coarser. Connected graphs at least halve.
constexpr std::size_t kCoarsest = 32;
constexpr int kCoarsestSweeps = 8;

using Vector = std::vector<double>;

/// The Laplacian of a weighted graph: row s is degree(s) on the diagonal, and -weight off it.
struct Laplacian {
  std::vector<std::size_t> begin{0};
  std::vector<Index> neighbour;
  Vector weight;
  Vector degree;
  std::vector<Index> aggregate;  ///< of each node: a node of the next coarser graph

  [[nodiscard]] std::size_t size() const { return degree.size(); }

  void add_node() {
    double sum = 0;
    for (std::size_t k = begin.back(); k < weight.size(); ++k) sum += weight[k];
    degree.push_back(sum);
    begin.push_back(weight.size());
  }

  /// The off-diagonal part of row s times x, less its sign.
  [[nodiscard]] double pull(std::size_t s, const Vector& x) const {
    double sum = 0;
    for (std::size_t k = begin[s]; k < begin[s + 1]; ++k) {
      sum += weight[k] * x[static_cast<std::size_t>(neighbour[k])];
    }
    return sum;
  }

  /// One Gauss-Seidel step.
  void relax(std::size_t s, const Vector& b, Vector& x) const {
    if (degree[s] > 0) x[s] = (b[s] + pull(s, x)) / degree[s];
  }
  void sweep_up(const Vector& b, Vector& x) const {
    for (std::size_t s = 0; s < size(); ++s) relax(s, b, x);
  }
  void sweep_down(const Vector& b, Vector& x) const {
    for (std::size_t s = size(); s-- > 0;) relax(s, b, x);
  }
};

Laplacian laplacian_of(const SiteGraph& graph) {
  Laplacian result;
  for (Index s = 0; s < graph.site_count(); ++s) {
    for (const Index t : graph.neighbours(s)) {
      result.neighbour.push_back(t);
      result.weight.push_back(1);
    }
    result.add_node();
  }
  return result;
}

/// Groups nodes: a node none of whose neighbours is in a group founds one with all of them; those
/// left over join the group of the neighbour they are tied to most. Returns how many groups.
Index make_aggregates(Laplacian& fine) {
  fine.aggregate.assign(fine.size(), -1);
  const auto neighbours = [&](std::size_t s) {
    return std::span(fine.neighbour).subspan(fine.begin[s], fine.begin[s + 1] - fine.begin[s]);
  };
  const auto group = [&](Index s) -> Index& { return fine.aggregate[static_cast<std::size_t>(s)]; };
  Index count = 0;
  for (std::size_t s = 0; s < fine.size(); ++s) {
    const auto near = neighbours(s);
    if (fine.aggregate[s] >= 0) continue;
    if (std::any_of(near.begin(), near.end(), [&](Index t) { return group(t) >= 0; })) continue;
    fine.aggregate[s] = count;
    for (const Index t : near) group(t) = count;
    ++count;
  }
  const std::vector<Index> founded = fine.aggregate;
  for (std::size_t s = 0; s < fine.size(); ++s) {
    if (founded[s] >= 0) continue;
    double strongest = 0;
    for (std::size_t k = fine.begin[s]; k < fine.begin[s + 1]; ++k) {
      const Index other = founded[static_cast<std::size_t>(fine.neighbour[k])];
      if (other >= 0 && fine.weight[k] > strongest) {
        strongest = fine.weight[k];
        fine.aggregate[s] = other;
      }
    }
  }
  return count;
}

/// The graph of the aggregates: weights between them are sums.
Laplacian coarser(const Laplacian& fine, Index count) {
  const auto aggregate = [&](std::size_t s) { return static_cast<std::size_t>(fine.aggregate[s]); };
  std::vector<std::size_t> members(fine.size());
  std::iota(members.begin(), members.end(), std::size_t{0});
  counting_sort(members, static_cast<std::size_t>(count), aggregate);
  Laplacian coarse;
  // Where the row being made has each neighbour, counted from 1; at its beginning or before: not
  // yet.
  std::vector<std::size_t> place(static_cast<std::size_t>(count), 0);
  for (auto member = members.begin(); member != members.end();) {
    const std::size_t row = coarse.begin.back();
    const std::size_t own = aggregate(*member);
    for (; member != members.end() && aggregate(*member) == own; ++member) {
      for (std::size_t k = fine.begin[*member]; k < fine.begin[*member + 1]; ++k) {
        const std::size_t other = aggregate(static_cast<std::size_t>(fine.neighbour[k]));
        if (other == own) continue;
        if (place[other] <= row) {
          coarse.neighbour.push_back(static_cast<Index>(other));
          coarse.weight.push_back(0);
          place[other] = coarse.weight.size();
        }
        coarse.weight[place[other] - 1] += fine.weight[k];
      }
    }
    coarse.add_node();
  }
  return coarse;
}

/// A symmetric approximation of the inverse of a Laplacian.
class Multigrid {
 public:
  explicit Multigrid(Laplacian finest) {
    levels_.push_back({std::move(finest), {}, {}, {}});
    while (levels_.back().matrix.size() > kCoarsest) {
      Laplacian& fine = levels_.back().matrix;
      const Index count = make_aggregates(fine);
      levels_.push_back({coarser(fine, count), {}, {}, {}});
    }
    for (Level& level : levels_) {
      for (Vector* v : {&level.right, &level.solution, &level.rest}) v->resize(level.matrix.size());
    }
  }

  [[nodiscard]] const Laplacian& finest() const { return levels_.front().matrix; }

  /// x becomes about L^-1 b.
  void apply(const Vector& b, Vector& x) { cycle(0, b, x); }

 private:
  struct Level {
    Laplacian matrix;
    Vector right;
    Vector solution;
    Vector rest;
  };

  void cycle(std::size_t l, const Vector& b, Vector& x) {
    const Laplacian& matrix = levels_[l].matrix;
    std::fill(x.begin(), x.end(), 0.0);
    if (l + 1 == levels_.size()) {
      for (int sweep = 0; sweep < kCoarsestSweeps; ++sweep) {
        matrix.sweep_up(b, x);
        matrix.sweep_down(b, x);
      }
      return;
    }
    matrix.sweep_up(b, x);
    Level& coarse = levels_[l + 1];
    std::fill(coarse.right.begin(), coarse.right.end(), 0.0);
    for (std::size_t s = 0; s < matrix.size(); ++s) {
      coarse.right[static_cast<std::size_t>(matrix.aggregate[s])] +=
          b[s] - matrix.degree[s] * x[s] + matrix.pull(s, x);
    }
    // Twice: piecewise constant corrections fall short of smooth ones.
    cycle(l + 1, coarse.right, coarse.solution);
    correct(l + 1);
    for (std::size_t s = 0; s < matrix.size(); ++s) {
      x[s] += coarse.solution[static_cast<std::size_t>(matrix.aggregate[s])];
    }
    matrix.sweep_down(b, x);
  }

  /// A second cycle, for what the first has left.
  void correct(std::size_t l) {
    if (l + 1 == levels_.size()) return;
    Level& level = levels_[l];
    const Laplacian& matrix = level.matrix;
    const Vector first = level.solution;
    for (std::size_t s = 0; s < matrix.size(); ++s) {
      level.rest[s] = level.right[s] - matrix.degree[s] * first[s] + matrix.pull(s, first);
    }
    cycle(l, level.rest, level.solution);
    for (std::size_t s = 0; s < matrix.size(); ++s) level.solution[s] += first[s];
  }

  std::vector<Level> levels_;
};

double dot(const Vector& a, const Vector& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

std::vector<double> potential(const SiteGraph& graph, std::span<const Index> e,
                              const Arena& arena) {
  const std::size_t n = e.size();
  Vector phi(n, 0.0);
  if (n < 2) return phi;
  Multigrid inverse(laplacian_of(graph));
  const Laplacian& matrix = inverse.finest();
  Vector residual(e.begin(), e.end());
  Vector direction(n, 0.0);
  Vector image(n);
  Vector improved(n);
  double before = 0;
  for (std::size_t iteration = 0; iteration < 2 * n; ++iteration) {
    const bool solved = std::all_of(residual.begin(), residual.end(),
                                    [](double r) { return std::abs(r) <= kResidual; });
    if (solved) break;
    arena.check();
    inverse.apply(residual, improved);
    const double rho = dot(residual, improved);
    const double beta = iteration == 0 ? 0 : rho / before;
    before = rho;
    for (std::size_t s = 0; s < n; ++s) direction[s] = improved[s] + beta * direction[s];
    for (std::size_t s = 0; s < n; ++s) {
      image[s] = matrix.degree[s] * direction[s] - matrix.pull(s, direction);
    }
    const double curvature = dot(direction, image);
    if (!(curvature > 0)) break;  // nothing left but rounding
    const double step = rho / curvature;
    for (std::size_t s = 0; s < n; ++s) {
      phi[s] += step * direction[s];
      residual[s] -= step * image[s];
    }
  }
  return phi;
}

}  // namespace ccvt
