#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "ccvt/types.h"
#include "exact/cell_bounds.h"
#include "exact/move_costs.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/bytes.h"
#include "parallel/rank_part.h"
#include "parallel/rank_turns.h"

namespace ccvt {

/// The site graph of an assignment: an edge from site i to site j weighs what it costs at least to
/// move a point from i to j, without weights.
///
/// Moves points along shortest paths from sites with too many to sites with too few [successive
/// shortest paths: Jewell 1958, Busacker, Gowen 1960; with potentials: Edmonds, Karp 1972]. The
/// potentials are the sites' weights: all reduced costs stay at least zero, so that the assignment
/// is optimal when capacities are met.
///
/// Of all n^2 edges only those are weighed that a search may take: of the others a lower bound is
/// known, and it is by bounds that a search looks for them. What it finds is the same whatever the
/// bounds: of ways that are as short it takes the one of lowest numbers.
///
/// Capacities may float: all are then floor(m / n) or one more, and which sites have one more is
/// part of the problem. A hub stands for handing that on: site b with less reaches the hub, and the
/// hub every site a with more, at the reduced cost w_b - w_a in all.
class ExchangeGraph {
 public:
  /// `owners`, every point's cheapest site, `weights` and floating `capacities` are kept up to date
  /// while points move. Floating ones must be largest where weights are least. `kept`: bounds of
  /// what the cells were before some points came and went; they cover the cells when all settled.
  ///
  /// `part`: points, owners and bounds that are kept are those of a rank. All ranks then make the
  /// same calls, and search the same: for what edges weigh, and for the positions of points that
  /// move, they ask each other. Where all have all points, they take turns in bounding cells, as
  /// in keeping bounds, and tell each other the edges found. See exchange_ranks.cpp.
  ExchangeGraph(std::vector<Index>& capacities, bool floating, std::vector<Index>& owners,
                std::vector<double>& weights, MoveCosts& costs, CellBounds* kept = nullptr,
                const RankPart& part = {});

  ExchangeGraph(const ExchangeGraph&) = delete;
  ExchangeGraph& operator=(const ExchangeGraph&) = delete;

  /// Moves points along shortest paths until no site has too many. Each costs O(E log E) with E
  /// edges that searches see, and O(n D) for each point that moves, at worst. The edges of a site
  /// are bounded in O(n D) a point, or a point that came where bounds are kept. Ranks that the
  /// arena divides loops among share the work, unless each has points of its own.
  void settle(const Arena& arena = Arena(1));
  /// How many points went their way so far.
  [[nodiscard]] std::int64_t augmentations() const { return augmentations_; }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  static constexpr std::int32_t kNotWeighed = -1;
  /// Slots that are looked at or passed over together.
  static constexpr std::size_t kPage = 8;
  /// What moving a point along an edge costs.
  struct Move {
    double cost;
    Index point;  ///< its number among those of all ranks
    auto operator<=>(const Move&) const = default;
  };
  /// The cheapest moves along an edge, in ascending order; no other is before `beyond`.
  struct Moves {
    std::vector<Move> cheapest;
    Move beyond = {kNone, 0};
    std::size_t kept = 1;  ///< next time; how many are known changes no result
  };
  struct Cell {
    Index size = 0;                    ///< of all ranks
    std::vector<PointNumber> members;  ///< of this one
    bool bounded = false;              ///< what follows is there
    bool tight = false;                ///< a product has bounded all edges
    bool costed = false;               ///< what its points cost is known
    std::size_t weighings = 0;         ///< of one edge or of several at once
    // Edges, one in each slot.
    std::vector<SiteNumber> to;
    std::vector<double> bound;          ///< what moving a point there costs at least
    std::vector<std::int32_t> weighed;  ///< of `moves`, or kNotWeighed
    std::vector<Moves> moves;
    /// Of the slots of a page and all after it, the least bound less the site's weight, or less.
    std::vector<double> page;
    /// What moving a point to any other site costs at least, less that site's weight.
    double rest = kNone;
  };
  /// What a search looks at next. `what`: kSite or kTarget for the site itself; the slot of an edge
  /// that is not weighed yet; kRest for its edges that are in no slot; less than that for those in
  /// slots from a page on, see step_of_page().
  struct Step {
    double distance;
    SiteNumber site;
    std::int32_t what;
    bool operator>(const Step& other) const {
      return std::tuple(distance, what, site) > std::tuple(other.distance, other.what, other.site);
    }
  };
  /// Last of those at the same distance: when a site is settled, all ways there that are as short
  /// have been looked at. Sites with too few points, where a search ends, come before others.
  static constexpr std::int32_t kSite = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int32_t kTarget = kSite - 1;
  static constexpr std::int32_t kRest = -1;
  [[nodiscard]] static std::int32_t step_of_page(std::size_t page) {
    return kRest - 1 - static_cast<std::int32_t>(page);
  }
  [[nodiscard]] static std::size_t page_of_step(std::int32_t what) {
    return static_cast<std::size_t>(kRest - 1 - what);
  }

  /// How a search came to a site: from another, by moving a point. None moves to or from the hub.
  struct Way {
    SiteNumber from;
    Index point;
    auto operator<=>(const Way&) const = default;
  };
  static constexpr Index kNoPoint = -1;
  /// A point that moves, and what it is called where its position is asked for.
  struct Mover {
    Index point;
    PointNumber place;
    SiteNumber from;
    SiteNumber to;
  };

  /// Points that a site owns beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(SiteNumber site) const {
    return cells_[site].size - capacities_[site];
  }
  [[nodiscard]] Index number(PointNumber own) const {
    return static_cast<Index>(part_.first) + own.index();
  }
  [[nodiscard]] bool is_own(PointNumber place) const { return place < owners_.size(); }
  [[nodiscard]] SiteNumber hub() const { return SiteNumber(cells_.size()); }
  [[nodiscard]] bool has_more(SiteNumber site) const { return capacities_[site] > least_capacity_; }
  /// A bound less the weight of the site that an edge leads to.
  struct Edge {
    double reduced;
    SiteNumber to;
    double bound;
    auto operator<=>(const Edge&) const = default;
  };
  struct Scratch {
    MoveCosts::Scratch costs;
    std::vector<double> reduced;
    std::vector<Edge> edges;
    double rest = kNone;                ///< as in Cell, of those that are not among the edges
    std::vector<std::int32_t> weighed;  ///< of each site, as in Cell
    std::vector<double> own;
    std::vector<PointNumber> nearest;
    std::vector<SiteNumber> others;
    std::vector<double> there;
    std::vector<double> here;   ///< what members cost where they are
    std::vector<double> least;  ///< squares of members, for one edge after the other
    std::vector<double> slack;  ///< of each of these edges
  };
  void bound_all_edges(const Arena& arena);
  void bound_edges(SiteNumber site, std::size_t edges, Scratch& scratch);
  void find_edges(SiteNumber site, std::size_t edges, Scratch& scratch);
  void find_costs(SiteNumber site, Scratch& scratch);
  [[nodiscard]] static double about(std::size_t edges, Scratch& scratch);
  [[nodiscard]] static double ranked(std::span<const double> values, std::size_t step,
                                     std::size_t rank, std::vector<double>& sample);
  static void keep_nearest(std::size_t edges, Scratch& scratch);
  void set_edges(SiteNumber site, Scratch& scratch);
  void tighten(SiteNumber site);
  Moves& moves_of(SiteNumber site, std::size_t slot);
  Moves& weigh(SiteNumber site, std::size_t slot);
  void weigh_own(SiteNumber site);
  void find_least(std::span<const PointNumber> members, std::span<const SiteNumber> sites);
  void keep_cheapest(SiteNumber site, std::size_t slot, std::span<double> least, double slack);
  static double at_least(std::span<const double> values, std::size_t count, Scratch& scratch);
  Move find_nearest(const Cell& cell, std::size_t count, std::span<double> least, double slack);
  [[nodiscard]] std::size_t moves_kept(SiteNumber site) const;
  void set_weighed(SiteNumber site, std::size_t slot);
  void choose_slots(SiteNumber site, std::size_t slot, std::size_t most);
  double find_path(SiteNumber source, const Arena& arena);
  [[nodiscard]] bool settled(SiteNumber site) const { return limit_[site] == -kNone; }
  [[nodiscard]] static bool is_weighed(const Cell& cell, std::size_t slot);
  [[nodiscard]] bool may_matter(SiteNumber from, SiteNumber to, double distance) const;
  void relax_edge(SiteNumber from, std::size_t slot);
  void reach_directly(SiteNumber source);
  void relax_hub();
  void relax_edges(SiteNumber from, std::size_t page, double looked_at);
  [[nodiscard]] double lowered(double base, double reduced) const;
  void relax(const Way& way, SiteNumber to, double distance);
  void push(const Step& step);
  void lower_weights(double length);
  void move_along_path(SiteNumber source, SiteNumber target);
  void move(const Mover& mover);
  void remove(const Mover& mover);
  void insert(const Mover& mover);
  void add_to_slots(const Mover& mover);
  void add_to_all(const Mover& mover);
  void add_move(SiteNumber site, std::size_t slot, const Move& move);
  void lower_rest(Cell& cell, double own, std::span<const double> squared);
  void lower_rest(Cell& cell, const Mover& mover, double before, double own);
  [[nodiscard]] std::size_t slots_of_each() const;
  // Of all ranks.
  void bound_all_together(const Arena& arena);
  void bound_all_in_turns(const Arena& arena);
  void find_edges_in_turns(SiteNumber site, std::size_t edges, Scratch& scratch);
  void get_edges(ByteReader& message, Scratch& scratch) const;
  void find_edges_together(std::size_t edges, Scratch& scratch) const;
  static void put_edges(ByteWriter& message, const Scratch& scratch);
  void join_edges(std::span<ByteReader> ranks, std::size_t edges, Scratch& scratch) const;
  void weigh_together(SiteNumber site, std::size_t slot);
  void bring(std::vector<Mover>& movers);

  std::vector<Index>& capacities_;
  bool floating_;
  Index least_capacity_ = 0;
  double hub_weight_ = 0;
  double largest_weight_ = 0;  ///< of all that weights have been
  std::vector<Index>& owners_;
  std::vector<double>& weights_;
  MoveCosts& costs_;
  CellBounds* kept_;
  RankPart part_;
  Ranks* sharing_ = nullptr;  ///< where all have all points
  RankTurns turns_;
  const Arena* arena_ = nullptr;  ///< while paths are looked for
  std::vector<Cell> cells_;
  double moves_expected_ = 0;  ///< along an edge, about
  std::vector<double> own_storage_;
  std::vector<double>& own_cost_;  ///< of each point, in a cell that is bounded
  Scratch scratch_;
  std::vector<std::uint8_t> in_slot_;
  std::int64_t augmentations_ = 0;

  double nearest_ = kNone;  ///< distance of the nearest site with too few points that was reached
  SiteNumber end_;          ///< that site, the lowest of those at this distance
  std::vector<double> distance_;
  /// How long a way there may be to be looked at: no longer than the shortest so far. None is, of
  /// what is settled.
  std::vector<double> limit_;
  std::vector<Way> way_;
  std::vector<SiteNumber> seen_;
  std::vector<SiteNumber> settled_;
  std::vector<std::size_t> slots_;  ///< of edges that are weighed together
  std::vector<Mover> movers_;       ///< along the path at hand, from its end
  std::vector<Step> heap_;
};

}  // namespace ccvt
