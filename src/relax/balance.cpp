#include "relax/balance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "kernels/keys.h"
#include "relax/potential.h"
#include "relax/site_graph.h"

namespace ccvt {
namespace {

/// Passes points from one site to another by the swap key.
template <class Scalar>
class Mover {
 public:
  Mover(const Metric& metric, const SiteState& sites, Filling<Scalar>& filling)
      : metric_(metric), sites_(sites), filling_(filling) {
    const auto size = static_cast<std::size_t>(metric.dimension());
    middle_.resize(size);
    normal_.resize(size);
    for (std::size_t d = 0; metric.periodic() && d < size; ++d) {
      extent_.push_back(static_cast<Scalar>(metric.extent()[d]));
    }
    turn_.resize(extent_.size());
  }

  /// Whose points move() moves. Nothing else may change the site's points until the last of them.
  void leave(Index from) {
    from_ = from;
    const auto& waiting = filling_.excess[static_cast<std::size_t>(from)];
    waiting_.resize(waiting.size() * normal_.size());
    for (std::size_t w = 0; w < waiting.size(); ++w) {
      std::copy_n(filling_.points[waiting[w]], normal_.size(), &waiting_[w * normal_.size()]);
    }
  }

  /// Moves the `count` points that gain most, or lose least, by changing to `to`; fewer when there
  /// are not as many.
  void move(Index to, Index count) {
    const Index from = from_;
    place_cut(from, to);
    const Index filled = filling_.filled[static_cast<std::size_t>(from)];
    auto& waiting = filling_.excess[static_cast<std::size_t>(from)];
    const auto places = static_cast<std::size_t>(filled) + waiting.size();
    // A cell that is not full has the stride of a full one: keys of empty places are overwritten.
    keys_.resize(std::max(places, static_cast<std::size_t>(filling_.cells.size(from))));
    keys_of(filling_.cells.block(from), filling_.cells.size(from), keys_.data());
    as_block(waiting.size());
    keys_of(block_.data(), static_cast<Index>(waiting.size()), keys_.data() + filled);
    choose(std::min(static_cast<std::size_t>(count), places), places);
    // From the last place to the first, so that filling a gap does not move a chosen point.
    std::sort(choices_.begin(), choices_.end(),
              [](const Choice& a, const Choice& b) { return a.place > b.place; });
    auto& arrivals = filling_.excess[static_cast<std::size_t>(to)];
    for (const Choice& choice : choices_) {
      if (choice.place >= filled) {
        const auto w = static_cast<std::size_t>(choice.place - filled);
        arrivals.push_back(waiting[w]);
        waiting[w] = waiting.back();
        waiting.pop_back();
        if (w < waiting.size()) {
          std::copy_n(waiting_.end() - static_cast<std::ptrdiff_t>(normal_.size()), normal_.size(),
                      &waiting_[w * normal_.size()]);
        }
        waiting_.resize(waiting_.size() - normal_.size());
      } else {
        arrivals.push_back(filling_.take(from, choice.place));
      }
    }
  }

 private:
  static constexpr std::size_t kColumns = 16;

  struct Choice {
    Scalar key;
    Index place;
  };

  struct Better {
    bool operator()(const Choice& a, const Choice& b) const {
      return a.key != b.key ? a.key > b.key : a.place < b.place;
    }
  };

  /// Chooses the best `wanted` of all places; of equal keys the first place is better. Places are
  /// dealt out to columns: of the columns with the highest keys, as many as are wanted, the lowest
  /// of these keys is one that no chosen place can be below, and few columns have a place above.
  void choose(std::size_t wanted, std::size_t places) {
    choices_.clear();
    if (wanted == 0) return;
    std::array<Scalar, kColumns> highest;
    highest.fill(-std::numeric_limits<Scalar>::infinity());
    const std::size_t whole = places - places % kColumns;
    for (std::size_t row = 0; row < whole; row += kColumns) {
      for (std::size_t c = 0; c < kColumns; ++c) highest[c] = std::max(highest[c], keys_[row + c]);
    }
    for (std::size_t k = whole; k < places; ++k) {
      highest[k - whole] = std::max(highest[k - whole], keys_[k]);
    }
    Scalar floor = -std::numeric_limits<Scalar>::infinity();
    if (wanted <= kColumns) {
      std::array<Scalar, kColumns> sorted = highest;
      const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(wanted) - 1;
      std::nth_element(sorted.begin(), last, sorted.end(), std::greater<>());
      floor = *last;
    }
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (highest[c] < floor) continue;
      for (std::size_t k = c; k < places; k += kColumns) {
        if (keys_[k] >= floor) choices_.push_back({keys_[k], static_cast<Index>(k)});
      }
    }
    if (choices_.size() < wanted) throw std::logic_error("balance: a key is not a number");
    if (choices_.size() == wanted) return;
    std::nth_element(choices_.begin(), choices_.begin() + static_cast<std::ptrdiff_t>(wanted),
                     choices_.end(), Better());
    choices_.resize(wanted);
  }

  /// The points that wait, with a stream for each dimension.
  void as_block(std::size_t count) {
    const std::size_t dimension = normal_.size();
    block_.resize(waiting_.size());
    for (std::size_t w = 0; w < count; ++w) {
      for (std::size_t d = 0; d < dimension; ++d) {
        block_[d * count + w] = waiting_[w * dimension + d];
      }
    }
  }

  void place_cut(Index from, Index to) {
    const double* a = sites_.at(from);
    const double* b = sites_.at(to);
    for (std::size_t d = 0; d < middle_.size(); ++d) {
      const double u = metric_.wrap(b[d] - a[d], static_cast<int>(d));
      normal_[d] = static_cast<Scalar>(u);
      middle_[d] = static_cast<Scalar>(a[d] + u / 2);
      if (!metric_.periodic()) continue;
      const Metric::Unrolled frame = metric_.unrolled(a[d] + u / 2, static_cast<int>(d));
      middle_[d] = static_cast<Scalar>(frame.origin);
      turn_[d] = static_cast<Scalar>(frame.turn);
    }
  }

  void keys_of(const Scalar* block, Index count, Scalar* keys) {
    const int dimension = metric_.dimension();
    if (metric_.periodic()) {
      kernels::keys(
          block, count, dimension,
          kernels::WrappedCut<Scalar>{middle_.data(), normal_.data(), turn_.data(), extent_.data()},
          keys);
    } else {
      kernels::keys(block, count, dimension, kernels::Cut<Scalar>{middle_.data(), normal_.data()},
                    keys);
    }
  }

  const Metric& metric_;
  const SiteState& sites_;
  Filling<Scalar>& filling_;
  Index from_ = -1;
  std::vector<Scalar> middle_;
  std::vector<Scalar> normal_;
  std::vector<Scalar> extent_;
  std::vector<Scalar> turn_;
  std::vector<Scalar> keys_;
  std::vector<Scalar> waiting_;  ///< coordinates of the excess of from_, point after point
  std::vector<Scalar> block_;
  std::vector<Choice> choices_;
};

template <class Scalar>
std::vector<Index> surpluses(const Filling<Scalar>& filling) {
  std::vector<Index> surplus(filling.filled.size());
  for (std::size_t s = 0; s < surplus.size(); ++s) {
    surplus[s] = filling.surplus(static_cast<Index>(s));
  }
  return surplus;
}

/// A site passes points on once all that flow to it have arrived; of such sites, the one that
/// became one last, as what it needs is still at hand.
template <class Scalar>
void flow_downhill(const SiteGraph& graph, const Arena& arena, Mover<Scalar>& mover,
                   Filling<Scalar>& filling) {
  const std::vector<double> phi = potential(graph, surpluses(filling), arena);
  const auto flow = [&](Index from, Index to) {
    const double drop = phi[static_cast<std::size_t>(from)] - phi[static_cast<std::size_t>(to)];
    return static_cast<Index>(std::clamp(std::nearbyint(drop), -1.0, 2147483647.0));
  };
  std::vector<Index> awaited(phi.size(), 0);
  for (Index s = 0; s < graph.site_count(); ++s) {
    for (const Index next : graph.neighbours(s)) {
      if (flow(s, next) >= 1) ++awaited[static_cast<std::size_t>(next)];
    }
  }
  std::vector<Index> ready;
  for (Index s = graph.site_count(); s-- > 0;) {
    if (awaited[static_cast<std::size_t>(s)] == 0) ready.push_back(s);
  }
  while (!ready.empty()) {
    const Index site = ready.back();
    ready.pop_back();
    filling.settle(site);
    mover.leave(site);
    for (const Index next : graph.neighbours(site)) {
      const Index count = flow(site, next);
      if (count < 1) continue;
      arena.check();
      mover.move(next, count);
      if (--awaited[static_cast<std::size_t>(next)] == 0) ready.push_back(next);
    }
    filling.settle(site);
  }
}

/// What a subtree has too much goes up to its parent; then what it lacks comes down. A site never
/// has to pass on more points than it has: see the order of both sweeps.
template <class Scalar>
void flow_along_tree(const SiteGraph& graph, const Arena& arena, Mover<Scalar>& mover,
                     Filling<Scalar>& filling) {
  const SiteGraph::SpanningTree tree = graph.spanning_tree();
  std::vector<Index> subtree = surpluses(filling);
  const auto parent = [&](Index s) { return tree.parent[static_cast<std::size_t>(s)]; };
  for (std::size_t k = tree.order.size(); k-- > 0;) {
    const Index s = tree.order[k];
    const Index surplus = subtree[static_cast<std::size_t>(s)];
    if (parent(s) < 0) {
      if (surplus != 0) throw std::logic_error("balance: surpluses do not sum to zero");
      continue;
    }
    subtree[static_cast<std::size_t>(parent(s))] += surplus;
    if (surplus <= 0) continue;
    arena.check();
    mover.leave(s);
    mover.move(parent(s), surplus);
  }
  for (const Index s : tree.order) {
    if (parent(s) < 0) continue;
    const Index lack = -subtree[static_cast<std::size_t>(s)];
    if (lack <= 0) continue;
    arena.check();
    mover.leave(parent(s));
    mover.move(s, lack);
  }
  for (const Index s : tree.order) filling.settle(s);
}

}  // namespace

template <class Scalar>
void balance(const Metric& metric, const SiteState& sites, std::span<const Pair> near,
             const Arena& arena, Filling<Scalar>& filling) {
  arena.check();
  const SiteGraph graph(sites.count(), gabriel_pairs(metric, sites, near));
  arena.check();
  Mover<Scalar> mover(metric, sites, filling);
  flow_downhill(graph, arena, mover, filling);
  flow_along_tree(graph, arena, mover, filling);
}

template void balance(const Metric&, const SiteState&, std::span<const Pair>, const Arena&,
                      Filling<float>&);
template void balance(const Metric&, const SiteState&, std::span<const Pair>, const Arena&,
                      Filling<double>&);

}  // namespace ccvt
