#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/ranks.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// How a codebook is trained.
enum class CodebookMethod {
  /// Balanced k-means: every codeword gets exactly as many vectors as its capacity; the assignment
  /// is the cheapest one there is for its codewords, and proved to be so.
  exact,
  /// tessellate(): exact capacities, but only exchanges between two cells are looked at. Blue
  /// noise in few dimensions; 5 % more distortion than `exact` on uniform 2D data, 1 % on clouds in
  /// 64-D, in half of its time or so.
  pairwise,
  /// Plain Lloyd k-means: every vector goes to its nearest codeword; capacities do not matter.
  lloyd,
};

/// Where training starts.
enum class Seeding {
  /// Greedy k-means++ [Arthur, Vassilvitskii 2007] on a sample, then merging and splitting of cells
  /// where that lowers the distortion of the sample. `exact` and `pairwise` then split cells that
  /// hold several capacities and drop sparse ones, so that a cloud has as many seeds as it fills.
  kmeans_plus_plus,
  /// Distinct vectors drawn at random.
  random,
};

CCVT_EXPORT const char* to_string(CodebookMethod method);

/// How, from where and for how long a codebook is trained.
struct CCVT_EXPORT CodebookOptions {
  CodebookMethod method = CodebookMethod::exact;
  Seeding seeding = Seeding::kmeans_plus_plus;
  /// Seedings tried on a sample of the vectors; the best one is used. 0: as many as pay, which is
  /// 4, or 1 for more than 128 codewords, where chance hardly tells them apart, unless codebooks
  /// are bred.
  int restarts = 0;
  /// Codebooks bred from the seedings on a sample, toward the best one that keeps capacities,
  /// whatever the seed [a genetic search: Gribel, Vidal 2019]. At least 0; 0 for `lloyd`, and where
  /// codewords are given. More take longer in proportion, and seldom end worse; the samples alone
  /// take O(n^2 D), with a factor of thousands. `on_iteration` does not hear of it. None given: for
  /// `exact` and `pairwise`, where 2 to 128 codewords in up to 128 dimensions are seeded by
  /// k-means++ more than once, 4096 over their number, 64 at most; 0 else.
  std::optional<int> effort = {};
  /// Stops after this many iterations, those included on samples and, before the first exact
  /// assignment, of exchanges between pairs. At least 0.
  int max_iterations = 10'000;
  /// Stops when an iteration lowers the distortion by less than this share of it. In [0, 1); 0: run
  /// until no vector changes its codeword.
  double tolerance = 0;
  /// Seconds after which training ends as if it were cancelled, see `cancelled`; breeding ends
  /// after a third of them. Not negative; 0: no limit. What a training that ends so has reached is
  /// not the same each time. Of ranks, whose limits may differ, the first that is over ends it,
  /// after an iteration.
  double time_limit = 0;
  /// Threads to use; 0: one per processor. Any number gives identical bits.
  int threads = 0;
  std::uint64_t seed = 0;
  /// Vectors of each codeword, summing to their number. Empty: equal, and where these cannot all
  /// be, the method decides which have one more. A codeword has at most c vectors where its
  /// capacity is c or less. Empty for `lloyd`.
  std::vector<Index> capacities = {};
  /// `exact` ends when an assignment is proved to cost, for the centroids of its cells, at most
  /// this share more than the cheapest one that keeps the capacities. In [0, 1), and 0 for other
  /// methods; 0: no more than that but for rounding. Capacities are exact whatever it is, and
  /// CodebookSummary::gap tells how near the codes came.
  double gap = 0;
  /// `exact` trains on so many vectors, drawn at random. All of them are then assigned, move the
  /// codewords to the centroids of their cells, once, and are assigned again: codes, capacities and
  /// CodebookSummary::gap are of all vectors, codewords near the centroids of their cells. For
  /// millions of them, of which a codeword needs some hundred to find its place. At least the
  /// number of codewords; 0, or as many as there are or more: on all vectors.
  Index train_sample = 0;
  /// Called after each iteration, from the thread that trains; false cancels.
  std::function<bool(const IterationRecord&)> on_iteration = {};
  /// Asked several times a second, from the thread that trains; true ends training with the
  /// codewords there are, during seeding the best seeds so far. `exact` still assigns the vectors
  /// if that takes no longer than a third of a second. Else, where all vectors had an exact
  /// assignment before, codes and weights are those of the last one, and the gap is found if that
  /// takes no longer than two seconds. Else vectors go to near codewords that have room, weights
  /// are 0, and the gap is 1.
  std::function<bool()> cancelled = {};

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// How evenly codes are used.
struct CodeUsage {
  std::int64_t smallest = 0;
  std::int64_t largest = 0;
  /// n sum of c^2 / m^2 over the n codes, each used c times: 1 when all are used alike, n when all
  /// vectors have one code. What a search of one list costs, relative to equal lists.
  double imbalance = 0;
  /// Bits a code: - sum of (c / m) log2(c / m). At most log2 n.
  double entropy = 0;
};

/// O(m + n). Throws InvalidInput when a code is not in 0..codewords-1, or there is none.
CCVT_EXPORT CodeUsage code_usage(std::span<const Index> codes, Index codewords);
/// The same of the codes of all ranks, of which a rank gives its own, perhaps none. 4 n bytes go
/// from each rank to all.
CCVT_EXPORT CodeUsage code_usage(Ranks& ranks, std::span<const Index> own, Index codewords);

/// What happened in a training.
struct CCVT_EXPORT CodebookSummary {
  CodebookMethod method = CodebookMethod::exact;
  /// `stable`: another iteration would change nothing, or save no more than the gap allowed.
  Termination termination = Termination::running;
  int dimension = 0;
  Index vectors = 0;
  Index codewords = 0;
  std::uint64_t seed = 0;
  int threads_used = 0;
  int iterations = 0;
  /// Sum of squared distances of the vectors to their codewords; distortion: over their number.
  double energy = 0;
  double distortion = 0;
  /// Energy less the dual objective under the codebook's weights, over the energy: no assignment
  /// that keeps the capacities has an energy below (1 - gap) times that. Exact only, else 0; 1 at
  /// most, which tells nothing.
  double gap = 0;
  CodeUsage usage;
  double seconds_seeding = 0;
  double seconds_total = 0;
  std::vector<std::string> warnings;  ///< see Summary::warnings

  [[nodiscard]] std::string brief() const;
};

/// How vectors are given their codes.
enum class Coding {
  /// The nearest codeword.
  nearest,
  /// The least |p - s|^2 - w, w the codeword's weight: the power diagram. Vectors distributed like
  /// those of an exact training then use the codes as evenly as capacities say, in expectation.
  weighted,
};

/// Codewords with weights.
class CCVT_EXPORT Codebook {
 public:
  /// `codewords`: #dimensions by n, finite, at least one. `weights`: n finite numbers; none: zeros.
  explicit Codebook(Columns<double> codewords, Coordinates weights = {});
  template <class Derived>
  explicit Codebook(const Eigen::DenseBase<Derived>& codewords, Coordinates weights = {})
      : Codebook(Columns<double>(codewords), std::move(weights)) {}

  [[nodiscard]] int dimension() const { return static_cast<int>(codewords_.rows()); }
  [[nodiscard]] Index size() const { return static_cast<Index>(codewords_.cols()); }
  [[nodiscard]] Eigen::Map<const Eigen::MatrixXd> codewords() const& { return codewords_.eigen(); }
  [[nodiscard]] Eigen::MatrixXd codewords() const&& { return codewords_.eigen(); }
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> weights() const& { return weights_.eigen(); }
  [[nodiscard]] Eigen::VectorXd weights() const&& { return weights_; }

  /// The code of each vector (#dimensions by #vectors, finite), in 0..n-1; of several cheapest any,
  /// but always the same one. By a k-d tree one dimension up in few dimensions [site (s,
  /// sqrt(W - w)), query (p, 0)], by blocked products else; exact. O(#vectors n #dimensions) at
  /// worst. Throws InvalidInput for vectors of another dimension, or not finite; Cancelled
  /// (types.h) when `cancelled`, asked several times a second from the thread that called, says
  /// so.
  template <class Derived>
  [[nodiscard]] std::vector<Index> encode(const Eigen::DenseBase<Derived>& vectors,
                                          Coding coding = Coding::nearest, int threads = 0,
                                          const std::function<bool()>& cancelled = {}) const {
    return encode(view_points(vectors), coding, threads, cancelled);
  }
  template <class Scalar>
  [[nodiscard]] std::vector<Index> encode(const Columns<Scalar>& vectors,
                                          Coding coding = Coding::nearest, int threads = 0,
                                          const std::function<bool()>& cancelled = {}) const {
    return encode(view_points(vectors), coding, threads, cancelled);
  }
  template <class Scalar>
  [[nodiscard]] std::vector<Index> encode(PointsView<Scalar> vectors, Coding coding, int threads,
                                          const std::function<bool()>& cancelled = {}) const;
  /// The same of the vectors of all ranks, which make this call together: `own` are those of this
  /// rank, perhaps none, and follow those of the lower ranks; what it gets are their codes. All
  /// have the same codebook and `coding`, else InvalidInput. There may be more than 2^31 vectors in
  /// all. What is wrong on one rank is thrown on all.
  template <class Scalar>
  [[nodiscard]] std::vector<Index> encode(Ranks& ranks, PointsView<Scalar> own,
                                          Coding coding = Coding::nearest, int threads = 0) const;

  /// #dimensions by #codes: the codewords of the codes. Throws InvalidInput for a code that is not
  /// in 0..n-1.
  [[nodiscard]] Eigen::MatrixXd decode(std::span<const Index> codes) const {
    Eigen::MatrixXd vectors(dimension(), static_cast<Eigen::Index>(codes.size()));
    decode_to(codes, std::span(vectors.data(), static_cast<std::size_t>(vectors.size())));
    return vectors;
  }

  /// The mean squared distance of vectors to the codewords of their codes; the sum is rounded once.
  template <class Derived>
  [[nodiscard]] double distortion(const Eigen::DenseBase<Derived>& vectors,
                                  std::span<const Index> codes) const {
    return distortion(view_points(vectors), codes);
  }
  template <class Scalar>
  [[nodiscard]] double distortion(const Columns<Scalar>& vectors,
                                  std::span<const Index> codes) const {
    return distortion(view_points(vectors), codes);
  }
  template <class Scalar>
  [[nodiscard]] double distortion(PointsView<Scalar> vectors, std::span<const Index> codes) const;
  /// The same of the vectors of all ranks, as encode() has them.
  template <class Scalar>
  [[nodiscard]] double distortion(Ranks& ranks, PointsView<Scalar> own,
                                  std::span<const Index> codes) const;

  /// As files of points: the codewords, one a row, and the weights, one a row, in another file. An
  /// empty path: not. Both appear together, see publication.h. load() takes weights as
  /// read_numbers() does, also of shape (n,).
  void save(const std::filesystem::path& codewords,
            const std::filesystem::path& weights = {}) const;
  static Codebook load(const std::filesystem::path& codewords,
                       const std::filesystem::path& weights = {});

 private:
  [[nodiscard]] Coordinates weights_for(Coding coding) const;
  void decode_to(std::span<const Index> codes, std::span<double> vectors) const;

  Columns<double> codewords_;
  Coordinates weights_;
};

/// What train_codebook() returns.
struct Training {
  /// Weights are zero unless the method is exact.
  Codebook codebook;
  /// Of each vector, in 0..n-1.
  std::vector<Index> codes;
  CodebookSummary summary;
};

/// Trains a codebook of `codewords` words for `vectors` (#dimensions by m, one a column, float or
/// double, finite).
///
///     auto [codebook, codes, summary] = ccvt::train_codebook(vectors, 256, {.seed = 7});
///
/// Deterministic. Vectors of a file need not be loaded: see MappedPoints. Memory beside the
/// vectors: about 100 bytes a vector; for `exact` a sample, of half of them at most; where
/// codebooks are bred 1024 of them a codeword, as floats; and for n <= 5792 codewords of `exact` up
/// to 80 n^2 bytes, in many dimensions: 900 MB for 4096 of 64-D vectors, of `lloyd` 8 n^2. Throws
/// InvalidInput unless 1 <= codewords <= m, and for bad options.
template <class Scalar>
CCVT_EXPORT Training train_codebook(PointsView<Scalar> vectors, Index codewords,
                                    const CodebookOptions& options);
template <class Derived>
Training train_codebook(const Eigen::DenseBase<Derived>& vectors, Index codewords,
                        const CodebookOptions& options = {}) {
  return train_codebook(view_points(vectors), codewords, options);
}
template <class Scalar>
Training train_codebook(const Columns<Scalar>& vectors, Index codewords,
                        const CodebookOptions& options = {}) {
  return train_codebook(view_points(vectors), codewords, options);
}
/// The same from given codewords (#dimensions by n, finite) instead of seeds.
template <class Scalar>
CCVT_EXPORT Training train_codebook_from(PointsView<Scalar> vectors,
                                         const Columns<double>& codewords,
                                         const CodebookOptions& options);
template <class Derived>
Training train_codebook_from(const Eigen::DenseBase<Derived>& vectors,
                             const Columns<double>& codewords,
                             const CodebookOptions& options = {}) {
  return train_codebook_from(view_points(vectors), codewords, options);
}
template <class Scalar>
Training train_codebook_from(const Columns<Scalar>& vectors, const Columns<double>& codewords,
                             const CodebookOptions& options = {}) {
  return train_codebook_from(view_points(vectors), codewords, options);
}

/// Trains a codebook for the vectors of all ranks, which make this call together, with the same
/// arguments but for `own`: the vectors of this rank, perhaps none, which follow those of the lower
/// ranks. Codebook and summary are the same on all, to the bit those of one process with all
/// vectors; codes are those of a rank's own. Fewer than 2^31 vectors in all.
///
///     ccvt::MpiRanks ranks(MPI_COMM_WORLD);
///     auto [codebook, codes_of_own, summary] =
///         ccvt::train_codebook(ranks, ccvt::view_points(own), 256);
///
/// Up to 2^18 vectors of all ranks, of 64 MB at the most, are gathered on all of them. More stay
/// where they are, but samples of them are gathered: those that seeds come from, and those that
/// levels are trained on, up to the same size; for `exact` what pairs exchange before the first
/// assignment, 32 a codeword or 8192 vectors, all of them where there are not twice as many; and
/// 1024 a codeword where codebooks are bred. For `pairwise` all vectors are gathered. on_iteration
/// and cancelled of each rank are asked after an iteration; where one wants to end, all do; `exact`
/// then proves an assignment, however long that takes, and nobody is asked while codebooks are
/// bred.
template <class Scalar>
CCVT_EXPORT Training train_codebook(Ranks& ranks, PointsView<Scalar> own, Index codewords,
                                    const CodebookOptions& options = {});
/// The same from given codewords, which are the same on all ranks, instead of seeds.
template <class Scalar>
CCVT_EXPORT Training train_codebook_from(Ranks& ranks, PointsView<Scalar> own,
                                         const Columns<double>& codewords,
                                         const CodebookOptions& options = {});

}  // namespace ccvt
