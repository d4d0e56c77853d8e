#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/types.h"
#include "codebook/sample.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// Throws InvalidInput, on all ranks alike, for more than Index counts.
Index checked_vector_count(std::int64_t count);

/// Vectors of all ranks are few that take no more than 64 MB, and are no more than so many: with
/// more of fewer dimensions, what each rank does for each takes as long as what it saves.
constexpr std::size_t kFewBytes = std::size_t{1} << 26;
constexpr std::int64_t kFewCount = std::int64_t{1} << 18;
constexpr bool are_few(std::int64_t count, int dimension, std::size_t scalar_bytes,
                       std::size_t few_bytes = kFewBytes) {
  const auto values = static_cast<std::size_t>(count) * static_cast<std::size_t>(dimension);
  return count <= kFewCount && values * scalar_bytes <= few_bytes;
}

/// The vectors that samples are drawn from and codebooks trained on. Of several ranks, each has its
/// own; but where they are few, all have all, and share the work on them: to ask each other about
/// each vector that moves would take ranks longer than the work.
template <class Scalar>
class Vectors {
 public:
  /// All of them. Not explicit: where they are all there, they are their own source.
  Vectors(PointsView<Scalar> all) : here_(all), count_(all.count) {}  // NOLINT
  /// Those of the problem. All ranks make the same call.
  explicit Vectors(const Problem<Scalar>& problem, std::size_t few_bytes = kFewBytes);
  Vectors(const Vectors&) = delete;
  Vectors& operator=(const Vectors&) = delete;

  [[nodiscard]] Index count() const { return count_; }
  [[nodiscard]] int dimension() const { return here_.dimension; }
  /// All, or those of this rank.
  [[nodiscard]] const PointsView<Scalar>& here() const { return here_; }
  /// Which these are; no ranks where all are here.
  [[nodiscard]] const RankPart& part() const { return part_; }
  /// What a rank is to have of them where each must have its own.
  struct Own {
    Ranks* ranks;
    Index first;
    Index count;
  };
  [[nodiscard]] Own own() const;
  /// Of values for a rank's own(), those of here().
  [[nodiscard]] std::vector<Index> of_here(std::vector<Index> own) const;

  /// Those with these numbers, which ascend. Of several ranks, all make the same call; numbers of
  /// vectors that are not here need not be among them.
  [[nodiscard]] Vectors chosen_vectors(std::span<const Index> numbers) const;
  /// A copy of those with these numbers, which ascend. Of several ranks, all ask for the same, and
  /// all get them all.
  [[nodiscard]] Points<Scalar> chosen(std::span<const Index> numbers) const;
  /// A copy of all, on all ranks.
  [[nodiscard]] Points<Scalar> all() const;
  /// The sample of them.
  [[nodiscard]] Sample sample(std::span<const Index> numbers) const;

 private:
  Vectors(Points<Scalar> copy, const Vectors& source);
  void gather_few();
  [[nodiscard]] std::vector<Index> here_of(std::span<const Index> numbers) const;

  Points<Scalar> copy_;  ///< of those here, unless they are somebody else's
  PointsView<Scalar> here_;
  Index count_;
  RankPart part_;
  Ranks* ranks_ = nullptr;
  std::size_t few_bytes_ = 0;
};

extern template class Vectors<float>;
extern template class Vectors<double>;

}  // namespace ccvt
