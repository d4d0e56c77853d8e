// What a run does where several ranks make it together.
#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "no_checkpoint.h"
#include "parallel/bytes.h"
#include "parallel/together.h"
#include "run.h"

namespace ccvt {

/// Throws InvalidInput on all ranks for what several cannot do.
template <class Scalar>
void Run<Scalar>::require_for_ranks() const {
  if (ranks() == nullptr) return;
  agree(ranks(), [this] {
    require_no_checkpoint(options, "a problem of several ranks");
    if (options.initialization != Initialization::balanced) {
      const bool coherent = options.initialization == Initialization::coherent;
      throw InvalidInput(std::string("options.initialization: is ") +
                         (coherent ? "coherent" : "random") + ", which is the default beyond " +
                         std::to_string(kBalancedDimensions) +
                         " dimensions, too: several ranks need balanced");
    }
  });
}

/// Whether one of the ranks is to end: they do so together, after an iteration.
template <class Scalar>
bool Run<Scalar>::cancelled_together(bool own) {
  if (ranks() == nullptr) return false;
  own = own || stop_of_ranks.requested();
  late = any(ranks(), stop_of_ranks.late());
  return any(ranks(), own);
}

/// Each rank tells the ranks of the points in its cells whose they are, about so many points at a
/// time.
template <class Scalar>
std::vector<Index> Run<Scalar>::owners_at_home() const {
  constexpr Index kPointsAtOnce = 1 << 18;
  struct Owned {
    PointNumber point;
    SiteNumber owner;
  };
  const std::vector<Index> first = of_all(ranks(), problem.first_own_point());
  std::vector<Index> owners(static_cast<std::size_t>(problem.own_points().count), -1);
  const NumberRange<SiteNumber> own = state.tiling.own_sites();
  SiteNumber next = *own.begin();
  while (any(ranks(), next != *own.end())) {
    std::vector<std::vector<Owned>> owned(first.size());
    for (Index points = 0; points < kPointsAtOnce && next != *own.end(); ++next) {
      points += state.cells.size(next);
      for (const PointNumber p : state.cells.points(next)) {
        // The last rank that begins there or before: others there have no points.
        const auto after = std::upper_bound(first.begin(), first.end(), p.index());
        owned[static_cast<std::size_t>(after - first.begin() - 1)].push_back({p, site_of[next]});
      }
    }
    std::vector<Ranks::Bytes> messages;
    for (const std::vector<Owned>& theirs : owned) {
      const auto bytes = std::as_bytes(std::span(theirs));
      messages.emplace_back(bytes.begin(), bytes.end());
    }
    for (const Ranks::Bytes& message : ranks()->exchange(std::move(messages))) {
      std::vector<Owned> come(message.size() / sizeof(Owned));
      ByteReader(message).get(std::span(come));
      for (const auto& [point, owner] : come) {
        owners[PointNumber(point.index() - problem.first_own_point())] = owner.index();
      }
    }
  }
  return owners;
}

template void Run<float>::require_for_ranks() const;
template void Run<double>::require_for_ranks() const;
template bool Run<float>::cancelled_together(bool);
template bool Run<double>::cancelled_together(bool);
template std::vector<Index> Run<float>::owners_at_home() const;
template std::vector<Index> Run<double>::owners_at_home() const;

}  // namespace ccvt
