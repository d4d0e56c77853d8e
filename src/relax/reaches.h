#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/loops.h"
#include "relax/cells.h"
#include "relax/screen_cells.h"
#include "relax/site_state.h"
#include "schedule/pair.h"
#include "schedule/tiling.h"

namespace ccvt {

template <class Scalar>
struct ReachSteps;

/// For each cell and each site, no less than the cell's reach for the site: the largest of
/// |p - s_i|^2 - |p - s_j|^2 over the points p of cell i. Kept from pass to pass, so that a pass
/// multiplies only cells and sites that may have come to gain [Elkan 2003, where points have bounds
/// on distances; here cells have]. n^2 scalars, and a number for each point; where several ranks
/// have the tiles, each keeps the reaches of its own cells, and is told those of other cells for
/// its sites when it asks which pairs may gain.
///
/// When sites move, |p - s_i|^2 grows by what it does over the points of cell i, and |p - s_j|^2
/// changes by what it does seen from site i, less twice the farthest point's distance times the
/// step at most. The reaches of a point that comes are computed.
template <class Scalar>
class Reaches {
 public:
  /// Of so many pairs of sites at most, for there is to be memory: 64 MB of floats.
  static constexpr std::size_t kMostPairs = std::size_t{1} << 24;

  Reaches(const Cells<Scalar>& cells, const Tiling& tiling);

  /// Of an own cell, by site.
  [[nodiscard]] Scalar* of(SiteNumber site) { return reach_.data() + row_of(site) * count_; }
  [[nodiscard]] const Scalar* of(SiteNumber site) const {
    return reach_.data() + row_of(site) * count_;
  }
  /// False before all have been set, or when they have been forgotten.
  [[nodiscard]] bool known() const { return known_; }
  void forget() { known_ = false; }
  /// All have been set, for these cells and sites.
  void set_known(const Cells<Scalar>& cells, const SiteState& sites, const Arena& arena);

  /// The pairs that may gain by what is known, one of which is touched, in any order. All ranks.
  Buffer<Pair> known_gaining(const std::vector<std::uint8_t>& touched, const Arena& arena);
  /// The same by the cells and sites as they are now. O(n^2 D), besides what may gain by what is
  /// known.
  Buffer<Pair> gaining(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                       const CentredSites<Scalar>& centred,
                       const std::vector<std::uint8_t>& touched, const Arena& arena);

 private:
  /// A point that came to a cell since.
  struct Came {
    SiteNumber site;
    std::size_t place;
  };
  struct Arrival;

  [[nodiscard]] std::size_t row_of(SiteNumber site) const { return site - *own_.begin(); }
  [[nodiscard]] std::uint8_t* marks_of(SiteNumber site) {
    return marked_.data() + row_of(site) * count_;
  }
  /// Of an own site i, by what exchange() has brought where there are ranks.
  [[nodiscard]] bool may_gain(SiteNumber i, SiteNumber j) const {
    const Scalar back = ranks_ == nullptr ? of(j)[i] : back_[row_of(i) * count_ + j];
    return !(of(i)[j] + back <= 0);
  }
  template <class Wanted>
  void exchange(const Wanted& wanted);
  Buffer<Pair> marked_gaining(const Arena& arena);
  void follow(const Cells<Scalar>& cells, const SiteState& sites,
              const CentredSites<Scalar>& centred, const std::vector<std::uint8_t>& touched,
              const Arena& arena);
  void follow_steps(const ReachSteps<Scalar>& steps, SiteNumber i, double grows,
                    const float* products, const std::vector<SiteNumber>* touched);
  void include(const ReachSteps<Scalar>& steps, const Arrival& point, const float* products);
  void mark(const std::vector<std::uint8_t>& touched, const Arena& arena);

  std::size_t count_;
  NumberRange<SiteNumber> own_;
  Ranks* ranks_;
  std::vector<int> rank_of_;  ///< by site
  bool known_ = false;
  std::vector<Scalar> reach_;         ///< of own cell i for site j at [row_of(i) * n + j]
  std::vector<Scalar> back_;          ///< likewise of cell j for own site i, where there are ranks
  std::vector<std::uint8_t> marked_;  ///< likewise, what is to be computed
  std::vector<double> position_;      ///< of the sites that reaches are for
  std::vector<PointOfAll> counted_;   ///< the points that reaches count, own cell by cell
  std::vector<std::size_t> first_;    ///< of each own cell, where its points begin
};

extern template class Reaches<float>;
extern template class Reaches<double>;

}  // namespace ccvt
