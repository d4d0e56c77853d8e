#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "ccvt/capacity.h"
#include "cell_sizes.h"
#include "codebook/codeword_steps.h"
#include "codebook/sample.h"
#include "codebook/share.h"
#include "codebook/trainer.h"
#include "exact/assignment.h"
#include "exact/centroids.h"
#include "exact/pricing.h"
#include "geometry/chosen_points.h"
#include "parallel/together.h"
#include "streams.h"

namespace ccvt {
namespace {

/// A level ends when an iteration gains less than this share, times codewords a vector: the more
/// vectors a codeword, the better the sample tells where codewords belong, and the more iterations
/// does each level save the next. With 1e-3 for all, 16 codewords of 2^20 vectors take two and a
/// half times as long.
constexpr double kLevelTolerance = 0.032;
/// Exchanges between pairs before the first exact assignment end when an iteration gains less than
/// this share.
constexpr double kStartTolerance = 1e-3;
/// With so many vectors a codeword, or fewer, there are none: what they end at keeps the distortion
/// up that exact assignments would come down to, by up to 1.4 % at 8 vectors a codeword, 3 % at 4
/// and 3 to 8 % at 2; at 12 and more it makes no difference, and they save time.
constexpr std::int64_t kFewVectors = 8;
/// They take about as long as so much of a level on the same vectors.
constexpr double kStartWork = 0.5;
/// With so many vectors a codeword, or more, codewords take steps beyond centroids. With fewer they
/// take about as long as they save: most of the time goes into vectors that change places.
constexpr Index kSmooth = 128;

}  // namespace

/// What exact assignments start from where no codewords are given. `work`: of all the training, in
/// vectors of levels.
template <class Scalar>
void Trainer<Scalar>::start_exact(const Vectors<Scalar>& vectors, std::vector<Index> capacities,
                                  double work) {
  progress_.begin(kStartWork * vectors.count() / work);
  if (capacities.empty()) capacities = equal_capacities(vectors.count(), problem_.site_count());
  const bool pairs = vectors.count() > kFewVectors * problem_.site_count();
  start_balanced(vectors, std::move(capacities),
                 pairs ? std::optional(kStartTolerance) : std::nullopt);
  keep_met(vectors.count());
  if (summary_.termination == Termination::cancelled) throw Stopped();
  if (summary_.termination != Termination::iteration_limit) {
    summary_.termination = Termination::running;
  }
}

/// Exact assignments and centroids in turn; sites_ are those of the cells that were kept last, and
/// assignments are made for these or for sites beyond them. On the finest level until the
/// assignment is optimal, or within the gap of that, for the centroids of its own cells.
template <class Scalar>
void Trainer<Scalar>::exact_level(const Vectors<Scalar>& vectors, std::vector<Index> capacities,
                                  double work) {
  const Index m = vectors.count();
  Ranks* const ranks = vectors.part().ranks;
  const bool finest = m == trained_on();
  progress_.begin(m / work);
  const Index n = problem_.site_count();
  const std::vector<Index> shares = capacities.empty() ? equal_capacities(m, n) : capacities;
  CodewordSteps steps(sites_, static_cast<std::size_t>(vectors_.dimension), shares,
                      m / n >= kSmooth, arena_);
  ExactAssignment<Scalar> assignment(metric_, vectors.here(), n, std::move(capacities), arena_,
                                     options_.gap, vectors.part());
  using Round = typename ExactAssignment<Scalar>::Round;
  own_nearest(vectors);
  const double tolerance = finest ? options_.tolerance : kLevelTolerance * n / m;
  double before = std::numeric_limits<double>::infinity();
  bool assigned = false;  // the owners meet the capacities
  while (!ended()) {
    std::vector<Index> given = owners_;
    std::vector<double> weights_given = weights_;
    const bool optimal = assignment.improve(steps.sites(), weights_, owners_) == Round::optimal;
    // What the owners given, those of the iteration before, cost at their own centroids.
    const double energy = assignment.last().energy - steps.excess();
    const bool idle = assigned && (optimal || before - energy < kTrainingRounding * before);
    const bool slow = assigned && before - energy < tolerance * before;
    if ((idle || slow) && steps.at_centroids()) {
      if (finest) {
        summary_.termination = idle ? Termination::stable : Termination::energy_tolerance;
      }
      break;
    }
    std::vector<std::uint8_t> changed;
    if (assigned) {
      before = energy;
      changed = changed_cells(given, owners_, weights_.size(), ranks);
    }
    // What a step beyond centroids led to may not be kept.
    if (steps.at_centroids()) keep_met(m);
    std::int64_t moved = 0;
    for (std::size_t p = 0; p < given.size(); ++p) moved += owners_[p] != given[p] ? 1 : 0;
    const bool goes_on = go_on(m, energy, total(ranks, moved));
    if (!goes_on && steps.at_centroids()) break;
    move_to_centroids(metric_, vectors.here(), Grouping(owners_, weights_.size(), arena_), arena_,
                      sites_, changed, ranks);
    const Stop::Pause pause(stop_);  // until owners and sites are of the same cells again
    std::vector<Index> sizes;
    if (steps.smooth()) sizes = summed(ranks, cell_sizes(owners_, weights_.size()));
    if (!steps.advance(sites_, std::move(sizes), idle || slow || !goes_on)) {
      owners_ = std::move(given);
      weights_ = std::move(weights_given);
      before = std::numeric_limits<double>::infinity();
    }
    keep_met(m);
    assigned = true;
    if (!goes_on) break;
  }
}

/// A sample to train on.
template <class Scalar>
Vectors<Scalar> Trainer<Scalar>::level(Index count) const {
  std::vector<Index> numbers;
  if (bred_) {
    // What was bred fits the shares of the clouds, which a sample that has others would undo.
    numbers = draw_evenly(source_, sites_, count, options_.seed, arena_);
    std::sort(numbers.begin(), numbers.end());
  } else {
    numbers = draw_distinct(count, source_.count(), options_.seed, streams::codebook_levels);
  }
  return source_.chosen_vectors(numbers);
}

/// Level by level, each on a sample; the finest on all vectors, or on the sample asked for.
template <class Scalar>
void Trainer<Scalar>::exact() {
  const Index m = source_.count();
  const bool all = trained_on() == m;
  const auto& capacities = options_.capacities;
  std::vector<Index> counts = level_sizes(trained_on(), problem_.site_count());
  if (!all) counts.push_back(trained_on());
  double work = std::accumulate(counts.begin(), counts.end(), 1.0 * m);
  if (!placed_) work += kStartWork * (counts.empty() ? m : counts.front());
  if (options_.max_iterations == 0) summary_.termination = Termination::iteration_limit;
  for (const Index count : counts) {
    if (ended()) break;
    arena_.check();
    const Vectors<Scalar> sample = level(count);
    const std::vector<Index> shares = share_capacities(capacities, m, count);
    if (!placed_ && count == counts.front()) start_exact(sample, shares, work);
    exact_level(sample, shares, work);
  }
  if (!placed_ && counts.empty() && !ended()) start_exact(source_, capacities, work);
  if (summary_.termination == Termination::cancelled) throw Stopped();
  if (all) {
    exact_level(source_, capacities, work);
  } else {
    owners_ =
        Pricer<Scalar>(metric_, vectors_, arena_, source_.part()).cheapest({sites_, weights_});
    owned_ = m;
    return assign_all();
  }
  if (summary_.termination == Termination::cancelled) throw Stopped();
  prove();
}

/// The exact assignment of all vectors, for the centroids of the one for the codewords of a sample.
template <class Scalar>
void Trainer<Scalar>::assign_all() {
  ExactAssignment<Scalar> assignment = exact_assignment();
  assignment.improve(sites_, weights_, owners_);
  {
    const Stop::Pause pause(stop_);  // until owners and sites are of the same cells
    move_to_centroids(metric_, vectors_, Grouping(owners_, weights_.size(), arena_), arena_, sites_,
                      {}, source_.part().ranks);
    keep_met(source_.count());
  }
  summary_.gap = assignment.solve(sites_, weights_, owners_).share();
}

/// The exact assignment for the codewords as they are, and its certificate.
template <class Scalar>
void Trainer<Scalar>::prove() {
  summary_.gap = exact_assignment().solve(sites_, weights_, owners_).share();
}

/// Of all vectors.
template <class Scalar>
ExactAssignment<Scalar> Trainer<Scalar>::exact_assignment() const {
  return {metric_, vectors_,     problem_.site_count(), options_.capacities,
          arena_,  options_.gap, source_.part()};
}

template void Trainer<float>::exact();
template void Trainer<double>::exact();
template void Trainer<float>::assign_all();
template void Trainer<double>::assign_all();
template void Trainer<float>::prove();
template void Trainer<double>::prove();
template ExactAssignment<float> Trainer<float>::exact_assignment() const;
template ExactAssignment<double> Trainer<double>::exact_assignment() const;

}  // namespace ccvt
