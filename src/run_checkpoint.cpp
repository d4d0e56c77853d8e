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
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "checkpoint/checkpoint_file.h"
#include "checkpoint/digest.h"
#include "parallel/loops.h"
#include "run.h"
#include "run_identity.h"

namespace ccvt {
namespace {

using Clock = std::chrono::steady_clock;

/// Bytes of records that are in memory at the same time, or one record.
constexpr std::size_t kBytesAtOnce = std::size_t{1} << 24;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void require_one_process(const std::filesystem::path& file, const Ranks* ranks) {
  if (ranks == nullptr) return;
  throw InvalidInput(file.string() + ": a problem of several ranks keeps no checkpoint");
}

void save_sites(const SiteState& sites, StateWriter& out) {
  out.put_all(sites.position);
  out.put_all(sites.radius);
  out.put_all(sites.energy);
  out.put_all(sites.compact);
}

/// `sites`: the same, as they were once, which do not change which are fixed.
SiteState load_sites(const SiteState& sites, StateReader& in) {
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
      size += relaxer.cell_bytes(cells.size(s)) + cells.points(s).size_bytes();
    }
    sizes.push_back(size);
  }
  return sizes;
}

/// Calls visit(first tile, end) for runs of tiles whose records are in memory together.
template <class Visit>
void for_parts(const std::vector<std::size_t>& sizes, const Visit& visit) {
  for (std::size_t first = 0, end = 0; first < sizes.size(); first = end) {
    std::size_t bytes = 0;
    while (end < sizes.size() && (end == first || bytes + sizes[end] <= kBytesAtOnce)) {
      bytes += sizes[end++];
    }
    visit(first, end);
  }
}

/// Where each record of a part begins in its bytes.
std::vector<std::size_t> offsets_of(const std::vector<std::size_t>& sizes, std::size_t first,
                                    std::size_t end) {
  std::vector<std::size_t> offsets{0};
  for (std::size_t t = first; t < end; ++t) offsets.push_back(offsets.back() + sizes[t]);
  return offsets;
}

}  // namespace

template <class Scalar>
RunIdentity Run<Scalar>::identity(const Arena& apart) {
  if (!points_digest) points_digest = digest_of_points(problem.points(), apart);
  return {problem, options, *points_digest};
}

template <class Scalar>
void Run<Scalar>::save(const std::filesystem::path& file) {
  require_one_process(file, ranks());
  if (record.ended()) {
    throw InvalidInput(file.string() + ": a run that has ended leaves no checkpoint");
  }
  const Arena apart(options.threads);  // not the run's, which may be told to stop
  StateWriter common;
  identity(apart).save(common);
  common.put(std::uint64_t{level});
  save_sites(state.sites, common);
  common.put_all(weights);
  relaxer->save(common);
  common.put(descent != nullptr);
  if (descent) {
    common.put(static_cast<int>(descent->depth()));
    descent->save(common);
  }
  record.save(common);
  const std::vector<std::size_t> sizes = record_sizes(state.tiling, state.cells, *relaxer);
  CheckpointWriter out(file, common.bytes(),
                       std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0}));
  for_parts(sizes, [&](std::size_t first, std::size_t end) {
    const std::vector<std::size_t> offsets = offsets_of(sizes, first, end);
    std::vector<std::byte> records(offsets.back());
    apart.for_each(end - first, 1, [&](std::size_t k) {
      StateWriter tile(sizes[first + k]);
      for (const SiteNumber s : state.tiling.sites_of(Tile(first + k))) {
        relaxer->save_cell(tile, s, state.cells.size(s));
        state.cells.save(tile, s);
      }
      tile.put(digest(tile.bytes()));
      std::copy(tile.bytes().begin(), tile.bytes().end(), records.data() + offsets[k]);
    });
    out.write(records);
  });
  out.commit();
}

template <class Scalar>
void Run<Scalar>::load(const std::filesystem::path& file) {
  require_one_process(file, ranks());
  if (record.ended()) {
    throw InvalidInput(file.string() + ": a run that has ended does not go on from a checkpoint");
  }
  CheckpointReader in(file);
  try {
    const Stop::Pause pause(stop);
    load_from(in);
  } catch (const Damaged&) {
    in.fail("is damaged: it does not hold what it should");
  }
}

/// Nothing has changed when it throws.
template <class Scalar>
void Run<Scalar>::load_from(CheckpointReader& in) {
  const Arena apart(options.threads);
  StateReader common(in.common());
  const RunIdentity kept(common);
  const std::string objection = identity(apart).objection_to(kept);
  if (!objection.empty()) in.fail(objection);
  const auto loaded_level = common.get<std::uint64_t>();
  if (loaded_level >= levels.size()) throw Damaged();
  const std::vector<Index>& sizes = levels[static_cast<std::size_t>(loaded_level)].capacities;
  LevelState<Scalar> loaded{state.tiling, load_sites(state.sites, common),
                            Cells<Scalar>(problem.dimension(), sizes)};
  std::vector<double> loaded_weights = common.get_all<double>();
  std::unique_ptr<Relaxer<Scalar>> loaded_relaxer = make_relaxer();
  loaded_relaxer->load(common, state.tiling);
  std::unique_ptr<Descent<Scalar>> loaded_descent;
  if (common.get<bool>()) {
    const auto depth = static_cast<Depth>(common.get<int>());
    loaded_descent = std::make_unique<Descent<Scalar>>(metric, arena, stop, problem.points(),
                                                       loaded, depth, weights);
    loaded_descent->load(common);
    if (loaded_weights.size() != sizes.size()) throw Damaged();
  }
  load_cells(in, apart, loaded.cells, *loaded_relaxer);
  record.load(common);
  level = static_cast<std::size_t>(loaded_level);
  state = std::move(loaded);
  weights = std::move(loaded_weights);
  relaxer = std::move(loaded_relaxer);
  descent = std::move(loaded_descent);
}

template <class Scalar>
void Run<Scalar>::load_cells(CheckpointReader& in, const Arena& apart, Cells<Scalar>& cells,
                             Relaxer<Scalar>& patches) const {
  const std::vector<std::size_t> sizes = record_sizes(state.tiling, cells, patches);
  if (in.tiles() != std::accumulate(sizes.begin(), sizes.end(), std::uint64_t{0})) throw Damaged();
  for_parts(sizes, [&](std::size_t first, std::size_t end) {
    const std::vector<std::size_t> offsets = offsets_of(sizes, first, end);
    std::vector<std::byte> records(offsets.back());
    in.read(records);
    std::atomic<bool> as_written = true;
    apart.for_each(end - first, 1, [&](std::size_t k) {
      const std::span whole = std::span(records).subspan(offsets[k], sizes[first + k]);
      const auto tile = whole.first(whole.size() - sizeof(std::uint64_t));
      if (StateReader(whole.last(sizeof(std::uint64_t))).template get<std::uint64_t>() !=
          digest(tile)) {
        as_written = false;
        return;
      }
      StateReader reader(tile);
      for (const SiteNumber s : state.tiling.sites_of(Tile(first + k))) {
        patches.load_cell(reader, s, cells.size(s));
        cells.load(reader, s, problem.points());
      }
      reader.expect_end();
    });
    if (!as_written) in.fail("is damaged: what it has of cells is not as written");
  });
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

/// Reads the run, if it is there.
template <class Scalar>
bool Run<Scalar>::continues() {
  std::error_code unknown;
  if (!is_kept() || std::filesystem::status(options.checkpoint, unknown).type() ==
                        std::filesystem::file_type::not_found) {
    return false;
  }
  const Clock::time_point start = Clock::now();
  load(options.checkpoint);
  kept_at = Clock::now();
  tell(CheckpointRecord::Event::continued, seconds_since(start));
  return true;
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
  if (seconds_since(kept_at) >= options.checkpoint_seconds) keep();
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
template void Run<float>::load_from(CheckpointReader&);
template void Run<double>::load_from(CheckpointReader&);
template bool Run<float>::continues();
template bool Run<double>::continues();
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
template void Run<float>::load_cells(CheckpointReader&, const Arena&, Cells<float>&,
                                     Relaxer<float>&) const;
template void Run<double>::load_cells(CheckpointReader&, const Arena&, Cells<double>&,
                                      Relaxer<double>&) const;

}  // namespace ccvt
