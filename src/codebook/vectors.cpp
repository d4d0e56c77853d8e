#include "codebook/vectors.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "geometry/chosen_points.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {

namespace {

/// The points of all ranks, one rank's after the other's.
template <class Scalar>
Points<Scalar> gathered(Ranks& ranks, const Points<Scalar>& own, Index count) {
  const std::span<const Scalar> coordinates(own.data(), static_cast<std::size_t>(own.size()));
  Points<Scalar> all(own.rows(), count);
  auto* next = reinterpret_cast<std::byte*>(all.data());
  for (const Ranks::Bytes& bytes : ranks.gather(std::as_bytes(coordinates))) {
    next = std::copy(bytes.begin(), bytes.end(), next);
  }
  return all;
}

}  // namespace

Index checked_vector_count(std::int64_t count) {
  if (count > std::numeric_limits<Index>::max()) {
    throw InvalidInput("vectors: there are " + std::to_string(count) +
                       " of them on all ranks, but at most 2147483647 are supported");
  }
  return static_cast<Index>(count);
}

template <class Scalar>
Vectors<Scalar>::Vectors(const Problem<Scalar>& problem, std::size_t few_bytes)
    : here_(problem.points()),
      count_(checked_vector_count(problem.point_count())),
      part_{problem.ranks(), problem.first_own_point()},
      ranks_(problem.ranks()),
      few_bytes_(few_bytes) {
  gather_few();
}

/// `copy`: some of those that are here in the source.
template <class Scalar>
Vectors<Scalar>::Vectors(Points<Scalar> copy, const Vectors& source)
    : copy_(std::move(copy)),
      here_(view_points(copy_)),
      count_(here_.count),
      ranks_(source.ranks_),
      few_bytes_(source.few_bytes_) {
  if (source.part_.ranks == nullptr) return;
  const PartOfAll part = part_of_all(ranks_, count_);
  count_ = checked_vector_count(part.count);
  part_ = {ranks_, part.first};
  gather_few();
}

/// Where they are few, all ranks have all.
template <class Scalar>
void Vectors<Scalar>::gather_few() {
  if (part_.ranks == nullptr || !are_few(count_, dimension(), sizeof(Scalar), few_bytes_)) return;
  copy_ = all();
  here_ = view_points(copy_);
  part_ = {};
}

template <class Scalar>
auto Vectors<Scalar>::own() const -> Own {
  if (part_.ranks != nullptr) return {ranks_, static_cast<Index>(part_.first), here_.count};
  const RankRange range(ranks_, static_cast<std::size_t>(count_), 1);
  return {ranks_, static_cast<Index>(range.begin), static_cast<Index>(range.end - range.begin)};
}

template <class Scalar>
std::vector<Index> Vectors<Scalar>::of_here(std::vector<Index> own) const {
  return part_.ranks == nullptr ? joined(ranks_, std::move(own)) : own;
}

template <class Scalar>
std::vector<Index> Vectors<Scalar>::here_of(std::span<const Index> numbers) const {
  const auto begin = std::lower_bound(numbers.begin(), numbers.end(), part_.first);
  const auto end = std::lower_bound(begin, numbers.end(), part_.first + here_.count);
  std::vector<Index> here(begin, end);
  for (Index& number : here) number -= static_cast<Index>(part_.first);
  return here;
}

template <class Scalar>
Vectors<Scalar> Vectors<Scalar>::chosen_vectors(std::span<const Index> numbers) const {
  return {chosen_points(here_, here_of(numbers)), *this};
}

template <class Scalar>
Points<Scalar> Vectors<Scalar>::chosen(std::span<const Index> numbers) const {
  Points<Scalar> found = chosen_points(here_, here_of(numbers));
  if (part_.ranks == nullptr) return found;
  return gathered(*part_.ranks, found, static_cast<Index>(numbers.size()));
}

template <class Scalar>
Points<Scalar> Vectors<Scalar>::all() const {
  std::vector<Index> own(static_cast<std::size_t>(here_.count));
  std::iota(own.begin(), own.end(), 0);
  Points<Scalar> found = chosen_points(here_, own);
  if (part_.ranks == nullptr) return found;
  return gathered(*part_.ranks, found, count_);
}

template <class Scalar>
Sample Vectors<Scalar>::sample(std::span<const Index> numbers) const {
  if (part_.ranks == nullptr) return sample_of(here_, numbers);
  const Points<Scalar> gathered = chosen(numbers);
  std::vector<Index> all(numbers.size());
  std::iota(all.begin(), all.end(), 0);
  return sample_of(view_points(gathered), std::span<const Index>(all));
}

template class Vectors<float>;
template class Vectors<double>;

}  // namespace ccvt
