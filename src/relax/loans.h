#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "relax/level_state.h"
#include "relax/patches.h"
#include "schedule/schedule.h"

namespace ccvt {

/// What ranks know of each other's cells while a level is relaxed: a cell that is lent again, or
/// given back, and has not changed meanwhile, is not sent.
class Loans {
 public:
  void begin(std::size_t sites) {
    version_.resize(sites, 0);
    lent_.resize(sites, 0);
  }
  /// Points of two cells have been exchanged.
  void note_change(SiteNumber i, SiteNumber j) {
    if (version_.empty()) return;
    ++version_[i];
    ++version_[j];
  }

  /// The version of the cell as it is here, or has come here.
  [[nodiscard]] std::uint32_t version(SiteNumber site) const { return version_[site]; }
  void take(SiteNumber site, std::uint32_t version) { version_[site] = lent_[site] = version; }

  /// Whether a rank lacks the cell as it is here; from now on it has it.
  bool give(SiteNumber site, int rank) {
    const std::uint32_t there = std::exchange(known_[rank][site], version_[site] + 1);
    return there != version_[site] + 1;
  }
  /// Whether a cell that was lent to this rank has changed here.
  [[nodiscard]] bool changed(SiteNumber site) const { return version_[site] != lent_[site]; }

 private:
  std::vector<std::uint32_t> version_;  ///< by site; as often as it has changed
  std::vector<std::uint32_t> lent_;     ///< when it came here
  /// One more than what a rank has of a site's.
  std::map<int, std::unordered_map<std::size_t, std::uint32_t>> known_;
};

/// Lends cells that are relaxed, with what a swap may change.
template <class Scalar, class ForPairs>
struct RelaxedLender {
  LevelState<Scalar>& state;
  const Tiling& tiling;  ///< of the tasks
  Patches<Scalar>& patches;
  std::vector<std::uint8_t>& changed;
  Loans& loans;
  const ForPairs& for_pairs;
  const std::vector<std::uint8_t>* touched_tiles;  ///< null: all tasks have something to do

  void add_sites(const Schedule::Task& task, Tile tile, std::vector<SiteNumber>& sites) const {
    const NumberRange<SiteNumber> own = tiling.sites_of(tile);
    std::vector<std::uint8_t> named(own.size(), 0);
    for_pairs(task, [&](SiteNumber i, SiteNumber j) {
      for (const SiteNumber s : {i, j}) {
        if (tiling.tile_of(s) == tile) named[s - *own.begin()] = 1;
      }
    });
    for (const SiteNumber s : own) {
      if (named[s - *own.begin()] != 0) sites.push_back(s);
    }
  }

  [[nodiscard]] bool has_work(const Schedule::Task& task) const {
    if (touched_tiles == nullptr) return true;
    if (is_idle(task)) return false;
    bool found = false;
    for_pairs(task, [&](SiteNumber, SiteNumber) { found = true; });
    return found;
  }
  [[nodiscard]] std::size_t load(const Schedule::Task& task) const {
    return is_idle(task) ? 0 : task.size();
  }

  void put(ByteWriter& message, SiteNumber site, int rank) {
    const bool divided = patches.divides(state.cells.size(site));
    const bool lends = tiling.is_own(tiling.tile_of(site));
    const bool sends = lends ? loans.give(site, rank) : loans.changed(site);
    message.put(state.sites.radius[site]);
    message.put(loans.version(site));
    message.put(state.sites.compact[site]);
    message.put(changed[site]);
    message.put(sends || divided);
    if (sends || divided) state.cells.write(message, site, state.cells.size(site));
    patches.save(message, site, state.cells.size(site));
  }
  void take(ByteReader& message, SiteNumber site, int rank) {
    state.sites.radius[site] = message.get<double>();
    loans.take(site, message.get<std::uint32_t>());
    state.sites.compact[site] = message.get<std::uint8_t>();
    changed[site] = message.get<std::uint8_t>();
    if (message.get<bool>()) state.cells.read(message, site, state.cells.size(site));
    patches.load(message, site, state.cells.size(site));
    if (tiling.is_own(tiling.tile_of(site))) loans.give(site, rank);
  }

 private:
  [[nodiscard]] bool is_idle(const Schedule::Task& task) const {
    return touched_tiles != nullptr && ((*touched_tiles)[task.a] | (*touched_tiles)[task.b]) == 0;
  }
};
template <class Scalar, class ForPairs>
RelaxedLender(LevelState<Scalar>&, const Tiling&, Patches<Scalar>&, std::vector<std::uint8_t>&,
              Loans&, const ForPairs&, const std::vector<std::uint8_t>*)
    -> RelaxedLender<Scalar, ForPairs>;

}  // namespace ccvt
