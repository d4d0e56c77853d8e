#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/problem.h"
#include "codebook/vectors.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "parallel/stop.h"
#include "settling_progress.h"

namespace ccvt {

/// A gain below this share is rounding.
constexpr double kTrainingRounding = 1e-13;

/// One training of a codebook, from seeds to codes.
template <class Scalar>
class Trainer {
 public:
  /// Of all vectors, or those of a rank: the problem's. `few_bytes`: see Vectors.
  Trainer(Problem<Scalar> problem, const CodebookOptions& options,
          std::size_t few_bytes = kFewBytes)
      : problem_(std::move(problem)),
        source_(problem_, few_bytes),
        vectors_(source_.here()),
        options_(options),
        // Ranks end together: see cancelled().
        stop_(problem_.ranks() != nullptr ? Stop() : Stop(options.cancelled)),
        arena_(options.threads, &stop_),
        metric_(vectors_.dimension, Domain()) {
    arena_.divide_among(problem_.ranks());
    if (!options.capacities.empty()) problem_.set_capacities(options.capacities);
    if (options.train_sample > 0 && options.train_sample < problem_.site_count()) {
      throw InvalidInput("train_sample is " + std::to_string(options.train_sample) +
                         ": it must be 0, or at least the number of codewords, " +
                         std::to_string(problem_.site_count()));
    }
    summary_.method = options.method;
    summary_.dimension = vectors_.dimension;
    summary_.vectors = source_.count();
    summary_.codewords = problem_.site_count();
    summary_.seed = options.seed;
    summary_.threads_used = arena_.threads();
  }

  Training run(const Columns<double>* codewords);

 private:
  void seed();
  void train();
  void prove();
  void end_cancelled();
  void settle_for_less();
  /// Of all vectors, where so many are; several ranks never fall back on them.
  void keep_met(Index vectors) {
    if (vectors == source_.count() && problem_.ranks() == nullptr) met_ = owners_;
  }
  void own_nearest(const Vectors<Scalar>& vectors);
  void lloyd();
  void pairwise();
  template <class Work>
  void undivided(const Work& work);
  void start_balanced(const Vectors<Scalar>& vectors, std::vector<Index> capacities,
                      std::optional<double> pairs_tolerance);
  void exchange_pairs(const Vectors<Scalar>& vectors, PointsView<Scalar> all,
                      std::vector<Index> capacities, double tolerance);
  void start_exact(const Vectors<Scalar>& vectors, std::vector<Index> capacities, double work);
  void exact();
  void exact_level(const Vectors<Scalar>& vectors, std::vector<Index> capacities, double work);
  [[nodiscard]] Vectors<Scalar> level(Index count) const;
  bool go_on(IterationRecord record);
  bool go_on(Index vectors, double energy, std::int64_t moved);
  bool cancelled(const IterationRecord& record);
  void sum_up(const Codebook& codebook);
  /// Vectors of the finest level.
  [[nodiscard]] Index trained_on() const {
    return options_.train_sample > 0 ? std::min(options_.train_sample, source_.count())
                                     : source_.count();
  }
  bool ended() const { return summary_.termination != Termination::running; }

  Problem<Scalar> problem_;
  Vectors<Scalar> source_;
  PointsView<Scalar> vectors_;  ///< all, or those of this rank
  const CodebookOptions& options_;
  Stop stop_;
  Arena arena_;
  Metric metric_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<double> sites_;
  std::vector<double> weights_;
  std::vector<Index> owners_;
  Index owned_ = 0;         ///< of so many vectors owners_ are those that are here
  std::vector<Index> met_;  ///< the last owners of all vectors that met the capacities
  bool bred_ = false;       ///< the sites are those of balanced cells
  bool placed_ = false;     ///< the sites are where capacities want them
  SettlingProgress progress_;
  CodebookSummary summary_;
};

}  // namespace ccvt
