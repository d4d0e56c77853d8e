#include "codebook/far_vectors.h"

#include <cstddef>
#include <numeric>
#include <utility>

#include "codebook/trainer.h"
#include "exact/distances.h"
#include "median.h"
#include "number_text.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// No cell comes to its end whose energy is not this much more than what ends training.
constexpr double kHardlySeen = 100 * kTrainingRounding;

}  // namespace

template <class Scalar>
std::string far_vectors(Ranks* ranks, PointsView<Scalar> own, std::int64_t first,
                        std::span<const Index> codes, const std::vector<double>& sites) {
  const auto width = static_cast<std::size_t>(own.dimension);
  const std::size_t n = sites.size() / width;
  std::vector<double> energies(n, 0.0);
  std::vector<double> farthest = {0.0, 0.0};  // how far a vector is, squared, and its number
  for (Index p = 0; p < own.count; ++p) {
    const auto code = static_cast<std::size_t>(codes[static_cast<std::size_t>(p)]);
    const double squared = squared_distance(own[p], sites.data() + code * width, own.dimension);
    energies[code] += squared;
    if (squared > farthest[0]) farthest = {squared, static_cast<double>(first + p)};
  }
  energies = summed(ranks, std::move(energies));
  const double energy = std::accumulate(energies.begin(), energies.end(), 0.0);
  std::erase_if(energies, [](double of_cell) { return !(of_cell > 0); });
  if (energies.empty() || median(energies) >= kHardlySeen * energy) return {};
  farthest = joined(ranks, std::move(farthest));
  std::size_t most = 0;
  for (std::size_t k = 2; k < farthest.size(); k += 2) {
    if (farthest[k] > farthest[most]) most = k;
  }
  const auto number = static_cast<std::int64_t>(farthest[most + 1]);
  return concat("vectors: vectors[", number,
                "], and perhaps others, lie so far away that the cost of ",
                "most cells is lost beside theirs, and codewords are not in place: leave them out");
}

template std::string far_vectors(Ranks*, PointsView<float>, std::int64_t, std::span<const Index>,
                                 const std::vector<double>&);
template std::string far_vectors(Ranks*, PointsView<double>, std::int64_t, std::span<const Index>,
                                 const std::vector<double>&);

}  // namespace ccvt
