#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/types.h"
#include "exact/pricing.h"
#include "numbers.h"

namespace ccvt {

/// The site graph of an assignment: an edge from site i to site j weighs what it costs at least to
/// move a point from i to j, without weights, over the points of i that have an offer of j. A point
/// with offers brings them along when it moves.
///
/// Moves points along shortest paths from sites with too many to sites with too few [successive
/// shortest paths: Jewell 1958, Busacker, Gowen 1960; with potentials: Edmonds, Karp 1972]. The
/// potentials are the sites' weights: all reduced costs stay at least zero, so that the assignment
/// is optimal among the offers when capacities are met.
///
/// Capacities may float: all are then floor(m / n) or one more, and which sites have one more is
/// part of the problem. A hub stands for handing that on: site b with less reaches the hub, and the
/// hub every site a with more, at the reduced cost w_b - w_a in all.
class ExchangeGraph {
 public:
  /// `owners`, `weights` and floating `capacities` are kept up to date while points move. Floating
  /// ones must be largest where weights are least.
  ExchangeGraph(std::vector<Index>& capacities, bool floating, std::vector<Index>& owners,
                std::vector<double>& weights);

  void add(const Offer& offer);
  /// Points that a site owns beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(SiteNumber site) const { return count_[site] - capacities_[site]; }

  enum class Outcome {
    settled,    ///< no site has too many points
    exhausted,  ///< some have, but no weight may fall further
    closed,     ///< no path leaves the sites that reached() lists: they need more offers
  };
  /// Moves points along shortest paths, as long as no weight falls by more than `budget` since the
  /// start. With all offers of at most that slack at hand, no other offer matters.
  Outcome settle(double budget, const Arena& arena = Arena(1));
  [[nodiscard]] std::span<const SiteNumber> reached() const { return settled_; }
  /// What reached() calls the hub, which is no site.
  [[nodiscard]] SiteNumber hub() const { return SiteNumber(cells_.size()); }
  /// Lets the weights of the sites that reached() lists fall by `amount` at no charge.
  void lower_reached(double amount);
  /// How many points went their way so far.
  [[nodiscard]] std::int64_t augmentations() const { return augmentations_; }

 private:
  static constexpr std::size_t kNoOption = std::numeric_limits<std::size_t>::max();
  static constexpr PointNumber kNoPoint{-1};
  /// An offer of a point, in a list of its own; the first offer is of the owner it came with.
  struct Option {
    SiteNumber to;
    std::size_t next;  ///< option of the point, or kNoOption
    double key;        ///< what `to` costs more than that first owner
  };
  /// What moving a point along an edge costs; stale when the point has moved on.
  struct Entry {
    double key;
    PointNumber point;
    bool operator==(const Entry& other) const { return key == other.key && point == other.point; }
    bool operator<(const Entry& other) const {
      return key != other.key ? key < other.key : point < other.point;
    }
    bool operator>(const Entry& other) const { return other < *this; }
  };
  struct Cell {
    // Edges, one in each slot.
    std::vector<SiteNumber> to;
    std::vector<double> least;  ///< infinite: no point has an offer left
    std::vector<PointNumber> least_point;
    std::vector<std::vector<Entry>> heap;  ///< the least in front
    std::size_t entries = 0;
    std::size_t stale = 0;
  };

  [[nodiscard]] SiteNumber owner_of(PointNumber point) const { return SiteNumber(owners_[point]); }
  static std::size_t slot_of(Cell& cell, SiteNumber to);
  std::size_t loading_slot(SiteNumber site, SiteNumber to);
  void load();
  void insert(SiteNumber site, SiteNumber to, const Entry& entry);
  void refresh(SiteNumber site, std::size_t slot);
  void sweep(SiteNumber site);
  void move(PointNumber point, SiteNumber from, SiteNumber to);
  enum class Search { found, exhausted, closed };
  /// Shortest paths from `source`, up to the first site with too few points: settled_.back().
  Search find_path(SiteNumber source, double budget, double& length);
  void relax(SiteNumber from, std::size_t slot, SiteNumber to, double distance);
  void lower_weights(double length);
  [[nodiscard]] bool has_more(SiteNumber site) const { return capacities_[site] > least_capacity_; }
  void move_along_path(SiteNumber source, SiteNumber target);

  std::vector<Index>& capacities_;
  bool floating_;
  Index least_capacity_ = 0;
  double hub_weight_ = 0;
  std::vector<Index>& owners_;
  std::vector<double>& weights_;
  std::vector<Cell> cells_;
  std::vector<Option> options_;
  std::vector<std::size_t> first_option_;  ///< of each point, or kNoOption
  std::vector<double> own_key_;  ///< of each point: what its owner costs more than its first
  /// Until settle() is first called, heaps have no order: see load().
  bool loading_ = true;
  SiteNumber loading_site_ = SiteNumber::none();  ///< the site of the last offer
  std::vector<std::size_t> loading_slots_;        ///< of that site's edges, by where they lead
  std::vector<Index> count_;
  std::vector<double> start_;  ///< the weights that budgets count from
  std::int64_t augmentations_ = 0;

  std::vector<double> distance_;
  /// The site before on the path, and the slot of the edge; none along edges of the hub.
  std::vector<std::pair<SiteNumber, std::size_t>> parent_;
  std::vector<std::uint8_t> state_;  ///< 0: not seen, 1: seen, 2: settled
  std::vector<SiteNumber> seen_;
  std::vector<SiteNumber> settled_;
  std::vector<std::pair<double, SiteNumber>> heap_;
};

}  // namespace ccvt
