#pragma once

#include <span>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/types.h"
#include "codebook/sample.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// Throws InvalidInput, on all ranks alike, for more than Index counts.
Index checked_vector_count(std::int64_t count);

/// The vectors that samples are drawn from: all, or those of all ranks, each of which has its own.
template <class Scalar>
class Vectors {
 public:
  /// All of them. Not explicit: where they are all there, they are their own source.
  Vectors(PointsView<Scalar> all) : own_(all), count_(all.count) {}  // NOLINT
  explicit Vectors(const Problem<Scalar>& problem)
      : own_(problem.points()),
        count_(checked_vector_count(problem.point_count())),
        part_{problem.ranks(), problem.first_own_point()} {}
  /// Of several ranks, those of this one. All make the same call.
  Vectors(PointsView<Scalar> own, Ranks* ranks);

  [[nodiscard]] Index count() const { return count_; }
  [[nodiscard]] int dimension() const { return own_.dimension; }
  /// Of this rank; without ranks, all.
  [[nodiscard]] const PointsView<Scalar>& own() const { return own_; }
  [[nodiscard]] const RankPart& part() const { return part_; }
  /// Of these numbers, which ascend, those of this rank, by their numbers here.
  [[nodiscard]] std::vector<Index> own_of(std::span<const Index> numbers) const;

  /// A copy of those with these numbers, which ascend. Of several ranks, all ask for the same, and
  /// all get them all.
  [[nodiscard]] Points<Scalar> chosen(std::span<const Index> numbers) const;
  /// A copy of all, on all ranks.
  [[nodiscard]] Points<Scalar> all() const;
  /// The sample of them.
  [[nodiscard]] Sample sample(std::span<const Index> numbers) const;

 private:
  PointsView<Scalar> own_;
  Index count_;
  RankPart part_;
};

extern template class Vectors<float>;
extern template class Vectors<double>;

}  // namespace ccvt
