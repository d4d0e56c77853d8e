#include "codebook/vectors.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

#include "geometry/chosen_points.h"
#include "parallel/together.h"

namespace ccvt {

template <class Scalar>
Points<Scalar> Vectors<Scalar>::chosen(std::span<const Index> numbers) const {
  if (part_.ranks == nullptr) return chosen_points(own_, numbers);
  std::vector<Index> here;  // by their numbers on this rank
  for (const Index number : numbers) {
    const std::int64_t place = number - part_.first;
    if (place >= 0 && place < own_.count) here.push_back(static_cast<Index>(place));
  }
  const Points<Scalar> found = chosen_points(own_, here);
  const std::span<const Scalar> coordinates(found.data(), static_cast<std::size_t>(found.size()));
  Points<Scalar> all(own_.dimension, static_cast<Eigen::Index>(numbers.size()));
  auto* next = reinterpret_cast<std::byte*>(all.data());
  // Numbers ascend from rank to rank.
  for (const Ranks::Bytes& bytes : part_.ranks->gather(std::as_bytes(coordinates))) {
    next = std::copy(bytes.begin(), bytes.end(), next);
  }
  return all;
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
