#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "relax/level_state.h"
#include "relax/patches.h"
#include "relax/swap.h"
#include "schedule/schedule.h"

namespace ccvt {

/// What ranks know of each other's cells while a level is relaxed: of a cell that is lent again, or
/// given back, no more is sent than the places that have changed meanwhile.
class Loans {
 public:
  void begin(const Tiling& tiling) {
    version_.resize(tiling.sites(), 0);
    lent_.resize(tiling.sites(), 0);
    log_of_.resize(tiling.sites(), kNone);
    own_ = tiling.own_sites();
  }
  /// Points of a cell have been exchanged for others.
  void note_change(SiteNumber site, const std::vector<Candidate>& points) {
    if (version_.empty()) return;
    ++version_[site];
    if (log_of_[site] == kNone) return;
    Log& log = logs_[log_of_[site]];
    for (const Candidate& point : points) log.add(version_[site], point.place);
  }

  /// The points of a cell are in another order, and have no place that a rank would know.
  void note_sorting(SiteNumber site) {
    if (version_.empty()) return;
    ++version_[site];
    if (log_of_[site] != kNone) logs_[log_of_[site]].begin_at(version_[site]);
  }

  [[nodiscard]] std::uint32_t version(SiteNumber site) const { return version_[site]; }

  /// From now on changes of a cell of so many places are kept in mind, the last ones.
  void follow(SiteNumber site, Index places) {
    if (log_of_[site] != kNone) return;
    log_of_[site] = static_cast<std::uint32_t>(logs_.size());
    logs_.emplace_back(places).begin_at(version_[site]);
  }
  /// The version that a rank has of this rank's own cell, or none; from now on it has this one.
  std::optional<std::uint32_t> give(SiteNumber site, int rank) {
    std::vector<std::uint32_t>& known = known_[rank];
    if (known.empty()) known.assign(own_.size(), 0);
    const std::uint32_t there = std::exchange(known[site - *own_.begin()], version_[site] + 1);
    return there == 0 ? std::nullopt : std::optional(there - 1);
  }
  /// Whether it has.
  [[nodiscard]] bool has(int rank, SiteNumber site) const {
    const auto known = known_.find(rank);
    return known != known_.end() && known->second[site - *own_.begin()] == version_[site] + 1;
  }
  /// The version that its own rank has of a cell that is here; from now on it has this one.
  std::uint32_t give_back(SiteNumber site) { return std::exchange(lent_[site], version_[site]); }
  /// Whether it lacks that.
  [[nodiscard]] bool has_changed(SiteNumber site) const { return version_[site] != lent_[site]; }

  /// Another rank's cell has come.
  void borrow(SiteNumber site, std::uint32_t version) {
    version_[site] = lent_[site] = version;
    if (log_of_[site] != kNone) logs_[log_of_[site]].begin_at(version);
  }
  /// An own cell has come back, changed at these places; without them, anywhere.
  void take_back(SiteNumber site, std::uint32_t version,
                 const std::optional<std::vector<Index>>& places) {
    version_[site] = version;
    if (log_of_[site] == kNone) return;
    Log& log = logs_[log_of_[site]];
    if (!places) return log.begin_at(version);
    for (const Index place : *places) log.add(version, place);
  }

  /// The places of a cell that have changed since a version, ascending; nothing where that is not
  /// known, or they are more than `most`.
  [[nodiscard]] std::optional<std::vector<Index>> changed_since(
      SiteNumber site, const std::optional<std::uint32_t>& version, std::size_t most) const {
    if (!version || log_of_[site] == kNone) return {};
    return logs_[log_of_[site]].since(*version, most);
  }

 private:
  /// The places of a cell that have changed since `begin_`, with the versions that this made.
  class Log {
   public:
    explicit Log(Index places)
        : most_(static_cast<std::size_t>(std::clamp(places, 2, std::max(512, places / 16)))) {}
    void begin_at(std::uint32_t version) {
      begin_ = version;
      entries_.clear();
    }
    void add(std::uint32_t version, Index place) {
      if (entries_.size() == most_) {
        const auto half = entries_.begin() + static_cast<std::ptrdiff_t>(most_ / 2);
        begin_ = std::prev(half)->first;
        entries_.erase(entries_.begin(), half);
      }
      entries_.emplace_back(version, place);
    }
    [[nodiscard]] std::optional<std::vector<Index>> since(std::uint32_t version,
                                                          std::size_t most) const {
      if (version < begin_) return {};
      const auto first =
          std::partition_point(entries_.begin(), entries_.end(),
                               [version](const auto& e) { return e.first <= version; });
      std::vector<Index> places;
      for (auto entry = first; entry != entries_.end(); ++entry) places.push_back(entry->second);
      std::sort(places.begin(), places.end());
      places.erase(std::unique(places.begin(), places.end()), places.end());
      if (places.size() > most) return {};
      return places;
    }

   private:
    std::size_t most_;  ///< entries: a few hundredths of the memory of large cells
    std::uint32_t begin_ = 0;
    std::vector<std::pair<std::uint32_t, Index>> entries_;
  };

  static constexpr std::uint32_t kNone = UINT32_MAX;
  std::vector<std::uint32_t> version_;  ///< by site; as often as it has changed
  std::vector<std::uint32_t> lent_;     ///< of another rank's, what that has
  std::vector<std::uint32_t> log_of_;   ///< by site; none for cells that are not followed
  std::vector<Log> logs_;
  NumberRange<SiteNumber> own_ = sites_below(0);
  /// One more than what a rank has of an own site's.
  std::map<int, std::vector<std::uint32_t>> known_;
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

  /// With a cell that has not changed, nothing has that put() tells of it, but for what is known of
  /// the patches of one that may be divided, which changes whenever it is looked at.
  [[nodiscard]] bool lacks(int rank, SiteNumber site) const {
    if (patches.divides(state.cells.size(site))) return true;
    return is_own(site) ? !loans.has(rank, site) : loans.has_changed(site);
  }
  void put(ByteWriter& message, SiteNumber site, int rank) {
    const Index size = state.cells.size(site);
    loans.follow(site, size);
    const std::optional<std::uint32_t> there =
        is_own(site) ? loans.give(site, rank) : loans.give_back(site);
    message.put(state.sites.radius[site]);
    message.put(loans.version(site));
    message.put(state.sites.compact[site]);
    message.put(changed[site]);
    // More places than half of all take more bytes than all, about.
    const auto places = loans.changed_since(site, there, static_cast<std::size_t>(size / 2));
    message.put(places ? static_cast<Index>(places->size()) : kWhole);
    if (places) {
      for (const Index place : *places) state.cells.write_place(message, site, place);
    } else {
      state.cells.write(message, site, size);
    }
    patches.save(message, site, size);
  }
  void take(ByteReader& message, SiteNumber site, int rank) {
    const Index size = state.cells.size(site);
    state.sites.radius[site] = message.get<double>();
    const auto version = message.get<std::uint32_t>();
    state.sites.compact[site] = message.get<std::uint8_t>();
    changed[site] = message.get<std::uint8_t>();
    const auto count = message.get<Index>();
    std::optional<std::vector<Index>> places;
    if (count == kWhole) {
      state.cells.read(message, site, size);
    } else {
      places.emplace();
      for (Index k = 0; k < count; ++k) places->push_back(state.cells.read_place(message, site));
    }
    patches.load(message, site, size);
    if (is_own(site)) {
      loans.take_back(site, version, places);
      loans.give(site, rank);
    } else {
      loans.borrow(site, version);
      loans.follow(site, size);
    }
  }

 private:
  static constexpr Index kWhole = -1;  ///< in the place of how many places are sent
  [[nodiscard]] bool is_own(SiteNumber site) const { return tiling.is_own(tiling.tile_of(site)); }
  [[nodiscard]] bool is_idle(const Schedule::Task& task) const {
    return touched_tiles != nullptr && ((*touched_tiles)[task.a] | (*touched_tiles)[task.b]) == 0;
  }
};
template <class Scalar, class ForPairs>
RelaxedLender(LevelState<Scalar>&, const Tiling&, Patches<Scalar>&, std::vector<std::uint8_t>&,
              Loans&, const ForPairs&, const std::vector<std::uint8_t>*)
    -> RelaxedLender<Scalar, ForPairs>;

}  // namespace ccvt
