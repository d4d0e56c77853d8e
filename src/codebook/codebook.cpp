#include "ccvt/codebook.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ccvt/io.h"
#include "ccvt/publication.h"
#include "cell_sizes.h"
#include "codebook/encode.h"
#include "geometry/squares.h"
#include "number_text.h"
#include "numbers.h"
#include "scales.h"

namespace ccvt {
namespace {

/// As large as the square of a distance between coordinates as large as they may be, and more: see
/// scales.h.
constexpr double kLargestWeight = 1e300;

void require(bool valid, const char* field, const std::string& value, const char* rule) {
  if (!valid) {
    throw InvalidInput("CodebookOptions::" + std::string(field) + " is " + value + ": " + rule);
  }
}

void check_codes(std::span<const Index> codes, Index codewords) {
  for (std::size_t k = 0; k < codes.size(); ++k) {
    if (codes[k] >= 0 && codes[k] < codewords) continue;
    throw InvalidInput("codes[" + std::to_string(k) + "] is " + std::to_string(codes[k]) +
                       ": it must be in 0.." + std::to_string(codewords - 1));
  }
}

template <class Scalar>
void check_vectors(PointsView<Scalar> vectors, int dimension) {
  if (vectors.dimension != dimension) {
    throw InvalidInput("vectors: have " + std::to_string(vectors.dimension) +
                       " dimensions, but the codewords have " + std::to_string(dimension));
  }
  require_moderate("vectors", vectors);
}

/// Coordinates all within so little that their squares have no digits.
template <class Scalar>
void check_extent(PointsView<Scalar> vectors, const Eigen::Map<const Points<double>>& codewords) {
  if (vectors.count == 0) return;
  constexpr double least = 1e-150;
  double widest = 0;
  for (int d = 0; d < vectors.dimension; ++d) {
    double lower = codewords.row(d).minCoeff();
    double upper = codewords.row(d).maxCoeff();
    for (Index p = 0; p < vectors.count && upper - lower < least; ++p) {
      const double x = vectors[p][d];
      lower = std::min(lower, x);
      upper = std::max(upper, x);
    }
    widest = std::max(widest, upper - lower);
    if (widest >= least) return;
  }
  if (widest == 0) return;
  throw InvalidInput("vectors: they and the codewords differ by at most " + text(widest) +
                     ": they must be all equal or differ by " + text(least) +
                     " or more somewhere; multiply both by a power of two");
}

}  // namespace

const char* to_string(CodebookMethod method) {
  switch (method) {
    case CodebookMethod::exact:
      return "exact";
    case CodebookMethod::pairwise:
      return "pairwise";
    case CodebookMethod::lloyd:
      return "lloyd";
  }
  return "unknown";
}

void CodebookOptions::validate() const {
  require(restarts >= 0, "restarts", std::to_string(restarts), "it must be 0 or more");
  require(!effort || *effort >= 0, "effort", std::to_string(effort.value_or(0)),
          "it must be 0 or more");
  require(effort.value_or(0) == 0 || method != CodebookMethod::lloyd, "effort",
          std::to_string(effort.value_or(0)),
          "it must be 0 for lloyd, whose cells have no capacities to search with");
  require(max_iterations >= 0, "max_iterations", std::to_string(max_iterations),
          "it must be 0 or more");
  require(tolerance >= 0 && tolerance < 1, "tolerance", text(tolerance), "it must be in [0, 1)");
  require(gap >= 0 && gap < 1, "gap", text(gap), "it must be in [0, 1)");
  require(threads >= 0 && threads <= 4096, "threads", std::to_string(threads),
          "it must be from 0 (one per processor) to 4096");
}

CodeUsage code_usage(std::span<const Index> codes, Index codewords) {
  if (codewords < 1) {
    throw InvalidInput("codewords is " + std::to_string(codewords) + ": it must be positive");
  }
  if (codes.empty()) throw InvalidInput("codes: there are none");
  check_codes(codes, codewords);
  const std::vector<Index> count = cell_sizes(codes, static_cast<std::size_t>(codewords));
  CodeUsage usage;
  usage.smallest = *std::min_element(count.begin(), count.end());
  usage.largest = *std::max_element(count.begin(), count.end());
  const auto total = static_cast<double>(codes.size());
  for (const Index c : count) {
    const double share = c / total;
    usage.imbalance += codewords * share * share;
    if (c > 0) usage.entropy -= share * std::log2(share);
  }
  return usage;
}

std::string CodebookSummary::brief() const {
  std::string line = std::string(to_string(method)) + ", " + to_string(termination) + " after " +
                     std::to_string(iterations) + " iterations: " + std::to_string(vectors) +
                     " vectors, " + std::to_string(codewords) + " codewords, distortion " +
                     text(distortion, 6) + ", cells of " + std::to_string(usage.smallest) + " to " +
                     std::to_string(usage.largest) + ", imbalance " + text(usage.imbalance, 4) +
                     ", entropy " + text(usage.entropy, 5) + " bits";
  if (method == CodebookMethod::exact) line += ", gap " + text(gap, 2);
  return line + ", " + text(seconds_total, 3) + " s";
}

Codebook::Codebook(Columns<double> codewords, Coordinates weights)
    : codewords_(std::move(codewords)), weights_(std::move(weights)) {
  if (codewords_.rows() < 1 || codewords_.cols() < 1) {
    throw InvalidInput("codewords: there are " + std::to_string(codewords_.cols()) + " of " +
                       std::to_string(codewords_.rows()) +
                       " dimensions: at least one of each is needed");
  }
  require_moderate("codewords", view_points(codewords_));  // which checks how many there are
  if (weights_.size() == 0) weights_ = Coordinates::constant(codewords_.cols(), 0);
  if (weights_.size() != codewords_.cols()) {
    throw InvalidInput("weights: there are " + std::to_string(weights_.size()) + " for " +
                       std::to_string(codewords_.cols()) + " codewords: one each is needed");
  }
  for (std::ptrdiff_t s = 0; s < weights_.size(); ++s) {
    if (std::abs(weights_[s]) <= kLargestWeight) continue;
    throw InvalidInput("weights[" + std::to_string(s) + "] is " + text(weights_[s]) +
                       ": it must be finite and at most " + text(kLargestWeight) + " in magnitude");
  }
}

template <class Scalar>
std::vector<Index> Codebook::encode(PointsView<Scalar> vectors, Coding coding, int threads,
                                    const std::function<bool()>& cancelled) const try {
  if (threads < 0 || threads > 4096) {
    throw InvalidInput("threads is " + std::to_string(threads) +
                       ": it must be from 0 (one per processor) to 4096");
  }
  check_vectors(vectors, dimension());
  check_extent(vectors, codewords_.eigen());
  const Coordinates weights =
      coding == Coding::weighted ? weights_ : Coordinates::constant(weights_.size(), 0);
  Stop stop(cancelled);
  return cheapest_sites(vectors,
                        {{codewords_.data(), codewords_.data() + codewords_.size()},
                         {weights.begin(), weights.end()}},
                        Arena(threads, &stop));
} catch (const Stopped&) {
  throw Cancelled();
}

void Codebook::decode_to(std::span<const Index> codes, std::span<double> vectors) const {
  check_codes(codes, size());
  double* to = vectors.data();
  for (const Index code : codes) to = std::copy_n(codewords_.col(code).data(), dimension(), to);
}

template <class Scalar>
double Codebook::distortion(PointsView<Scalar> vectors, std::span<const Index> codes) const {
  check_vectors(vectors, dimension());
  if (std::cmp_not_equal(codes.size(), vectors.count) || codes.empty()) {
    throw InvalidInput("codes: there are " + std::to_string(codes.size()) + " for " +
                       std::to_string(vectors.count) +
                       " vectors: one each is needed, and at least one");
  }
  check_codes(codes, size());
  double sum = 0;
  for (const PointNumber p : points_below(vectors.count)) {
    sum += squared_difference(vectors[p.index()], codewords_.col(codes[p]).data(), dimension());
  }
  return sum / vectors.count;
}

void Codebook::save(const std::filesystem::path& codewords,
                    const std::filesystem::path& weights) const {
  Publication together;
  if (!weights.empty()) {
    write_points(weights, PointsView<double>{weights_.data(), 1, size(), 1});
  }
  write_points(codewords, codewords_);
  together.publish();
}

Codebook Codebook::load(const std::filesystem::path& codewords,
                        const std::filesystem::path& weights) {
  const Points<double> words = read_points<double>(codewords);
  if (weights.empty()) return Codebook(words);
  const std::vector<double> numbers = read_numbers(weights);
  if (std::cmp_not_equal(numbers.size(), words.cols())) {
    throw InvalidInput(weights.string() + ": has " + std::to_string(numbers.size()) +
                       " numbers, but one for each of the " + std::to_string(words.cols()) +
                       " codewords is needed");
  }
  return Codebook(words, Coordinates(numbers));
}

template CCVT_EXPORT std::vector<Index> Codebook::encode(PointsView<float>, Coding, int,
                                                         const std::function<bool()>&) const;
template CCVT_EXPORT std::vector<Index> Codebook::encode(PointsView<double>, Coding, int,
                                                         const std::function<bool()>&) const;
template CCVT_EXPORT double Codebook::distortion(PointsView<float>, std::span<const Index>) const;
template CCVT_EXPORT double Codebook::distortion(PointsView<double>, std::span<const Index>) const;

}  // namespace ccvt
