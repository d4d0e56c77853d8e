#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "ccvt/options.h"
#include "geometry/metric.h"
#include "relax/bands.h"
#include "relax/cells.h"
#include "relax/pair_cut.h"
#include "relax/patches.h"
#include "relax/site_state.h"

namespace ccvt {

/// A point that may change its owner, and how much it would like to: its energy at site i less its
/// energy at site j, halved [eq. 6].
struct Candidate {
  double key;
  Index place;
};

/// What to exchange: the k-th place of `from_i` with the k-th place of `from_j`.
struct Exchange {
  std::vector<Candidate> from_i;
  std::vector<Candidate> from_j;

  struct Choice {
    double key;
    Index place;
    bool from_j;
  };
  std::vector<Choice> both;  ///< scratch memory, kept between swaps

  void clear() {
    from_i.clear();
    from_j.clear();
  }
};

/// Reduces the candidates to those that move: the k points of cell i with the highest keys and the
/// k points of cell j with the lowest, for the greatest k at which each exchange still gains more
/// than `margin`. Expected linear time for SwapMethod::median [4.1, Program 3]; SwapMethod::heap is
/// the swap of 2009 [Program 1].
void select_exchange(SwapMethod method, double margin, Exchange& candidates);

/// Makes pairs of cells optimal [Programs 1 and 3]. One per worker: it owns scratch memory.
///
/// Termination. Let F be the energy of an assignment with every site at the exact centroid of its
/// cell (on a torus: of its points' images nearest to it). An exchange is made only when its gain,
/// computed in double, exceeds `margin`, which bounds (a) the rounding of the two keys and (b) the
/// sum over both cells of size * e^2, where e bounds the distance between a site and the exact
/// centroid that it was rounded from. By (a) every exchange lowers the energy for the sites of the
/// pass. By (b) a pass that made an exchange lowers it by more than sum size * e^2 over all changed
/// cells, which is what rounding can have put between that energy and F: so F falls from each pass
/// that exchanges points to the next; no assignment (on a torus: with its choice of images) ever
/// returns, and there are finitely many.
/// Ties and duplicate points gain nothing and never move.
template <class Scalar>
class PairSwapper {
 public:
  PairSwapper(const Metric& metric, const Options& options, double coordinate_bound);

  /// Makes the pair (i, j) optimal; returns how many points of each cell changed owner. Radii
  /// remain upper bounds. Touches nothing but the two cells, their patches, the state of the two
  /// sites, and what is known of the pair. With `bands`, where that is kept, only the points near
  /// the cut of large cells are looked at, or none; the result is the same.
  Index operator()(Cells<Scalar>& cells, Patches<Scalar>& patches, SiteState& sites, SiteNumber i,
                   SiteNumber j, Bands<Scalar>* bands = nullptr);

  /// Whether the last call put the points of the cells i and j into another order first.
  struct Sorted {
    bool i = false;
    bool j = false;
  };
  [[nodiscard]] Sorted sorted() const { return sorted_; }
  /// What the last call exchanged, if it did.
  [[nodiscard]] const Exchange& moved() const { return moves_; }

  /// Whether the bounding spheres of two sites meet [5.1, eq. 7].
  [[nodiscard]] static bool spheres_meet(const Metric& metric, const SiteState& sites, SiteNumber i,
                                         SiteNumber j) {
    const double reach = sites.radius[i] + sites.radius[j];
    return metric.squared_distance(sites.at(i), sites.at(j)) <= reach * reach;
  }

 private:
  /// Bounds on the keys of a pair that decide what can move.
  struct KeyBounds {
    double highest_i;
    double lowest_j;
    /// Median-cut pruning [5.2]: no key of cell i is above any key of cell j.
    [[nodiscard]] bool separated() const { return highest_i <= lowest_j; }
  };
  using Side = typename PairCut<Scalar>::Side;
  /// Of a cell of the pair, consecutive points that must be looked at.
  struct Stretch {
    double bound;  ///< on their keys, from the side of the cut
    Index first;
    Index count;
  };
  /// What is looked at of a cell: patches near the cut, or all.
  struct Part {
    bool divided = false;
    std::vector<double> bounds;  ///< of each patch
    Index size = 0;              ///< of a patch
    std::vector<Stretch> stretches;
  };
  void divide(const Patches<Scalar>& patches, SiteNumber cell, Side side, Part& part);
  /// Which keys of a side are those of points that may move.
  [[nodiscard]] static kernels::Beyond beyond(Side side) {
    return side == Side::i ? kernels::Beyond::above : kernels::Beyond::below;
  }
  [[nodiscard]] static bool is_beyond(Side side, double key, double threshold) {
    return side == Side::i ? key > threshold : key < threshold;
  }
  static void choose(Side side, Index points, double known, Part& part);
  KeyBounds key_bounds(const Cells<Scalar>& cells, SiteNumber i, SiteNumber j);
  KeyBounds key_bounds_by_patches(const Cells<Scalar>& cells, SiteNumber i, SiteNumber j);
  void find_candidates(const Cells<Scalar>& cells, const SiteState& sites, SiteNumber i,
                       SiteNumber j, const KeyBounds& bounds);
  Index within_reach(const Cells<Scalar>& cells, const SiteState& sites, SiteNumber cell,
                     SiteNumber other);
  Index find_beyond(const Cells<Scalar>& cells, SiteNumber cell, Side side, const Part& part,
                    Scalar threshold);
  void select(const Cells<Scalar>& cells, const SiteState& sites, SiteNumber i, SiteNumber j);
  void search(const Cells<Scalar>& cells, const Patches<Scalar>& patches, const SiteState& sites,
              SiteNumber i, SiteNumber j);
  [[nodiscard]] bool looks_at_bounds() const {
    return median_cut_ || pruning_ == PointPruning::extremes;
  }

  // Of bands: see swap_bands.cpp.
  bool within_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                   const SiteState& sites, SiteNumber i, SiteNumber j, KnownPair<Scalar>& known);
  bool follow(Side side, const Patches<Scalar>& patches, SiteNumber cell, BandSide<Scalar>& band);
  /// Of one cell of a pair, the points that are in its band.
  struct NearPoints {
    Side side;
    kernels::Cut<Scalar> cut;
    const Scalar* block;
    Index stride;
    Index count;
    const Index* places;                      ///< in the cell; null: all
    typename PairCut<Scalar>::Bounds others;  ///< on the keys of all other points
  };
  NearPoints near_points(Side side, const Cells<Scalar>& cells, SiteNumber cell,
                         const BandSide<Scalar>& band) const;
  double extreme(const NearPoints& near) const;
  void near_candidates(const NearPoints& near, double opposite, double others,
                       std::vector<Candidate>& candidates);
  bool search_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                   const SiteState& sites, SiteNumber i, SiteNumber j, KnownPair<Scalar>& known);
  [[nodiscard]] double level() const;
  bool has_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches, SiteNumber i,
                SiteNumber j) const;
  void note_search(KnownPair<Scalar>& known) const;
  void make_band(const Cells<Scalar>& cells, const Patches<Scalar>& patches, SiteNumber i,
                 SiteNumber j, Band<Scalar>& band);
  bool copy_band(Side side, const Cells<Scalar>& cells, const Patches<Scalar>& patches,
                 SiteNumber cell, SiteNumber other, double level, Part& part,
                 BandSide<Scalar>& band);

  void make_room(std::size_t places) { places_.resize(std::max(places_.size(), places)); }
  void exchange(Cells<Scalar>& cells, Patches<Scalar>& patches, SiteState& sites, SiteNumber i,
                SiteNumber j);

  const Metric& metric_;
  SwapMethod method_;
  PointPruning pruning_;
  bool median_cut_;
  double coordinate_bound_;
  PairCut<Scalar> cut_;  ///< of the current pair
  Part part_i_;
  Part part_j_;
  KeyBounds bounds_{};
  double margin_ = 0;  ///< of the last selection
  Sorted sorted_;
  typename Patches<Scalar>::Scratch scratch_;
  std::vector<Scalar> coordinates_;  ///< of two points
  std::vector<double> per_point_;    ///< exact keys, or squared distances, of one cell
  std::vector<Index> places_;        ///< points of one cell, found last
  std::vector<Index> places_left_;   ///< of changes
  Exchange moves_;
  Exchange known_;  ///< what moves_ was selected from, of a band
};

extern template class PairSwapper<float>;
extern template class PairSwapper<double>;

}  // namespace ccvt
