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
#include "schedule/schedule.h"

namespace ccvt {

/// For each cell and each site, no less than the cell's reach for the site: the largest of
/// |p - s_i|^2 - |p - s_j|^2 over the points p of cell i. Kept from pass to pass, so that a pass
/// multiplies only cells and sites that may have come to gain [Elkan 2003, where points have bounds
/// on distances; here cells have]. n^2 scalars, and a number for each point; of one
/// process.
///
/// When sites move, |p - s_i|^2 grows by what it does over the points of cell i, and |p - s_j|^2
/// changes by what it does seen from site i, less twice the farthest point's distance times the
/// step at most. The reaches of a point that comes are computed.
template <class Scalar>
class Reaches {
 public:
  /// Whether there is memory for them.
  [[nodiscard]] static bool fit(std::size_t sites);

  explicit Reaches(const Cells<Scalar>& cells);

  [[nodiscard]] Scalar* of(SiteNumber site) { return reach_.data() + site * count_; }
  [[nodiscard]] const Scalar* of(SiteNumber site) const { return reach_.data() + site * count_; }
  /// False before all have been set, or when they have been forgotten.
  [[nodiscard]] bool known() const { return known_; }
  void forget() { known_ = false; }
  /// All have been set, for these cells and sites.
  void set_known(const Cells<Scalar>& cells, const SiteState& sites, const Arena& arena);

  /// The pairs that may gain, one of which is touched, in any order. O(n^2 D), besides what may
  /// gain by what is known.
  Buffer<Pair> gaining(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                       const CentredSites<Scalar>& centred,
                       const std::vector<std::uint8_t>& touched, const Arena& arena);

 private:
  /// A point that came to a cell since.
  struct Came {
    SiteNumber site;
    std::size_t place;
  };
  struct Steps;
  struct Arrival;

  [[nodiscard]] bool may_gain(SiteNumber i, SiteNumber j) const {
    return !(of(i)[j] + of(j)[i] <= 0);
  }
  void follow(const Cells<Scalar>& cells, const SiteState& sites,
              const CentredSites<Scalar>& centred, const std::vector<std::uint8_t>& touched,
              const Arena& arena);
  void follow_steps(const Steps& steps, SiteNumber i, double grows, const float* products,
                    const std::vector<SiteNumber>* touched);
  void include(const Steps& steps, const Arrival& point, const float* products);
  void mark(const std::vector<std::uint8_t>& touched, const Arena& arena);

  std::size_t count_;
  bool known_ = false;
  std::vector<Scalar> reach_;         ///< of cell i for site j at [i * n + j]
  std::vector<std::uint8_t> marked_;  ///< likewise, what is to be computed
  std::vector<double> position_;      ///< of the sites that reaches are for
  std::vector<PointNumber> counted_;  ///< the points that reaches count, cell by cell
  std::vector<std::size_t> first_;    ///< of each cell, where its points begin
};

extern template class Reaches<float>;
extern template class Reaches<double>;

}  // namespace ccvt
