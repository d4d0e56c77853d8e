#pragma once

#include <Eigen/Core>
#include <vector>

#include "parallel/arena.h"
#include "random.h"

namespace ccvt {

/// The whole-number vectors k != 0 in shells of |f|, f_d = k_d step_d, up to a highest frequency:
/// counts them and draws them, each of a shell equally likely.
///
/// |f|^2 is told in quanta: one is step^2 in a cube, where that is exact; else, and when there
/// would be more than 65536 of them, each term is rounded to a 65536th part of the highest |f|^2.
/// ways(d, s) counts the vectors of the first d dimensions that have s quanta, as the sum over k of
/// ways(d - 1, s - quanta of k); a draw walks this sum back [Nijenhuis, Wilf 1978]. The k > 0 that
/// have as many quanta are one run: in a thin box there are millions of k, but at most 65537 runs.
class FrequencyShells {
 public:
  static constexpr double kMostSteps = 0x1p30;

  /// Steps above 0, highest above 0 and at most kMostSteps of them.
  FrequencyShells(Eigen::VectorXd steps, double highest, const Arena& arena = Arena(1));

  /// How many k there are with lower <= |f| < upper, k and -k counted once.
  [[nodiscard]] double count(double lower, double upper) const;
  /// One of them; count(lower, upper) must be above 0.
  [[nodiscard]] Eigen::VectorXi draw(double lower, double upper, Random& random) const;

 private:
  using Row = std::vector<double>;  ///< by quanta

  /// Consecutive k > 0 of one dimension that have as many quanta.
  struct Run {
    std::size_t quanta;
    int first;
    int count;
  };

  /// Whole quanta; of more than most_, one more than that.
  [[nodiscard]] std::size_t capped(double quanta) const;
  [[nodiscard]] std::size_t first_at(double frequency) const;
  [[nodiscard]] std::size_t quanta_of(int d, int k) const;
  [[nodiscard]] std::vector<Run> runs_of(int d) const;

  Eigen::VectorXd steps_;
  double quantum_ = 0;
  double beyond_ = 0;  ///< one more than most_
  std::size_t most_ = 0;
  bool cube_ = false;
  std::vector<std::vector<Run>> runs_;  ///< by dimension, of up to most_ quanta
  std::vector<Row> ways_;               ///< by the number of dimensions, 0..D
};

}  // namespace ccvt
