#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "ccvt/codebook.h"
#include "checkpoint/digest.h"
#include "codebook/breeding.h"
#include "codebook/far_vectors.h"
#include "codebook/pairwise.h"
#include "codebook/seeding.h"
#include "codebook/share.h"
#include "codebook/trainer.h"
#include "exact/cell_bounds.h"
#include "exact/centroids.h"
#include "exact/grouping.h"
#include "exact/move_costs.h"
#include "exact/pricing.h"
#include "exact/weighted_sites.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/alike.h"
#include "parallel/together.h"
#include "precision.h"

namespace ccvt {
namespace {

/// Of a time limit, the share after which breeding ends.
constexpr double kBreedingTime = 1.0 / 3;
constexpr double kLongest = 1e9;  // seconds; beyond, the clock has no such time

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double seconds_since(Clock::time_point start) { return Seconds(Clock::now() - start).count(); }

/// Throws InvalidInput on all ranks where they were given different things. `codewords`: given to
/// start from.
void require_alike(Ranks& ranks, const CodebookOptions& options,
                   std::span<const double> codewords) {
  const std::vector<Given> given = {
      {"CodebookOptions::method", to_string(options.method)},
      {"CodebookOptions::seeding", concat(static_cast<int>(options.seeding))},
      {"CodebookOptions::restarts", concat(options.restarts)},
      {"CodebookOptions::effort", options.effort ? concat(*options.effort) : "the usual"},
      {"CodebookOptions::max_iterations", concat(options.max_iterations)},
      {"CodebookOptions::tolerance", concat(options.tolerance)},
      {"CodebookOptions::gap", concat(options.gap)},
      {"CodebookOptions::train_sample", concat(options.train_sample)},
      {"CodebookOptions::seed", concat(options.seed)},
      {"CodebookOptions::capacities", concat(digest_of(std::span<const Index>(options.capacities))),
       false},
      {"codewords", concat(digest_of(codewords)), false}};
  require_alike(ranks, given);
}

void check_given(const Columns<double>& codewords, int dimension, const CodebookOptions& options) {
  if (codewords.rows() != dimension) {
    throw InvalidInput("codewords: have " + std::to_string(codewords.rows()) +
                       " dimensions, but the vectors have " + std::to_string(dimension));
  }
  if (options.effort.value_or(0) > 0) {
    throw InvalidInput(
        "effort is " + std::to_string(*options.effort) +
        ": it must be 0 where codewords are given, for they take the place of bred ones");
  }
  const Codebook checked(codewords);  // throws
}

}  // namespace

/// Calls work(). Of several ranks, each does it all, but for what work() divides itself.
template <class Scalar>
template <class Work>
void Trainer<Scalar>::undivided(const Work& work) {
  arena_.divide_among(nullptr);
  work();
  arena_.divide_among(problem_.ranks());
}

template <class Scalar>
void Trainer<Scalar>::seed() {
  const Index n = problem_.site_count();
  Breeding breeding;
  breeding.seedings = options_.restarts > 0 ? options_.restarts : kRestarts;
  breeding.seed = options_.seed;
  breeding.ranks = problem_.ranks();
  breeding.random = options_.seeding == Seeding::random;
  if (options_.time_limit > 0 && options_.time_limit < kLongest) {
    breeding.until = start_ + std::chrono::duration_cast<Clock::duration>(
                                  kBreedingTime * Seconds(options_.time_limit));
  }
  const bool usual = breeding.seedings > 1 && !breeding.random;
  breeding.children = options_.effort.value_or(usual ? usual_effort(n, vectors_.dimension) : 0);
  if (breeding.children > 0 && n > 1 && options_.method != CodebookMethod::lloyd) {
    BredSites bred;
    undivided([&] { bred = breed_sites(source_, problem_.capacities(), breeding, arena_); });
    if (!bred.sites.empty()) {
      sites_ = std::move(bred.sites);
      if (options_.method == CodebookMethod::exact) weights_ = std::move(bred.weights);
      bred_ = true;
      placed_ = true;
      return;
    }
  }
  const auto choose = breeding.random ? draw_sites<Scalar> : seed_sites<Scalar>;
  sites_ = choose(source_, n, options_.restarts, options_.seed, arena_);
}

/// Reports an iteration; false when training ends with it.
template <class Scalar>
bool Trainer<Scalar>::go_on(IterationRecord record) {
  record.iteration = ++summary_.iterations;
  record.seconds = seconds_since(start_);
  if (cancelled(record)) {
    summary_.termination = Termination::cancelled;
  } else if (summary_.iterations >= options_.max_iterations) {
    summary_.termination = Termination::iteration_limit;
  }
  return !ended();
}

/// Whether training is to end after this iteration: on all ranks, where one of them is to.
template <class Scalar>
bool Trainer<Scalar>::cancelled(const IterationRecord& record) {
  const bool wished = options_.on_iteration && !options_.on_iteration(record);
  if (problem_.ranks() == nullptr) return wished || stop_.requested();
  const bool own = stop_of_ranks_.requested() || wished;
  late_ = any(problem_.ranks(), stop_of_ranks_.late());
  return any(problem_.ranks(), own);
}

template <class Scalar>
void Trainer<Scalar>::lloyd() {
  Ranks* const ranks = source_.part().ranks;
  own_nearest(source_);
  const Pricer<Scalar> pricer(metric_, vectors_, arena_, source_.part());
  const std::size_t n = weights_.size();
  std::optional<CellBounds> kept;
  const RankTurns turns(sharing(arena_, source_.part()));
  if (CellBounds::fit(metric_, n)) kept.emplace(owners_.size(), n, turns);
  std::vector<std::uint8_t> changed;
  if (options_.max_iterations == 0) summary_.termination = Termination::iteration_limit;
  double before = std::numeric_limits<double>::infinity();
  progress_.begin(1);
  while (!ended()) {
    if (kept && std::isfinite(before)) {
      kept->include_all(owners_, SquaredDistances<Scalar>(metric_, vectors_, sites_), arena_);
    }
    move_to_centroids(metric_, vectors_, Grouping(owners_, n, arena_), arena_, sites_, changed,
                      ranks);
    const std::vector<Index> given = owners_;
    const Prices prices = pricer.price({sites_, weights_}, owners_, kept ? &*kept : nullptr);
    changed = changed_cells(given, owners_, n, ranks);
    const double energy = prices.cheapest_energy;
    const bool running = go_on(source_.count(), energy, prices.moved);
    if (prices.moved == 0 || energy >= before * (1 - kTrainingRounding)) {
      summary_.termination = Termination::stable;
    } else if (running && before - energy < options_.tolerance * before) {
      summary_.termination = Termination::energy_tolerance;
    }
    before = energy;
  }
}

/// Unless these vectors have owners, the nearest sites are.
template <class Scalar>
void Trainer<Scalar>::own_nearest(const Vectors<Scalar>& vectors) {
  if (owned_ == vectors.count()) return;
  owners_ = nearest_owners(metric_, vectors.here(), sites_, arena_, vectors.part());
  owned_ = vectors.count();
}

template <class Scalar>
bool Trainer<Scalar>::go_on(Index vectors, double energy, std::int64_t moved) {
  IterationRecord record;
  record.points = vectors;
  record.exchanged = moved;
  record.energy = energy;
  record.progress = progress_.moved(moved);
  record.active_sites = problem_.site_count();
  return go_on(record);
}

/// Puts seeds where capacities want them; then, if asked for, exchanges between pairs of cells and
/// centroids in turn.
template <class Scalar>
void Trainer<Scalar>::start_balanced(const Vectors<Scalar>& vectors, std::vector<Index> capacities,
                                     std::optional<double> pairs_tolerance) {
  const bool shared = !placed_ && options_.seeding == Seeding::kmeans_plus_plus;
  if (!shared && !pairs_tolerance) return;
  const bool several = vectors.part().ranks != nullptr;
  const Points<Scalar> gathered = several ? vectors.all() : Points<Scalar>();
  const PointsView<Scalar> all = several ? view_points(gathered) : vectors.here();
  if (shared) {
    const std::vector<Index> owners = nearest_owners(metric_, all, sites_, arena_);
    undivided(
        [&] { sites_ = share_sites(all, owners, sites_, capacities, options_.seed, arena_); });
  }
  if (pairs_tolerance) exchange_pairs(vectors, all, std::move(capacities), *pairs_tolerance);
}

/// `all`: of several ranks, gathered.
template <class Scalar>
void Trainer<Scalar>::exchange_pairs(const Vectors<Scalar>& vectors, PointsView<Scalar> all,
                                     std::vector<Index> capacities, double tolerance) {
  Options options;
  options.threads = options_.threads;
  options.seed = options_.seed;
  options.max_iterations = options_.max_iterations;
  options.energy_tolerance = tolerance;
  options.on_iteration = [&](IterationRecord record) {
    record.progress = progress_.reach(record.progress);
    return go_on(record);
  };
  if (problem_.ranks() == nullptr) {  // ranks end together
    options.cancelled = [this] { return stop_.requested(); };
  }
  options.multilevel = false;  // the seeds are better than what a coarse level would make of them
  PairwiseCells cells =
      pairwise_cells(vectors, all, sites_, std::move(capacities), options, arena_);
  if (!ended()) summary_.termination = cells.termination;
  owners_ = vectors.of_here(std::move(cells.owners));
  owned_ = vectors.count();
  const Stop::Pause pause(stop_);  // what comes is short
  move_to_centroids(metric_, vectors.here(), Grouping(owners_, weights_.size(), arena_), arena_,
                    sites_, {}, vectors.part().ranks);
}

template <class Scalar>
void Trainer<Scalar>::pairwise() {
  progress_.begin(1);
  start_balanced(source_, problem_.capacities(), options_.tolerance);
  stop_.off();
}

template <class Scalar>
void Trainer<Scalar>::train() {
  switch (options_.method) {
    case CodebookMethod::exact:
      return exact();
    case CodebookMethod::pairwise:
      return pairwise();
    case CodebookMethod::lloyd:
      return lloyd();
  }
}

template <class Scalar>
Training Trainer<Scalar>::run(const Columns<double>* codewords) {
  const Index n = problem_.site_count();
  weights_.assign(problem_.capacities().size(), 0.0);
  try {
    if (codewords != nullptr) {
      placed_ = true;
      sites_.assign(codewords->data(), codewords->data() + codewords->size());
    } else {
      seed();
    }
    summary_.seconds_seeding = seconds_since(start_);
    if (stop_.requested()) throw Stopped();  // seeding may have been cut short
    train();
  } catch (const Stopped&) {
    end_cancelled();
  }
  if (summary_.termination == Termination::cancelled && (stop_.late() || late_)) {
    summary_.termination = Termination::time_limit;
  }
  if (problem_.ranks() != nullptr && source_.part().ranks == nullptr) {  // all are here
    const auto own = owners_.begin() + static_cast<std::ptrdiff_t>(problem_.first_own_point());
    owners_ = std::vector<Index>(own, own + problem_.points().count);
  }
  bring_near_zero(weights_);
  Coordinates weights = Coordinates::constant(n, 0);
  std::copy(weights_.begin(), weights_.end(), weights.data());
  Codebook codebook(Eigen::Map<const Eigen::MatrixXd>(sites_.data(), vectors_.dimension, n),
                    std::move(weights));
  sum_up(codebook);
  summary_.seconds_total = seconds_since(start_);
  return {std::move(codebook), std::move(owners_), summary_};
}

template <class Scalar>
void Trainer<Scalar>::sum_up(const Codebook& codebook) {
  const Index n = problem_.site_count();
  const Index m = source_.count();
  if (Ranks* const ranks = problem_.ranks(); ranks != nullptr) {
    summary_.usage = code_usage(*ranks, owners_, n);
    summary_.distortion = codebook.distortion(*ranks, problem_.points(), owners_);
  } else {
    summary_.usage = code_usage(owners_, n);
    summary_.distortion = codebook.distortion(vectors_, owners_);
  }
  summary_.energy = summary_.distortion * m;
  const Points<Scalar> looked = source_.chosen(looked_at(m));
  const std::string warning = coarse_coordinates<Scalar>(
      "vectors", view_points(looked), spacing_in_cells(summary_.energy, m, n, vectors_.dimension));
  if (!warning.empty()) summary_.warnings.push_back(warning);
  const std::string far =
      far_vectors(problem_.ranks(), problem_.points(), problem_.first_own_point(), owners_, sites_);
  if (!far.empty()) summary_.warnings.push_back(far);
}

template class Trainer<float>;
template class Trainer<double>;

namespace {

/// Throws InvalidInput, on all ranks (null: this one), for a number of codewords that the vectors
/// of all cannot have.
void check_counts(Ranks* ranks, Index codewords, Index own) {
  const std::int64_t vectors = total(ranks, own);
  agree(ranks, [&] {
    if (vectors < 1) throw InvalidInput("vectors: there are none");
    if (codewords >= 1 && codewords <= vectors) return;
    throw InvalidInput(concat("codewords: is ", codewords, " for ", vectors,
                              " vectors: must be at least 1, and at most as many"));
  });
}

}  // namespace

template <class Scalar>
Training train_codebook(PointsView<Scalar> vectors, Index codewords,
                        const CodebookOptions& options) {
  options.validate();
  check_counts(nullptr, codewords, vectors.count);
  return Trainer<Scalar>(Problem<Scalar>(vectors, codewords), options).run(nullptr);
}

template <class Scalar>
Training train_codebook(Ranks& ranks, PointsView<Scalar> own, Index codewords,
                        const CodebookOptions& options) {
  agree(&ranks, [&] { options.validate(); });
  check_counts(&ranks, codewords, own.count);
  require_alike(ranks, options, {});
  return Trainer<Scalar>(Problem<Scalar>(ranks, own, codewords), options).run(nullptr);
}

template <class Scalar>
Training train_codebook_from(PointsView<Scalar> vectors, const Columns<double>& codewords,
                             const CodebookOptions& options) {
  options.validate();
  check_given(codewords, vectors.dimension, options);
  const auto n = static_cast<Index>(codewords.cols());
  check_counts(nullptr, n, vectors.count);
  return Trainer<Scalar>(Problem<Scalar>(vectors, n), options).run(&codewords);
}

template <class Scalar>
Training train_codebook_from(Ranks& ranks, PointsView<Scalar> own, const Columns<double>& codewords,
                             const CodebookOptions& options) {
  agree(&ranks, [&] {
    options.validate();
    check_given(codewords, own.dimension, options);
  });
  require_alike(ranks, options, {codewords.data(), static_cast<std::size_t>(codewords.size())});
  const auto n = static_cast<Index>(codewords.cols());
  check_counts(&ranks, n, own.count);
  return Trainer<Scalar>(Problem<Scalar>(ranks, own, n), options).run(&codewords);
}

template CCVT_EXPORT Training train_codebook(PointsView<float>, Index, const CodebookOptions&);
template CCVT_EXPORT Training train_codebook(PointsView<double>, Index, const CodebookOptions&);
template CCVT_EXPORT Training train_codebook(Ranks&, PointsView<float>, Index,
                                             const CodebookOptions&);
template CCVT_EXPORT Training train_codebook(Ranks&, PointsView<double>, Index,
                                             const CodebookOptions&);
template CCVT_EXPORT Training train_codebook_from(Ranks&, PointsView<float>, const Columns<double>&,
                                                  const CodebookOptions&);
template CCVT_EXPORT Training train_codebook_from(Ranks&, PointsView<double>,
                                                  const Columns<double>&, const CodebookOptions&);
template CCVT_EXPORT Training train_codebook_from(PointsView<float>, const Columns<double>&,
                                                  const CodebookOptions&);
template CCVT_EXPORT Training train_codebook_from(PointsView<double>, const Columns<double>&,
                                                  const CodebookOptions&);

}  // namespace ccvt
