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
Vectors<Scalar>::Vectors(PointsView<Scalar> own, Ranks* ranks) : own_(own) {
  const PartOfAll part = part_of_all(ranks, own.count);
  count_ = checked_vector_count(part.count);
  part_ = {ranks, part.first};
}

template <class Scalar>
std::vector<Index> Vectors<Scalar>::own_of(std::span<const Index> numbers) const {
  const auto begin = std::lower_bound(numbers.begin(), numbers.end(), part_.first);
  const auto end = std::lower_bound(begin, numbers.end(), part_.first + own_.count);
  std::vector<Index> here(begin, end);
  for (Index& number : here) number -= static_cast<Index>(part_.first);
  return here;
}

template <class Scalar>
Points<Scalar> Vectors<Scalar>::chosen(std::span<const Index> numbers) const {
  Points<Scalar> found = chosen_points(own_, own_of(numbers));
  if (part_.ranks == nullptr) return found;
  return gathered(*part_.ranks, found, static_cast<Index>(numbers.size()));
}

template <class Scalar>
Points<Scalar> Vectors<Scalar>::all() const {
  std::vector<Index> own(static_cast<std::size_t>(own_.count));
  std::iota(own.begin(), own.end(), 0);
  Points<Scalar> found = chosen_points(own_, own);
  if (part_.ranks == nullptr) return found;
  return gathered(*part_.ranks, found, count_);
}

template <class Scalar>
Sample Vectors<Scalar>::sample(std::span<const Index> numbers) const {
  if (part_.ranks == nullptr) return sample_of(own_, numbers);
  const Points<Scalar> gathered = chosen(numbers);
  std::vector<Index> all(numbers.size());
  std::iota(all.begin(), all.end(), 0);
  return sample_of(view_points(gathered), std::span<const Index>(all));
}

template class Vectors<float>;
template class Vectors<double>;

}  // namespace ccvt
