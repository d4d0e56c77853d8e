#include "run_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "normalize.h"
#include "precision.h"

namespace ccvt {

RunRecord::RunRecord(const Options& options) {
  clock_.rest();
  if (!options.on_loop) return;
  clock_.listen([this, tell = options.on_loop](const Recorder::Loop& loop) {
    if (failure_) return;
    try {
      tell({name_of(loop.phase), loop.begin, loop.end, loop.tasks});
    } catch (...) {
      failure_ = std::current_exception();
    }
  });
}

/// A phase must not be left in the middle: what the callback threw is passed on here.
void RunRecord::rethrow() {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void RunRecord::begin(double energy, bool finest) {
  summary_.energy = energy;
  if (finest) summary_.initial_energy = energy;
}

bool RunRecord::add(const PassCount& pass, int level, std::int64_t points, double energy,
                    double progress, const Options& options) {
  IterationRecord record;
  record.iteration = ++summary_.iterations;
  record.level = level;
  record.levels = summary_.levels;
  record.points = points;
  record.full = pass.full;
  record.pairs = pass.pairs;
  record.swaps = pass.swaps;
  record.exchanged = pass.exchanged;
  record.active_sites = pass.active_sites;
  record.energy = energy;
  record.seconds = summary_.seconds_total;
  const auto& log = summary_.iterations_log;
  record.progress = std::max(log.empty() ? 0.0 : log.back().progress, std::min(progress, 1.0));
  summary_.pairs += pass.pairs;
  summary_.swaps += pass.swaps;
  summary_.exchanged += pass.exchanged;
  summary_.energy = energy;
  summary_.iterations_log.push_back(record);
  rethrow();
  return !options.on_iteration || options.on_iteration(summary_.iterations_log.back());
}

namespace {

/// Calls visit(value) for each part of a record that the clock has no say in.
template <class Record, class Visit>
void for_parts(Record& record, const Visit& visit) {
  visit(record.iteration);
  visit(record.level);
  visit(record.levels);
  visit(record.points);
  visit(record.full);
  visit(record.pairs);
  visit(record.swaps);
  visit(record.exchanged);
  visit(record.active_sites);
  visit(record.energy);
  visit(record.progress);
}

/// And for each such part of a summary that grows as the run goes on.
template <class Kept, class Visit>
void for_growing_parts(Kept& summary, const Visit& visit) {
  visit(summary.iterations);
  visit(summary.pairs);
  visit(summary.swaps);
  visit(summary.exchanged);
  visit(summary.initial_energy);
  visit(summary.energy);
}

/// The rest of a summary and its records, and of what the clock has charged.
template <class Kept, class Shares, class Visit>
void for_times(Kept& summary, Shares& shares, const Visit& visit) {
  visit(summary.seconds_total);
  visit(summary.seconds_initialization);
  visit(summary.seconds_relaxation);
  for (auto& share : shares) {
    visit(share.seconds);
    visit(share.work_seconds);
    visit(share.loops);
    visit(share.tasks);
  }
  for (auto& record : summary.iterations_log) visit(record.seconds);
}

}  // namespace

void RunRecord::save(ByteWriter& out) {
  const auto put = [&out](const auto& value) { out.put(value); };
  for_growing_parts(summary_, put);
  out.put(std::uint64_t{summary_.iterations_log.size()});
  for (const IterationRecord& record : summary_.iterations_log) for_parts(record, put);
  clock_.charge();
  for_times(summary_, clock_.shares(), put);
}

void RunRecord::load(ByteReader& in) {
  const auto get = [&in]<class T>(T& value) { value = in.get<T>(); };
  Summary summary = summary_;
  for_growing_parts(summary, get);
  summary.iterations_log.clear();
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
    for_parts(summary.iterations_log.emplace_back(), get);
  }
  std::array<Recorder::Share, kPhases> shares;
  for_times(summary, shares, get);
  in.expect_end();
  summary_ = std::move(summary);
  clock_.add(shares);
}

template <class Scalar>
void RunRecord::end(Termination termination, const Problem<Scalar>& problem, const Box& box) {
  summary_.termination = termination;
  normalize_energy(box, summary_);
  double capacity_error_sum = 0;
  const double n = problem.site_count();
  const double mean = static_cast<double>(problem.point_count()) / n;
  for (const Index c : problem.capacities()) {
    capacity_error_sum += std::pow(c / mean - 1, 2);
  }
  summary_.capacity_error = capacity_error_sum / n;
  const double spacing = std::min(
      spacing_in_box(box, summary_.points),
      spacing_in_cells(summary_.energy, summary_.points, summary_.sites, summary_.dimension));
  const std::string warning = problem.points().count == 0
                                  ? ""
                                  : coarse_coordinates<Scalar>("points", problem.points(), spacing);
  if (!warning.empty()) summary_.warnings.push_back(warning);
  clock_.charge();
  clock_.listen({});
  summary_.phases.clear();
  for (std::size_t k = 0; k < kPhases; ++k) {
    const Recorder::Share& share = clock_.shares()[k];
    summary_.phases.push_back({name_of(static_cast<Phase>(k)), share.seconds, share.work_seconds,
                               share.loops, share.tasks});
  }
  rethrow();
}

template void RunRecord::end(Termination, const Problem<float>&, const Box&);
template void RunRecord::end(Termination, const Problem<double>&, const Box&);

}  // namespace ccvt
