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
#include "exact/assignment.h"
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
  /// Of all vectors, or those of a rank: the problem's. `few_bytes`: see Vectors. `time_to_finish`:
  /// for a last exact assignment when training is cancelled.
  Trainer(Problem<Scalar> problem, const CodebookOptions& options,
          std::size_t few_bytes = kFewBytes,
          std::chrono::milliseconds time_to_finish = kTimeToFinish)
      : problem_(std::move(problem)),
        source_(problem_, few_bytes),
        vectors_(source_.here()),
        options_(options),
        // Ranks end together: see cancelled().
        stop_(problem_.ranks() != nullptr ? Stop() : Stop(options.cancelled, options.time_limit)),
        stop_of_ranks_(options.cancelled, options.time_limit),
        arena_(options.threads, &stop_),
        time_to_finish_(time_to_finish),
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
  /// The last owners of all vectors that met the capacities.
  struct Met {
    std::vector<Index> owners;
    std::vector<double> weights;
  };

  void seed();
  void train();
  void assign_all();
  void prove();
  void end_cancelled();
  void settle_for_less();
  [[nodiscard]] ExactAssignment<Scalar> exact_assignment() const;
  std::string settle_for_met();
  std::string settle_for_near();
  std::string settle_for_nearest();
  std::string deal_in_order();
  /// Of all vectors, where so many are; several ranks never fall back on them.
  void keep_met(Index vectors) {
    if (vectors == source_.count() && problem_.ranks() == nullptr) met_ = {owners_, weights_};
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
  Stop stop_of_ranks_;  ///< between iterations
  bool late_ = false;   ///< it was the time that ended ranks
  Arena arena_;
  std::chrono::milliseconds time_to_finish_;
  Metric metric_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<double> sites_;
  std::vector<double> weights_;
  std::vector<Index> owners_;
  Index owned_ = 0;  ///< of so many vectors owners_ are those that are here
  Met met_;
  bool bred_ = false;    ///< the sites are those of balanced cells
  bool placed_ = false;  ///< the sites are where capacities want them
  SettlingProgress progress_;
  CodebookSummary summary_;
};

}  // namespace ccvt
