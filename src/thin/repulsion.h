#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "numbers.h"
#include "parallel/loops.h"
#include "thin/homes.h"
#include "thin/quotas.h"

namespace ccvt {

/// One chosen point a site, moved apart. Two chosen points at the distance d repel each other by
/// (1 - d / r)^8 where that is below their reach r, the mean of their homes': the weight by which
/// sample elimination orders its points [Yuksel 2015, eq. 2].
///
/// A move takes a site to the point near it, and not chosen by another, where it is repelled least.
/// Each round weighs the moves of all sites that may have one, at the same time, against the
/// choice as it is; then makes them one by one, the best first, where they still gain by then.
/// From one home to another none is made that Quotas do not allow: without, choices would go from
/// where the cloud is dense to beside it, as reaches are blurred there.
///
/// Termination. A move is made only when it lowers what repels its site, of which rounding is a
/// tiny share, by more than half of kLeastGain of it, and so it lowers the sum over all pairs: no
/// choice ever returns, and there are finitely many. That quotas forbid moves changes nothing of
/// that; in every round that has moves the best one is made, as nothing has changed by then.
template <class Scalar>
class Repulsion {
 public:
  /// `chosen`: of each site a place of its own. `homes` must outlive the object.
  Repulsion(const Homes<Scalar>& homes, std::vector<Place> chosen, const Arena& arena);

  /// Moves until no site can gain. False when the arena was stopped before: what is chosen by then
  /// is a choice like any other.
  bool run();

  [[nodiscard]] const std::vector<Place>& chosen() const { return chosen_; }
  [[nodiscard]] std::int64_t moves() const { return moves_; }
  [[nodiscard]] std::int64_t jumps() const { return jumps_; }
  [[nodiscard]] int rounds() const { return rounds_; }
  [[nodiscard]] const Quotas& quotas() const { return quotas_; }
  /// The sum over all pairs.
  [[nodiscard]] double energy() const;

 private:
  struct Move {
    double gain;
    SiteNumber site;
    Place to;
  };
  static bool by_gain(const Move& a, const Move& b) {
    return a.gain != b.gain ? a.gain > b.gain : a.site < b.site;
  }
  /// A place where little would be repelled.
  struct Gap {
    double repelled;
    Place place;
  };
  /// Chosen points that may repel what is in a home.
  struct Others {
    std::vector<SiteNumber> sites;
    std::vector<double> coordinates;
    std::vector<double> reach;
  };
  /// Those of a home, as long as nothing has moved since.
  struct Gathered {
    SiteNumber home = SiteNumber::none();
    int time = 0;
    Others others;
  };
  /// Of the homes that a worker looked at last: sites near each other look at the same ones.
  using Recent = std::vector<Gathered>;

  [[nodiscard]] const Scalar* at(SiteNumber site) const {
    return at_.data() + site * homes_.dimension();
  }
  [[nodiscard]] double repelled_by(const Others& others, SiteNumber site, const Scalar* at,
                                   double most) const;
  [[nodiscard]] double repelled(Place place, SiteNumber site) const;
  const Others& gather(SiteNumber home, Recent& recent) const;
  void weigh(SiteNumber site, Recent& recent, std::vector<Move>& moves) const;
  void weigh_gap(SiteNumber home, Recent& recent, std::vector<Gap>& gaps) const;
  void round();
  bool fill_gaps();
  bool make(const Move& move, double least_gain);
  void disturb(SiteNumber home);
  void enter(SiteNumber site, Place place);
  void leave(SiteNumber site, Place place);
  template <class Visit>
  void for_each_near(SiteNumber home, const Visit& visit) const;

  const Homes<Scalar>& homes_;
  const Arena& arena_;
  Quotas quotas_;
  std::vector<Place> chosen_;
  std::vector<Scalar> at_;            ///< where they are, one after the other
  std::vector<std::uint8_t> taken_;   ///< by place
  std::vector<SiteNumber> first_in_;  ///< by home: the last site that came; none() where empty
  std::vector<SiteNumber> next_in_;   ///< by site: another one in the same home
  std::vector<SiteNumber> restless_;  ///< sites that may have a move
  std::vector<std::uint8_t> is_restless_;
  PerWorker<Recent> recent_;
  int time_ = 0;  ///< when sites may have moved
  std::int64_t moves_ = 0;
  std::int64_t jumps_ = 0;
  int rounds_ = 0;
};

extern template class Repulsion<float>;
extern template class Repulsion<double>;

}  // namespace ccvt
