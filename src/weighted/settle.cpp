#include "weighted/settle.h"

#include <vector>

namespace ccvt {
namespace {

/// Of the bound: what is no more counts as nothing.
constexpr double kNothing = 2e-9;

/// Pushing of points, or pulling with the signs of all errors reversed.
template <class Scalar>
class Settling {
 public:
  Settling(MassCells<Scalar>& cells, const SiteGraph& graph, bool pulls)
      : cells_(cells),
        graph_(graph),
        pulls_(pulls),
        bound_(cells.error_bound()),
        nothing_(kNothing * cells.heaviest()) {}

  void run() {
    while (has_excess() && find_paths()) round();
  }

 private:
  static constexpr SiteNumber kRoot = SiteNumber::none();
  static constexpr SiteNumber kUnknown{-2};

  [[nodiscard]] double excess(SiteNumber s) const {
    return pulls_ ? -cells_.error(s) : cells_.error(s);
  }
  [[nodiscard]] bool has_room(SiteNumber s) const { return excess(s) < -nothing_; }

  [[nodiscard]] bool has_excess() const {
    for (const SiteNumber s : cells_.sites().all()) {
      if (excess(s) >= bound_) return true;
    }
    return false;
  }

  /// The way from each cell to the nearest one with room. False when none has any.
  bool find_paths() {
    parent_.assign(cells_.site_count(), kUnknown);
    order_.clear();
    for (const SiteNumber s : cells_.sites().all()) {
      if (!has_room(s)) continue;
      parent_[s] = kRoot;
      order_.push_back(s);
    }
    for (std::size_t next = 0; next < order_.size(); ++next) {
      const SiteNumber s = order_[next];
      for (const SiteNumber t : graph_.neighbours(s)) {
        if (parent_[t] != kUnknown) continue;
        parent_[t] = s;
        order_.push_back(t);
      }
    }
    return !order_.empty();
  }

  /// From the farthest cells to the nearest ones.
  void round() {
    for (std::size_t k = order_.size(); k-- > 0;) {
      while (parent_[order_[k]] != kRoot && excess(order_[k]) >= bound_ && pass_on(order_[k])) {
      }
    }
  }

  /// One point on its way, from a cell to its parent or, pulling, the other way round. False when
  /// there is no room at the end of the way.
  bool pass_on(SiteNumber site) {
    const SiteNumber parent = parent_[site];
    if (parent_[parent] == kRoot && !has_room(parent)) return false;
    if (!pulls_) {
      move_one(site, parent);
      return true;
    }
    if (cells_.members(parent).empty() && !(parent_[parent] != kRoot && pass_on(parent))) {
      return false;
    }
    move_one(parent, site);
    return true;
  }

  /// The point that wants it most by its key.
  void move_one(SiteNumber from, SiteNumber to) {
    const Metric& metric = cells_.metric();
    const auto key = [&](PointNumber p) {
      return metric.squared_distance(cells_.at(p), cells_.sites().at(from)) -
             metric.squared_distance(cells_.at(p), cells_.sites().at(to));
    };
    PointNumber best = cells_.members(from).front();
    double highest = key(best);
    for (const PointNumber p : cells_.members(from)) {
      const double own = key(p);
      if (own <= highest) continue;
      best = p;
      highest = own;
    }
    cells_.move(best, from, to);
  }

  MassCells<Scalar>& cells_;
  const SiteGraph& graph_;
  bool pulls_;
  double bound_;
  double nothing_;
  std::vector<SiteNumber> parent_;
  std::vector<SiteNumber> order_;
};

}  // namespace

template <class Scalar>
void settle(MassCells<Scalar>& cells, const SiteGraph& graph) {
  for (const bool pulls : {false, true}) Settling<Scalar>(cells, graph, pulls).run();
}

template void settle(MassCells<float>&, const SiteGraph&);
template void settle(MassCells<double>&, const SiteGraph&);

}  // namespace ccvt
