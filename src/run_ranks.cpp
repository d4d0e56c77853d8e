// What a run does where several ranks make it together.
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cell_sizes.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/alike.h"
#include "parallel/bytes.h"
#include "parallel/pages.h"
#include "parallel/together.h"
#include "run.h"
#include "run_identity.h"

namespace ccvt {

namespace {

/// Which ranks have the points.
class Homes {
 public:
  Homes(Ranks& ranks, std::int64_t first_own_point) : first_(of_all(&ranks, first_own_point)) {}
  [[nodiscard]] std::size_t ranks() const { return first_.size(); }
  struct Home {
    std::size_t rank;
    PointNumber point;  ///< of that rank's
  };
  [[nodiscard]] Home operator()(PointOfAll point) const {
    // The last rank that begins there or before: others there have no points.
    const auto after = std::upper_bound(first_.begin(), first_.end(), point.index());
    return {static_cast<std::size_t>(after - first_.begin() - 1),
            PointNumber(point.index() - *std::prev(after))};
  }

  /// Calls visit(sites) on all ranks for each rank's own sites, a run of them at a time or none,
  /// until no rank has more: so few that a rank which all of them ask can answer.
  template <class Scalar, class Visit>
  void for_parts(const Tiling& tiling, const Cells<Scalar>& cells, const Visit& visit) const {
    constexpr Index kPointsAtOnce = 1 << 21;  // of all ranks
    const NumberRange<SiteNumber> own = tiling.own_sites();
    SiteNumber next = *own.begin();
    while (any(tiling.ranks(), next != *own.end())) {
      const SiteNumber first = next;
      Index left = kPointsAtOnce / static_cast<Index>(ranks());
      for (; left > 0 && next != *own.end(); ++next) left -= cells.size(next);
      visit(NumberRange(first, next));
    }
  }

 private:
  std::vector<std::int64_t> first_;  ///< of each rank
};

}  // namespace

/// Throws InvalidInput on all ranks for what several cannot do.
template <class Scalar>
void Run<Scalar>::require_for_ranks() const {
  if (ranks() == nullptr) return;
  agree(ranks(), [this] {
    if (!warm && options.initialization != Initialization::balanced) {
      const bool coherent = options.initialization == Initialization::coherent;
      throw InvalidInput(std::string("options.initialization: is ") +
                         (coherent ? "coherent" : "random") + ", which is the default beyond " +
                         std::to_string(kBalancedDimensions) +
                         " dimensions, too: several ranks need balanced");
    }
  });
  std::vector<Given> given = RunIdentity(problem, options, {}).parts();
  given.push_back({"the option max_iterations", std::to_string(options.max_iterations)});
  given.push_back({"the option energy_tolerance", concat(options.energy_tolerance)});
  given.push_back({"the option checkpoint", options.checkpoint.empty() ? "none" : "a file"});
  require_alike(*ranks(), given);
  if (warm) require_full_cells();
}

/// Throws InvalidInput on all ranks unless the initial owners meet the capacities.
template <class Scalar>
void Run<Scalar>::require_full_cells() const {
  agree(ranks(), [this] {
    if (std::cmp_equal(problem.initial_owners().size(), problem.points().count)) return;
    throw InvalidInput(concat("initial_owners: rank ", ranks()->rank(),
                              " has none for its points, others have: all must be given"));
  });
  const std::vector<Index>& capacities = problem.capacities();
  const std::vector<Index> own = cell_sizes(problem.initial_owners(), capacities.size());
  const std::vector<std::int64_t> sizes =
      summed(ranks(), std::vector<std::int64_t>(own.begin(), own.end()));
  for (const SiteNumber s : sites_below(sizes.size())) {
    if (sizes[s] == capacities[s]) continue;
    throw InvalidInput(concat("initial_owners: site ", s.index(), " owns ", sizes[s],
                              " points on all ranks together, but its capacity is ", capacities[s],
                              ": the two must be equal"));
  }
}

/// Whether one of the ranks is to end: they do so together, after an iteration.
template <class Scalar>
bool Run<Scalar>::cancelled_together(bool own) {
  if (ranks() == nullptr) return false;
  own = own || stop_of_ranks.requested();
  late = any(ranks(), stop_of_ranks.late());
  return any(ranks(), own);
}

/// Each rank tells the ranks of the points in its cells whose they are.
template <class Scalar>
std::vector<Index> Run<Scalar>::owners_at_home() const {
  struct Owned {
    PointNumber point;
    SiteNumber owner;
  };
  auto owners = vector_in_large_pages<Index>(static_cast<std::size_t>(problem.points().count), -1);
  const Homes home(*ranks(), problem.first_own_point());
  home.for_parts(state.tiling, state.cells, [&](NumberRange<SiteNumber> sites) {
    const auto note = [&](PointNumber point, SiteNumber owner) { owners[point] = owner.index(); };
    std::vector<ByteWriter> owned(home.ranks());
    for (const SiteNumber s : sites) {
      for (const PointOfAll p : state.cells.points(s)) {
        const auto [rank, point] = home(p);
        if (std::cmp_equal(rank, ranks()->rank())) {
          note(point, site_of[s]);
        } else {
          owned[rank].put(Owned{point, site_of[s]});
        }
      }
    }
    for (const Ranks::Bytes& message : exchanged(*ranks(), std::move(owned))) {
      for (ByteReader come(message); !come.done();) {
        const auto [point, owner] = come.get<Owned>();
        note(point, owner);
      }
    }
  });
  return owners;
}

/// Cells whose points are known get these points' coordinates.
template <class Scalar>
void Run<Scalar>::fetch_coordinates(const Arena& apart, Cells<Scalar>& cells) const {
  if (ranks() == nullptr) {
    return for_each_site(apart, state.tiling, [&](SiteNumber s) {
      cells.fill(s, [points = own_points()](PointOfAll p) { return points[p]; });
    });
  }
  const Homes home(*ranks(), problem.first_own_point());
  home.for_parts(state.tiling, cells, [&](NumberRange<SiteNumber> sites) {
    std::vector<ByteWriter> wanted(home.ranks());
    for (const SiteNumber s : sites) {
      for (const PointOfAll p : cells.points(s)) {
        const auto [rank, point] = home(p);
        wanted[rank].put(point);
      }
    }
    std::vector<ByteWriter> found;
    for (const Ranks::Bytes& message : exchanged(*ranks(), std::move(wanted))) {
      ByteWriter& theirs = found.emplace_back();
      for (ByteReader points(message); !points.done();) {
        const Scalar* const x = problem.points()[points.get<PointNumber>().index()];
        theirs.put(std::span(x, cells.dimension()));
      }
    }
    const std::vector<Ranks::Bytes> come = exchanged(*ranks(), std::move(found));
    std::vector<ByteReader> readers(come.begin(), come.end());
    std::vector<Scalar> x(cells.dimension());
    for (const SiteNumber s : sites) {
      cells.fill(s, [&](PointOfAll p) {  // in the order in which they were asked for
        readers[home(p).rank].get(std::span(x));
        return x.data();
      });
    }
  });
}

template void Run<float>::require_full_cells() const;
template void Run<double>::require_full_cells() const;
template void Run<float>::require_for_ranks() const;
template void Run<double>::require_for_ranks() const;
template bool Run<float>::cancelled_together(bool);
template bool Run<double>::cancelled_together(bool);
template std::vector<Index> Run<float>::owners_at_home() const;
template std::vector<Index> Run<double>::owners_at_home() const;
template void Run<float>::fetch_coordinates(const Arena&, Cells<float>&) const;
template void Run<double>::fetch_coordinates(const Arena&, Cells<double>&) const;

}  // namespace ccvt
