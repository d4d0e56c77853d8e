#include "ccvt/codebook.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

#include "ccvt/io.h"
#include "ccvt/publication.h"
#include "cell_sizes.h"
#include "checkpoint/digest.h"
#include "checks.h"
#include "codebook/encode.h"
#include "exact/distances.h"
#include "exact_sum.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/alike.h"
#include "parallel/together.h"
#include "scales.h"
#include "thread_count.h"

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

/// Throws InvalidInput where there are none.
void require_codewords(const Codebook& codebook) {
  if (codebook.size() == 0) throw InvalidInput("codebook: was moved from");
}

void check_codes(std::span<const Index> codes, Index codewords) {
  for (std::size_t k = 0; k < codes.size(); ++k) {
    if (codes[k] >= 0 && codes[k] < codewords) continue;
    throw InvalidInput("codes[" + std::to_string(k) + "] is " + std::to_string(codes[k]) +
                       ": it must be in 0.." + std::to_string(codewords - 1));
  }
}

/// Those of a rank begin with number `first`.
template <class Scalar>
void check_vectors(PointsView<Scalar> vectors, int dimension, std::int64_t first = 0) {
  if (vectors.dimension != dimension) {
    throw InvalidInput("vectors: have " + std::to_string(vectors.dimension) +
                       " dimensions, but the codewords have " + std::to_string(dimension));
  }
  require_data("vectors", vectors);
  require_moderate("vectors", vectors, Arena(1), first);
}

/// Coordinates all within so little that their squares have no digits, on all ranks.
template <class Scalar>
void check_extent(Ranks* ranks, PointsView<Scalar> own,
                  const Eigen::Map<const Points<double>>& codewords) {
  if (total(ranks, own.count) == 0) return;
  constexpr double least = 1e-150;
  std::vector<double> range;  // of each dimension, the lowest and the highest
  bool apart = false;
  for (int d = 0; d < own.dimension && !apart; ++d) {
    double lower = codewords.row(d).minCoeff();
    double upper = codewords.row(d).maxCoeff();
    for (Index p = 0; p < own.count && upper - lower < least; ++p) {
      const double x = own[p][d];
      lower = std::min(lower, x);
      upper = std::max(upper, x);
    }
    range.insert(range.end(), {lower, upper});
    apart = upper - lower >= least;
  }
  if (any(ranks, apart)) return;
  const std::size_t width = range.size();
  range = joined(ranks, std::move(range));
  double widest = 0;
  for (std::size_t d = 0; d < width; d += 2) {
    double lower = range[d];
    double upper = range[d + 1];
    for (std::size_t k = d; k < range.size(); k += width) {
      lower = std::min(lower, range[k]);
      upper = std::max(upper, range[k + 1]);
    }
    widest = std::max(widest, upper - lower);
  }
  if (widest == 0 || widest >= least) return;
  throw InvalidInput("vectors: they and the codewords differ by at most " + text(widest) +
                     ": they must be all equal or differ by " + text(least) +
                     " or more somewhere; multiply both by a power of two");
}

/// Of the codes of all ranks; `own` are in 0..codewords-1.
CodeUsage usage_of(Ranks* ranks, std::span<const Index> own, Index codewords) {
  const auto n = static_cast<std::size_t>(codewords);
  std::vector<std::int64_t> count(n, 0);
  const std::vector<Index> of_ranks = joined(ranks, cell_sizes(own, n));
  for (std::size_t k = 0; k < of_ranks.size(); ++k) count[k % n] += of_ranks[k];
  CodeUsage usage;
  usage.smallest = *std::min_element(count.begin(), count.end());
  usage.largest = *std::max_element(count.begin(), count.end());
  const auto all =
      static_cast<double>(std::accumulate(count.begin(), count.end(), std::int64_t{0}));
  for (const std::int64_t c : count) {
    const double share = static_cast<double>(c) / all;
    usage.imbalance += codewords * share * share;
    if (c > 0) usage.entropy -= share * std::log2(share);
  }
  return usage;
}

void check_codes_of(std::size_t vectors, std::span<const Index> codes, Index codewords) {
  if (codes.size() != vectors) {
    throw InvalidInput("codes: there are " + std::to_string(codes.size()) + " for " +
                       std::to_string(vectors) + " vectors: one each is needed");
  }
  check_codes(codes, codewords);
}

void check_codewords(Index codewords) {
  if (codewords >= 1) return;
  throw InvalidInput("codewords is " + std::to_string(codewords) + ": it must be positive");
}

/// Of a rank's vectors, or all.
template <class Scalar>
ExactSum sum_of_squares(PointsView<Scalar> vectors, std::span<const Index> codes,
                        const Eigen::Map<const Eigen::MatrixXd>& codewords) {
  ExactSum sum;
  for (const PointNumber p : points_below(vectors.count)) {
    sum.add(
        squared_distance(vectors[p.index()], codewords.col(codes[p]).data(), vectors.dimension));
  }
  return sum;
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
  require_enumerator("CodebookOptions::method", method, CodebookMethod::lloyd);
  require_enumerator("CodebookOptions::seeding", seeding, Seeding::random);
  require(restarts >= 0, "restarts", std::to_string(restarts), "it must be 0 or more");
  require(!effort || *effort >= 0, "effort", std::to_string(effort.value_or(0)),
          "it must be 0 or more");
  require(effort.value_or(0) == 0 || method != CodebookMethod::lloyd, "effort",
          std::to_string(effort.value_or(0)),
          "it must be 0 for lloyd, whose cells have no capacities to search with");
  require(max_iterations >= 0, "max_iterations", std::to_string(max_iterations),
          "it must be 0 or more");
  require(tolerance >= 0 && tolerance < 1, "tolerance", text(tolerance), "it must be in [0, 1)");
  require(time_limit >= 0, "time_limit", text(time_limit), "it must be 0 (none) or more seconds");
  require(gap >= 0 && gap < 1, "gap", text(gap), "it must be in [0, 1)");
  require(gap == 0 || method == CodebookMethod::exact, "gap", text(gap),
          "it must be 0 but for exact, which alone proves one");
  require(capacities.empty() || method != CodebookMethod::lloyd, "capacities",
          std::to_string(capacities.size()) + " numbers", "lloyd keeps none");
  require(train_sample >= 0, "train_sample", std::to_string(train_sample), "it must be 0 or more");
  require(train_sample == 0 || method == CodebookMethod::exact, "train_sample",
          std::to_string(train_sample), "it must be 0 but for exact");
  require(threads >= 0 && threads <= 4096, "threads", std::to_string(threads),
          "it must be from 0 (one per processor) to 4096");
}

CodeUsage code_usage(std::span<const Index> codes, Index codewords) {
  check_codewords(codewords);
  if (codes.empty()) throw InvalidInput("codes: there are none");
  check_codes(codes, codewords);
  return usage_of(nullptr, codes, codewords);
}

CodeUsage code_usage(Ranks& ranks, std::span<const Index> own, Index codewords) {
  agree(&ranks, [&] {
    check_codewords(codewords);
    check_codes(own, codewords);
  });
  if (total(&ranks, std::ssize(own)) == 0) throw InvalidInput("codes: there are none");
  return usage_of(&ranks, own, codewords);
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
  require_codewords(*this);
  require_threads(threads);
  require_enumerator("coding", coding, Coding::weighted);
  check_vectors(vectors, dimension());
  check_extent(nullptr, vectors, codewords_.eigen());
  Stop stop(cancelled);
  const Coordinates weights = weights_for(coding);
  return cheapest_sites(vectors,
                        {{codewords_.data(), codewords_.data() + codewords_.size()},
                         {weights.begin(), weights.end()}},
                        Arena(threads, &stop));
} catch (const Stopped&) {
  throw Cancelled();
}

template <class Scalar>
std::vector<Index> Codebook::encode(Ranks& ranks, PointsView<Scalar> own, Coding coding,
                                    int threads) const {
  const RankPart part{&ranks, part_of_all(&ranks, own.count).first};
  agree(&ranks, [&] {
    require_codewords(*this);
    require_threads(threads);
    require_enumerator("coding", coding, Coding::weighted);
    check_vectors(own, dimension(), part.first);
  });
  const Coordinates weights = weights_for(coding);
  const auto digest = [](const double* first, std::ptrdiff_t count) {
    return concat(digest_of(std::span(first, static_cast<std::size_t>(count))));
  };
  require_alike(
      ranks, std::vector<Given>{{"codewords", digest(codewords_.data(), codewords_.size()), false},
                                {"weights", digest(weights.data(), weights.size()), false}});
  check_extent(&ranks, own, codewords_.eigen());
  std::vector<Index> codes;
  agree(&ranks, [&] {
    codes = cheapest_sites(own,
                           {{codewords_.data(), codewords_.data() + codewords_.size()},
                            {weights.begin(), weights.end()}},
                           Arena(threads), part);
  });
  return codes;
}

Coordinates Codebook::weights_for(Coding coding) const {
  return coding == Coding::weighted ? weights_ : Coordinates::constant(weights_.size(), 0);
}

void Codebook::decode_to(std::span<const Index> codes, std::span<double> vectors) const {
  require_codewords(*this);
  check_codes(codes, size());
  double* to = vectors.data();
  for (const Index code : codes) to = std::copy_n(codewords_.col(code).data(), dimension(), to);
}

template <class Scalar>
double Codebook::distortion(PointsView<Scalar> vectors, std::span<const Index> codes) const {
  require_codewords(*this);
  check_vectors(vectors, dimension());
  if (std::cmp_not_equal(codes.size(), vectors.count) || codes.empty()) {
    throw InvalidInput("codes: there are " + std::to_string(codes.size()) + " for " +
                       std::to_string(vectors.count) +
                       " vectors: one each is needed, and at least one");
  }
  check_codes(codes, size());
  return sum_of_squares(vectors, codes, codewords_.eigen()).value() / vectors.count;
}

template <class Scalar>
double Codebook::distortion(Ranks& ranks, PointsView<Scalar> own,
                            std::span<const Index> codes) const {
  agree(&ranks, [&] {
    require_codewords(*this);
    check_vectors(own, dimension());
    check_codes_of(static_cast<std::size_t>(own.count), codes, size());
  });
  const std::int64_t all = total(&ranks, own.count);
  if (all == 0) throw InvalidInput("codes: there are none");
  ExactSum sum;
  for (const ExactSum& part : of_all(&ranks, sum_of_squares(own, codes, codewords_.eigen()))) {
    sum.add(part);
  }
  return sum.value() / static_cast<double>(all);
}

namespace {

/// Of paths that the system does not let be followed it is left to the writers to say so.
bool are_one_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(a, error);
  return !error && whole == std::filesystem::weakly_canonical(b, error) && !error;
}

}  // namespace

void Codebook::save(const std::filesystem::path& codewords,
                    const std::filesystem::path& weights) const {
  require_codewords(*this);
  if (!weights.empty() && are_one_file(weights, codewords)) {
    throw InvalidInput("weights: are to go into " + weights.string() +
                       ", as the codewords are; the two files must differ");
  }
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
template CCVT_EXPORT std::vector<Index> Codebook::encode(Ranks&, PointsView<float>, Coding,
                                                         int) const;
template CCVT_EXPORT std::vector<Index> Codebook::encode(Ranks&, PointsView<double>, Coding,
                                                         int) const;
template CCVT_EXPORT double Codebook::distortion(PointsView<float>, std::span<const Index>) const;
template CCVT_EXPORT double Codebook::distortion(PointsView<double>, std::span<const Index>) const;
template CCVT_EXPORT double Codebook::distortion(Ranks&, PointsView<float>,
                                                 std::span<const Index>) const;
template CCVT_EXPORT double Codebook::distortion(Ranks&, PointsView<double>,
                                                 std::span<const Index>) const;

}  // namespace ccvt
