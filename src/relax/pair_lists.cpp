#include "relax/pair_lists.h"

#include <algorithm>
#include <cstdint>

#include "relax/screen.h"

namespace ccvt {
namespace {

/// Full passes over all pairs before the list of meeting ones is tried again.
constexpr int kDensePasses = 4;

/// A list of meeting pairs longer than this is not worth having.
std::size_t list_limit(std::size_t sites) {
  constexpr std::size_t kMost = INT32_MAX;
  return std::min({sites * (sites - 1) / 4, 256 * sites, kMost});
}

}  // namespace

bool PairLists::refresh(const Metric& metric, const SiteState& sites, const Tiling& tiling,
                        const Arena& arena) {
  const auto charge = arena.phase(Phase::lists);
  // Spheres shrink as the relaxation goes on: a list may pay by now.
  const bool retry = dense_ && !screening_pays(metric) && ++dense_passes_ % kDensePasses == 0;
  if (dense_ && !retry) return false;
  const auto schedule = [&](std::span<const Pair> pairs) {
    const auto own_charge = arena.phase(Phase::schedule);
    return schedule_own_pairs(pairs, tiling, arena);
  };
  switch (meeting_.refresh(metric, sites, tiling, arena, list_limit(sites.count()))) {
    case MeetingPairs::Refreshed::unchanged:
      break;
    case MeetingPairs::Refreshed::extended:
      added_ = schedule(meeting_.added());
      break;
    case MeetingPairs::Refreshed::rebuilt:
      dense_ = false;
      first_ = schedule(meeting_.pairs());
      added_ = {};
      break;
    case MeetingPairs::Refreshed::too_many:
      dense_ = true;
      break;
  }
  return !dense_;
}

void PairLists::forget() {
  meeting_.forget();
  first_ = {};
  added_ = {};
  dense_ = false;
}

void PairLists::save(ByteWriter& out, std::span<const Pair> added) const {
  out.put(dense_);
  out.put(dense_passes_);
  meeting_.save(out, added);
}

void PairLists::load(ByteReader& in, const Metric& metric, const Tiling& tiling,
                     const Arena& arena) {
  dense_ = in.get<bool>();
  dense_passes_ = in.get<int>();
  meeting_.load(in, metric, tiling, arena);
  first_ = schedule_own_pairs(meeting_.pairs(), tiling, arena);
  added_ = schedule_own_pairs(meeting_.added(), tiling, arena);
}

Buffer<Pair> PairLists::pairs() const {
  const auto first = meeting_.pairs();
  const auto added = meeting_.added();
  Buffer<Pair> all(first.size() + added.size());
  std::copy(first.begin(), first.end(), all.begin());
  std::copy(added.begin(), added.end(), all.begin() + first.size());
  return all;
}

}  // namespace ccvt
