// How a run is kept in a file, and continued from one.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "checkpoint/checkpoint_file.h"
#include "checkpoint/digest.h"
#include "checkpoint/tile_parts.h"
#include "parallel/loops.h"
#include "parallel/together.h"
#include "run.h"
#include "run_identity.h"
#include "schedule/own_pairs.h"

namespace ccvt {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& message) {
  throw InvalidInput(file.string() + ": " + message);
}

/// Calls `read`, where bytes of `file` are read.
template <class Read>
void blame(const std::filesystem::path& file, const Read& read) {
  try {
    read();
  } catch (const Damaged&) {
    fail(file, "is damaged: it does not hold what it should");
  }
}

/// The file is the first rank's.
bool is_first(const Ranks* ranks) { return ranks == nullptr || ranks->rank() == 0; }

void save_sites(const SiteState& sites, ByteWriter& out) {
  out.put(sites.position);
  out.put(sites.radius);
  out.put(sites.energy);
  out.put(sites.compact);
}

/// `sites`: the same, as they were once, which do not change which are fixed.
SiteState load_sites(const SiteState& sites, ByteReader& in) {
  SiteState loaded = sites;
  loaded.position = in.get_all<double>(sites.position.size());
  loaded.radius = in.get_all<double>(sites.count());
  loaded.energy = in.get_all<double>(sites.count());
  loaded.compact = in.get_all<std::uint8_t>(sites.count());
  return loaded;
}

/// How long the record of each tile is, with its digest: a matter of its cells' sizes alone.
template <class Scalar>
std::vector<std::size_t> record_sizes(const Tiling& tiling, const Cells<Scalar>& cells,
                                      const Relaxer<Scalar>& relaxer) {
  std::vector<std::size_t> sizes;
  for (std::size_t t = 0; t < tiling.count(); ++t) {
    std::size_t size = sizeof(std::uint64_t);
    for (const SiteNumber s : tiling.sites_of(Tile(t))) {
      size += relaxer.cell_bytes(cells.size(s)) + cells.saved_bytes(s);
    }
    sizes.push_back(size);
  }
  return sizes;
}

std::uint64_t total_of(const std::vector<std::size_t>& sizes) {
  return std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0});
}

}  // namespace

template <class Scalar>
RunIdentity Run<Scalar>::identity(const Arena& apart) {
  if (!point_digests) point_digests = digests_of_points(problem, apart);
  return {problem, options, *point_digests};
}

/// What there is of the run and of all sites.
template <class Scalar>
ByteWriter Run<Scalar>::save_common(const RunIdentity& own, const AddedPairs& added) {
  ByteWriter common;
  own.save(common);
  common.put(std::uint64_t{level});
  save_sites(state.sites, common);
  common.put(weights);
  relaxer->save(common, added.relaxed.span());
  common.put(turns.descents);
  common.put(turns.passes);
  common.put(turns.before);
  common.put(turns.after);
  common.put(turns.excess);
  common.put(descent != nullptr);
  if (descent) {
    common.put(static_cast<int>(descent->depth()));
    descent->save(common, added.descended.span());
  }
  record.save(common);
  return common;
}

/// The records of tiles of this rank.
template <class Scalar>
std::vector<std::byte> Run<Scalar>::save_tiles(const TilePart& part, const Arena& apart) const {
  std::vector<std::byte> records(part.bytes());
  apart.for_each(part.end - part.first, 1, [&](std::size_t k) {
    ByteWriter tile(part.offsets[k + 1] - part.offsets[k]);
    for (const SiteNumber s : state.tiling.sites_of(Tile(part.first + k))) {
      relaxer->save_cell(tile, s, state.cells.size(s));
      state.cells.save(tile, s);
    }
    tile.put(digest(tile.bytes));
    std::copy(tile.bytes.begin(), tile.bytes.end(), records.data() + part.offsets[k]);
  });
  return records;
}

template <class Scalar>
void Run<Scalar>::save(const std::filesystem::path& file) {
  if (record.ended()) fail(file, "a run that has ended leaves no checkpoint");
  const Arena apart(options.threads);  // not the run's, which may be told to stop
  const RunIdentity own = identity(apart);
  AddedPairs added{pairs_of_all(state.tiling, relaxer->added_pairs()), {}};
  if (descent) added.descended = pairs_of_all(state.tiling, descent->added_pairs());
  std::vector<std::size_t> sizes;
  std::optional<CheckpointWriter> out;
  agree(ranks(), [&] {
    sizes = record_sizes(state.tiling, state.cells, *relaxer);
    if (is_first(ranks())) out.emplace(file, save_common(own, added).bytes, total_of(sizes));
  });
  agree(ranks(), [&] {
    parts_to_first(
        ranks(), parts_of(state.tiling, sizes),
        [&](const TilePart& part) { return save_tiles(part, apart); },
        [&](const std::vector<std::byte>& records) { out->write(records); });
  });
  agree(ranks(), [&] {
    if (out) out->commit();
  });
}

template <class Scalar>
void Run<Scalar>::load(const std::filesystem::path& file) {
  if (record.ended()) fail(file, "a run that has ended does not go on from a checkpoint");
  std::optional<CheckpointReader> in;
  agree(ranks(), [&] {
    if (is_first(ranks())) in.emplace(file);
  });
  const Head head = shared_head(in);
  const Stop::Pause pause(stop);
  blame(file, [&] { load_from(file, in, head); });
}

/// What all ranks must know of the file that the first one reads.
template <class Scalar>
auto Run<Scalar>::shared_head(const std::optional<CheckpointReader>& in) const -> Head {
  std::vector<std::byte> common;
  if (in) common.assign(in->common().begin(), in->common().end());
  return {joined(ranks(), std::move(common)), of_all(ranks(), in ? in->tiles() : 0)[0]};
}

/// Nothing has changed when it throws.
template <class Scalar>
void Run<Scalar>::load_from(const std::filesystem::path& file, std::optional<CheckpointReader>& in,
                            const Head& head) {
  const Arena apart(options.threads);
  ByteReader reader(head.common);
  const RunIdentity kept(reader);
  const std::string objection = identity(apart).objection_to(kept);
  if (!objection.empty()) fail(file, objection);
  const auto loaded_level = reader.get<std::uint64_t>();
  if (loaded_level >= levels.size()) throw Damaged();
  const std::vector<Index>& sizes = levels[static_cast<std::size_t>(loaded_level)].capacities;
  LevelState<Scalar> loaded{state.tiling, load_sites(state.sites, reader), empty_cells(sizes)};
  std::vector<double> loaded_weights = reader.get_all<double>();
  std::unique_ptr<Relaxer<Scalar>> loaded_relaxer = make_relaxer(sizes);
  loaded_relaxer->load(reader, state.tiling);
  const Turns loaded_turns{reader.get<int>(), reader.get<double>(), reader.get<double>(),
                           reader.get<double>(), reader.get<double>()};
  const int descents = loaded_turns.descents;
  if (descents < 0 || descents > kMostDescents || !(loaded_turns.passes >= 0)) throw Damaged();
  std::unique_ptr<Descent<Scalar>> loaded_descent;
  if (reader.get<bool>()) {
    if (descents < 1) throw Damaged();
    const auto number = reader.get<int>();
    if (number < static_cast<int>(Depth::even) || number > static_cast<int>(Depth::full)) {
      throw Damaged();
    }
    const auto depth = static_cast<Depth>(number);
    loaded_descent = std::make_unique<Descent<Scalar>>(metric, arena, stop, own_points(), loaded,
                                                       depth, least_gain(descents - 1), weights);
    loaded_descent->load(reader, state.tiling);
    if (loaded_weights.size() != sizes.size()) throw Damaged();
  }
  const std::vector<std::size_t> records =
      record_sizes(state.tiling, loaded.cells, *loaded_relaxer);
  if (head.tiles != total_of(records)) throw Damaged();
  agree(ranks(), [&] {
    parts_from_first(
        ranks(), parts_of(state.tiling, records),
        [&](const TilePart& part) {
          std::vector<std::byte> bytes(part.bytes());
          in->read(bytes);
          return bytes;
        },
        [&](const TilePart& part, std::span<const std::byte> bytes) {
          blame(file, [&] { load_tiles(file, part, bytes, apart, loaded.cells, *loaded_relaxer); });
        });
  });
  fetch_coordinates(apart, loaded.cells);
  record.load(reader);
  level = static_cast<std::size_t>(loaded_level);
  state = std::move(loaded);
  weights = std::move(loaded_weights);
  relaxer = std::move(loaded_relaxer);
  descent = std::move(loaded_descent);
  turns = loaded_turns;
}

/// The points' numbers, that is, and what is known of the cells.
template <class Scalar>
void Run<Scalar>::load_tiles(const std::filesystem::path& file, const TilePart& part,
                             std::span<const std::byte> bytes, const Arena& apart,
                             Cells<Scalar>& cells, Relaxer<Scalar>& patches) const {
  std::atomic<bool> as_written = true;
  apart.for_each(part.end - part.first, 1, [&](std::size_t k) {
    const std::size_t size = part.offsets[k + 1] - part.offsets[k];
    const auto tile = bytes.subspan(part.offsets[k], size - sizeof(std::uint64_t));
    const auto end = bytes.subspan(part.offsets[k] + tile.size(), sizeof(std::uint64_t));
    if (ByteReader(end).template get<std::uint64_t>() != digest(tile)) {
      as_written = false;
      return;
    }
    ByteReader reader(tile);
    for (const SiteNumber s : state.tiling.sites_of(Tile(part.first + k))) {
      patches.load_cell(reader, s, cells.size(s));
      cells.load(reader, s, problem.point_count());
    }
    reader.expect_end();
  });
  if (!as_written) fail(file, "is damaged: what it has of cells is not as written");
}

template <class Scalar>
void Run<Scalar>::tell(CheckpointRecord::Event event, double seconds, const std::string& failure) {
  if (options.on_checkpoint) {
    options.on_checkpoint({event, record.iterations(), seconds, failure});
  } else if (!failure.empty()) {
    record.summary().warnings.push_back("after iteration " + std::to_string(record.iterations()) +
                                        " no checkpoint could be written: " + failure);
  }
}

/// Whether there is a run to be read.
template <class Scalar>
bool Run<Scalar>::continues() const {
  if (!is_kept()) return false;
  std::error_code unknown;
  const bool there =
      is_first(ranks()) && std::filesystem::status(options.checkpoint, unknown).type() !=
                               std::filesystem::file_type::not_found;
  return any(ranks(), there);
}

/// Reads it.
template <class Scalar>
void Run<Scalar>::take_kept() {
  const Clock::time_point start = Clock::now();
  load(options.checkpoint);
  kept_at = Clock::now();
  tell(CheckpointRecord::Event::continued, seconds_since(start));
}

/// For the first time. Whoever cannot write there should know before hours have passed.
template <class Scalar>
void Run<Scalar>::begin_keeping() {
  const Clock::time_point start = Clock::now();
  save(options.checkpoint);
  kept_at = Clock::now();
  tell(CheckpointRecord::Event::saved, seconds_since(start));
}

template <class Scalar>
void Run<Scalar>::keep() {
  const Clock::time_point start = Clock::now();
  std::string failure;
  try {
    save(options.checkpoint);
  } catch (const std::exception& error) {  // the disk is full, or memory
    failure = error.what();
  }
  kept_at = Clock::now();
  const bool failed_before = std::exchange(keeping_fails, !failure.empty());
  if (failure.empty()) {
    tell(CheckpointRecord::Event::saved, seconds_since(start));
  } else if (!failed_before) {
    tell(CheckpointRecord::Event::failed, seconds_since(start), failure);
  }
}

template <class Scalar>
void Run<Scalar>::keep_if_due() {
  if (any(ranks(), seconds_since(kept_at) >= options.checkpoint_seconds)) keep();
}

template <class Scalar>
bool Run<Scalar>::end_for_now(Termination termination) {
  if (is_kept()) keep();
  return end(termination);
}

// One by one: run.h says of the class that it is instantiated elsewhere.
template RunIdentity Run<float>::identity(const Arena&);
template RunIdentity Run<double>::identity(const Arena&);
template void Run<float>::save(const std::filesystem::path&);
template void Run<double>::save(const std::filesystem::path&);
template void Run<float>::load(const std::filesystem::path&);
template void Run<double>::load(const std::filesystem::path&);
template ByteWriter Run<float>::save_common(const RunIdentity&, const AddedPairs&);
template ByteWriter Run<double>::save_common(const RunIdentity&, const AddedPairs&);
template std::vector<std::byte> Run<float>::save_tiles(const TilePart&, const Arena&) const;
template std::vector<std::byte> Run<double>::save_tiles(const TilePart&, const Arena&) const;
template Run<float>::Head Run<float>::shared_head(const std::optional<CheckpointReader>&) const;
template Run<double>::Head Run<double>::shared_head(const std::optional<CheckpointReader>&) const;
template void Run<float>::load_from(const std::filesystem::path&, std::optional<CheckpointReader>&,
                                    const Head&);
template void Run<double>::load_from(const std::filesystem::path&, std::optional<CheckpointReader>&,
                                     const Head&);
template void Run<float>::load_tiles(const std::filesystem::path&, const TilePart&,
                                     std::span<const std::byte>, const Arena&, Cells<float>&,
                                     Relaxer<float>&) const;
template void Run<double>::load_tiles(const std::filesystem::path&, const TilePart&,
                                      std::span<const std::byte>, const Arena&, Cells<double>&,
                                      Relaxer<double>&) const;
template bool Run<float>::continues() const;
template void Run<float>::take_kept();
template bool Run<double>::continues() const;
template void Run<double>::take_kept();
template void Run<float>::begin_keeping();
template void Run<double>::begin_keeping();
template void Run<float>::keep();
template void Run<double>::keep();
template void Run<float>::keep_if_due();
template void Run<double>::keep_if_due();
template bool Run<float>::end_for_now(Termination);
template bool Run<double>::end_for_now(Termination);
template void Run<float>::tell(CheckpointRecord::Event, double, const std::string&);
template void Run<double>::tell(CheckpointRecord::Event, double, const std::string&);

}  // namespace ccvt
