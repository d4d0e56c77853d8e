#include "codebook/far_vectors.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "exact/distances.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// Training ends when an iteration gains 1e-13 of the energy: no cell of a hundred times as much
/// comes to its end.
constexpr double kHardlySeen = 1e-11;

/// The middle one of the energies that are not 0, or 0.
double median(std::vector<double> energies) {
  std::erase_if(energies, [](double energy) { return !(energy > 0); });
  if (energies.empty()) return 0;
  const auto middle = energies.begin() + std::ssize(energies) / 2;
  std::nth_element(energies.begin(), middle, energies.end());
  return *middle;
}

}  // namespace

template <class Scalar>
std::string far_vectors(Ranks* ranks, PointsView<Scalar> own, std::int64_t first,
                        std::span<const Index> codes, const std::vector<double>& sites) {
  const auto width = static_cast<std::size_t>(own.dimension);
  const std::size_t n = sites.size() / width;
  // Of each codeword; then how far the farthest vector is, and its number.
  std::vector<double> found(n + 2, 0.0);
  for (Index p = 0; p < own.count; ++p) {
    const auto code = static_cast<std::size_t>(codes[static_cast<std::size_t>(p)]);
    const double squared = squared_distance(own[p], sites.data() + code * width, own.dimension);
    found[code] += squared;
    if (squared > found[n]) {
      found[n] = squared;
      found[n + 1] = static_cast<double>(first + p);
    }
  }
  const std::vector<double> all = joined(ranks, std::move(found));
  std::vector<double> energies(n, 0.0);
  double farthest = 0;
  std::int64_t number = 0;
  for (std::size_t rank = 0; rank < all.size(); rank += n + 2) {
    for (std::size_t k = 0; k < n; ++k) energies[k] += all[rank + k];
    if (all[rank + n] > farthest) {
      farthest = all[rank + n];
      number = static_cast<std::int64_t>(all[rank + n + 1]);
    }
  }
  const double energy = std::accumulate(energies.begin(), energies.end(), 0.0);
  const double usual = median(std::move(energies));
  if (!(usual > 0) || usual >= kHardlySeen * energy) return {};
  return concat("vectors: vectors[", number,
                "], and perhaps others, lie so far away that the cost of ",
                "most cells is lost beside theirs, and codewords are not in place: leave them out");
}

template std::string far_vectors(Ranks*, PointsView<float>, std::int64_t, std::span<const Index>,
                                 const std::vector<double>&);
template std::string far_vectors(Ranks*, PointsView<double>, std::int64_t, std::span<const Index>,
                                 const std::vector<double>&);

}  // namespace ccvt
