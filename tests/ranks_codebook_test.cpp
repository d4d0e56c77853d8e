// Codebooks of several ranks, which are threads here; tests/mpi has the same with processes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/mapped_points.h"
#include "codebook/trainer.h"
#include "random.h"
#include "support/files.h"
#include "support/message.h"
#include "support/thread_ranks.h"

using ccvt::Codebook;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Coding;
using ccvt::Index;
using ccvt::Points;
using ccvt::PointsView;
using ccvt::Training;
using ccvt::test::messages_of;

namespace {

/// Clouds, of which some vectors are in one place.
template <class Scalar>
Points<Scalar> clouds(int dimension, Index count, std::uint64_t seed) {
  ccvt::Random random(seed, 1);
  Points<Scalar> points(dimension, count);
  for (Index p = 0; p < count; ++p) {
    const auto cloud = static_cast<double>(random.below(9));
    for (int d = 0; d < dimension; ++d) {
      points(d, p) = static_cast<Scalar>(3 * std::sin(cloud * (d + 1)) + random.uniform());
    }
    if (p % 50 == 7) points.col(p) = points.col(p / 2);
  }
  return points;
}

/// Of so many vectors, where those of a rank begin: the third has none.
Index begin_of(int rank, int count, Index vectors) {
  if (rank == count) return vectors;
  if (count > 2 && rank == 3) rank = 2;
  return static_cast<Index>(std::int64_t{vectors} * rank * rank / (count * count));
}

template <class Scalar>
PointsView<Scalar> own_of(const ccvt::Ranks& ranks, const Points<Scalar>& vectors) {
  const auto all = static_cast<Index>(vectors.cols());
  const Index begin = begin_of(ranks.rank(), ranks.count(), all);
  const Index end = begin_of(ranks.rank() + 1, ranks.count(), all);
  return {vectors.data() + begin * vectors.rows(), static_cast<int>(vectors.rows()), end - begin,
          vectors.rows()};
}

/// What each rank finds for its own vectors, by vector, and whether all else is as expected.
class Collected {
 public:
  explicit Collected(Index vectors) : codes(static_cast<std::size_t>(vectors), -1) {}
  void add(const ccvt::Ranks& ranks, const std::vector<Index>& own, bool as_expected) {
    const std::lock_guard lock(mutex_);
    const Index begin = begin_of(ranks.rank(), ranks.count(), static_cast<Index>(codes.size()));
    std::copy(own.begin(), own.end(), codes.begin() + begin);
    same = same && as_expected;
  }
  std::vector<Index> codes;
  bool same = true;

 private:
  std::mutex mutex_;
};

bool same_summary(const ccvt::CodebookSummary& a, const ccvt::CodebookSummary& b) {
  return a.termination == b.termination && a.iterations == b.iterations && a.energy == b.energy &&
         a.distortion == b.distortion && a.gap == b.gap && a.vectors == b.vectors &&
         a.codewords == b.codewords && a.usage.smallest == b.usage.smallest &&
         a.usage.largest == b.usage.largest && a.usage.imbalance == b.usage.imbalance &&
         a.usage.entropy == b.usage.entropy && a.warnings == b.warnings;
}

template <class Scalar>
void check_training(const Points<Scalar>& vectors, Index codewords, const CodebookOptions& options,
                    const std::optional<Points<double>>& given = {}) {
  const Training alone = given ? train_codebook_from(vectors, *given, options)
                               : train_codebook(vectors, codewords, options);
  // Vectors on all ranks, as so few are; then each on one; and the same but for samples of them.
  struct Case {
    int ranks;
    std::size_t few_bytes;
  };
  const std::size_t bytes = sizeof(Scalar) * static_cast<std::size_t>(vectors.size());
  const std::initializer_list<Case> cases = {
      {1, ccvt::kFewBytes}, {2, ccvt::kFewBytes}, {5, ccvt::kFewBytes}, {3, 0}, {5, 0},
      {3, bytes - 1}};
  const ccvt::Columns<double> start(given ? *given : Points<double>());
  for (const Case& tried : cases) {
    CAPTURE(tried.ranks);
    CAPTURE(tried.few_bytes);
    Collected all(static_cast<Index>(vectors.cols()));
    ThreadRanks(tried.ranks).run([&](ccvt::Ranks& ranks) {
      ccvt::Problem<Scalar> problem(ranks, own_of(ranks, vectors), codewords);
      ccvt::Trainer<Scalar> trainer(std::move(problem), options, tried.few_bytes);
      const Training result = trainer.run(given ? &start : nullptr);
      all.add(ranks, result.codes,
              result.codebook.codewords() == alone.codebook.codewords() &&
                  result.codebook.weights() == alone.codebook.weights() &&
                  same_summary(result.summary, alone.summary));
    });
    CHECK(all.codes == alone.codes);
    CHECK(all.same);
  }
}

}  // namespace

TEST_SUITE_BEGIN("ranks");

TEST_CASE("ranks: codes are those of one process") {
  for (const int dimension : {2, 3, 16}) {
    for (const Index codewords : {40, 700}) {
      CAPTURE(dimension);
      CAPTURE(codewords);
      const Points<float> vectors = clouds<float>(dimension, 4001, 5);
      // Some codewords in one place: vectors there go round robin by their numbers.
      Points<double> words = vectors.leftCols(codewords).cast<double>();
      words.rightCols(codewords / 4).colwise() = Eigen::VectorXd(words.col(0));
      ccvt::Random random(4, 4);
      ccvt::Coordinates weights = ccvt::Coordinates::constant(codewords, 0);
      for (Index s = 0; s < codewords / 2; ++s) weights.data()[s] = -0.1 * random.uniform();
      const Codebook codebook(words, weights);
      for (const Coding coding : {Coding::nearest, Coding::weighted}) {
        const std::vector<Index> expected = codebook.encode(vectors, coding, 1);
        const double distortion = codebook.distortion(vectors, expected);
        const ccvt::CodeUsage usage = ccvt::code_usage(expected, codewords);
        for (const int count : {1, 2, 5}) {
          CAPTURE(count);
          Collected all(4001);
          ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
            const PointsView<float> own = own_of(ranks, vectors);
            const std::vector<Index> codes = codebook.encode(ranks, own, coding, 1);
            const ccvt::CodeUsage together = ccvt::code_usage(ranks, codes, codewords);
            all.add(ranks, codes,
                    codebook.distortion(ranks, own, codes) == distortion &&
                        together.smallest == usage.smallest && together.largest == usage.largest &&
                        together.imbalance == usage.imbalance && together.entropy == usage.entropy);
          });
          CHECK(all.codes == expected);
          CHECK(all.same);
        }
      }
    }
  }
}

TEST_CASE("ranks: what is wrong with vectors to encode is thrown on all") {
  const Points<double> vectors = clouds<double>(2, 90, 1);
  const Codebook codebook(Points<double>(vectors.leftCols(3)));
  Points<double> bad = vectors;
  bad(1, 70) = 1e200;
  const auto check = [](const std::set<std::string>& messages, const std::string& expected) {
    REQUIRE(messages.size() == 1);
    CHECK(messages.begin()->find(expected) != std::string::npos);
  };
  check(
      messages_of(3, [&](ccvt::Ranks& ranks) { (void)codebook.encode(ranks, own_of(ranks, bad)); }),
      "vectors: coordinate 1 of vectors[70] is 1e+200");
  check(messages_of(2,
                    [&](ccvt::Ranks& ranks) {
                      (void)codebook.encode(ranks, own_of(ranks, vectors), Coding::nearest,
                                            ranks.rank() - 1);
                    }),
        "threads: is -1");
  check(messages_of(2,
                    [&](ccvt::Ranks& ranks) {
                      const std::vector<Index> codes(ranks.rank() == 0 ? 22 : 9, 0);
                      return codebook.distortion(ranks, own_of(ranks, vectors), codes);
                    }),
        "codes: there are 9 for 68 vectors: one each is needed");
  check(messages_of(2,
                    [&](ccvt::Ranks& ranks) {
                      ccvt::code_usage(ranks, std::vector<Index>{0, 5 * ranks.rank()}, 3);
                    }),
        "codes[1] is 5: it must be in 0..2");
  check(messages_of(2, [&](ccvt::Ranks& ranks) { ccvt::code_usage(ranks, {}, 3); }),
        "codes: there are none");
  const Codebook other(Points<double>(vectors.leftCols(4)));
  check(messages_of(2,
                    [&](ccvt::Ranks& ranks) {
                      const Codebook& one = ranks.rank() == 0 ? codebook : other;
                      (void)one.encode(ranks, own_of(ranks, vectors));
                    }),
        "codewords: rank 1 and rank 0 must be given the same");
  const Codebook weighted(codebook.codewords(), Eigen::Vector3d(0, 1, 2));
  const auto encode_unlike = [&](Coding coding) {
    return messages_of(2, [&](ccvt::Ranks& ranks) {
      const Codebook& one = ranks.rank() == 0 ? codebook : weighted;
      (void)one.encode(ranks, own_of(ranks, vectors), coding);
    });
  };
  check(encode_unlike(Coding::weighted), "weights: rank 1 and rank 0 must be given the same");
  CHECK(encode_unlike(Coding::nearest) == std::set<std::string>{"nothing thrown"});
  // All in one place but for what has no digits, on different ranks.
  Points<double> near = Points<double>::Zero(1, 90);
  near(0, 80) = 1e-160;
  const Codebook zero(Points<double>(near.leftCols(1)));
  check(messages_of(3, [&](ccvt::Ranks& ranks) { (void)zero.encode(ranks, own_of(ranks, near)); }),
        "vectors: they and the codewords differ by at most 1e-160");
  near(0, 80) = 1;
  ThreadRanks(3).run([&](ccvt::Ranks& ranks) {
    const std::vector<Index> codes = zero.encode(ranks, own_of(ranks, near));
    CHECK(std::count(codes.begin(), codes.end(), 0) == std::ssize(codes));
  });
}

TEST_CASE("ranks: k-means is that of one process") {
  const CodebookOptions lloyd{.method = CodebookMethod::lloyd, .threads = 1, .seed = 3};
  check_training(clouds<float>(2, 9001, 2), 12, lloyd);
  check_training(clouds<double>(3, 20'011, 2), 300, lloyd);
  check_training(clouds<float>(16, 6000, 2), 200, lloyd);
  CodebookOptions drawn = lloyd;
  drawn.seeding = ccvt::Seeding::random;
  drawn.max_iterations = 7;
  check_training(clouds<double>(5, 9001, 4), 40, drawn);
  drawn.tolerance = 1e-2;
  drawn.threads = 2;
  check_training(clouds<float>(24, 5000, 4), 600, drawn);
  const Points<float> vectors = clouds<float>(4, 3000, 6);
  check_training(vectors, 50, lloyd, Points<double>(vectors.leftCols(50).cast<double>()));
  // All but a few far from the origin.
  check_training(Points<float>(clouds<float>(2, 3000, 6).array() + 1e6F), 600, lloyd);
}

TEST_CASE("ranks: balanced codebooks are those of one process") {
  const CodebookOptions exact{.effort = 0, .threads = 1, .seed = 3};
  check_training(clouds<float>(2, 1201, 2), 40, exact);
  check_training(clouds<float>(16, 1500, 2), 300, exact);
  // Levels on samples, and what is near enough.
  CodebookOptions near = exact;
  near.gap = 1e-3;
  near.tolerance = 1e-3;
  near.threads = 2;
  check_training(clouds<double>(3, 17'011, 2), 20, near);
  check_training(clouds<float>(8, 9011, 2), 300, near);
  // Bred seeds, at first on a sample.
  CodebookOptions bred = near;
  bred.effort = 4;
  check_training(clouds<float>(2, 17'005, 6), 6, bred);
  CodebookOptions sampled = near;
  sampled.train_sample = 900;
  check_training(clouds<float>(4, 3000, 7), 30, sampled);
  CodebookOptions given = exact;
  given.capacities = std::vector<Index>(30, 10);
  given.capacities[3] = 1201 - 290;
  check_training(clouds<float>(2, 1201, 2), 30, given);
  const Points<float> vectors = clouds<float>(4, 1000, 6);
  check_training(vectors, 50, exact, Points<double>(vectors.leftCols(50).cast<double>()));
  CodebookOptions none = exact;
  none.max_iterations = 0;
  check_training(vectors, 50, none);
  none.max_iterations = 3;
  check_training(vectors, 50, none);
}

TEST_CASE("ranks: owners of a sample are not those of as many vectors") {
  // The first level has as many vectors as each of the ranks; and among noise, whose owners hardly
  // matter, wrong ones that keep the capacities are near enough.
  constexpr Index kOwn = 8192;
  Points<float> vectors(24, 3 * kOwn);
  ccvt::Random random(1, 1);
  for (float& x : vectors.reshaped()) x = static_cast<float>(random.uniform());
  const CodebookOptions near{.effort = 0, .threads = 1, .gap = 0.5};
  const Training alone = train_codebook(vectors, 64, near);
  const std::size_t bytes = sizeof(float) * static_cast<std::size_t>(vectors.size());
  ThreadRanks(3).run([&](ccvt::Ranks& ranks) {
    const PointsView<float> own{vectors.col(ranks.rank() * kOwn).data(), 24, kOwn, 24};
    ccvt::Trainer<float> trainer(ccvt::Problem<float>(ranks, own, 64), near, bytes - 1);
    CHECK(same_summary(trainer.run(nullptr).summary, alone.summary));
  });
}

TEST_CASE("ranks: codebooks trained by pairs are those of one process") {
  CodebookOptions pairs{.method = CodebookMethod::pairwise, .threads = 1, .seed = 3};
  check_training(clouds<float>(2, 3000, 8), 40, pairs);
  check_training(clouds<double>(12, 1201, 2), 30, pairs);
  pairs.max_iterations = 2;
  pairs.capacities = std::vector<Index>(30, 10);
  pairs.capacities[3] = 1201 - 290;
  check_training(clouds<float>(2, 1201, 2), 30, pairs);
  pairs.capacities.clear();
  const Points<float> vectors = clouds<float>(4, 1000, 6);
  check_training(vectors, 50, pairs, Points<double>(vectors.leftCols(50).cast<double>()));
}

TEST_CASE("ranks: what training cannot do is thrown on all") {
  const Points<float> vectors = clouds<float>(2, 300, 1);
  const auto message = [&](const CodebookOptions& options, Index codewords) {
    const std::set<std::string> messages = messages_of(3, [&](ccvt::Ranks& ranks) {
      train_codebook(ranks, own_of(ranks, vectors), codewords, options);
    });
    REQUIRE(messages.size() == 1);
    return *messages.begin();
  };
  CHECK(message({.capacities = std::vector<Index>(5, 50)}, 5).find("250") != std::string::npos);
  CHECK(message({.method = CodebookMethod::lloyd}, 301).find("301") != std::string::npos);
  CHECK(message({.method = CodebookMethod::lloyd, .gap = -1}, 5).find("gap is -1") !=
        std::string::npos);
}

TEST_CASE("ranks: vectors of all are counted in 31 bits") {
  CHECK(ccvt::checked_vector_count(2'147'483'647) == 2'147'483'647);
  CHECK(ccvt::test::message_of([] { ccvt::checked_vector_count(4'000'000'000); }) ==
        "vectors: there are 4000000000 of them on all ranks, but at most 2147483647 are supported");
}

TEST_CASE("ranks: what they are given for training must be the same, or all fail") {
  const Points<float> vectors = clouds<float>(2, 300, 1);
  const auto message = [&](const auto& change) {
    const std::set<std::string> messages = messages_of(2, [&](ccvt::Ranks& ranks) {
      CodebookOptions options{.threads = 1};
      Eigen::MatrixXd start = vectors.leftCols(5).cast<double>();
      if (ranks.rank() == 1) change(options, start);
      train_codebook_from(ranks, own_of(ranks, vectors), start, options);
    });
    REQUIRE(messages.size() == 1);
    return *messages.begin();
  };
  CHECK(message([](CodebookOptions& options, auto&) { options.seed = 3; }) ==
        "CodebookOptions::seed is 3 on rank 1, but 0 on rank 0: all ranks must be given the same");
  CHECK(message([](CodebookOptions& options, auto&) { options.method = CodebookMethod::lloyd; }) ==
        "CodebookOptions::method is lloyd on rank 1, but exact on rank 0: all ranks must be given "
        "the same");
  CHECK(message([](CodebookOptions& options, auto&) { options.effort = 0; }) ==
        "CodebookOptions::effort is 0 on rank 1, but the usual on rank 0: all ranks must be given "
        "the same");
  CHECK(message([](auto&, Eigen::MatrixXd& start) { start(1, 2) += 1; }) ==
        "codewords: rank 1 and rank 0 must be given the same");
  CHECK(message([](CodebookOptions& options, auto&) {
          options.capacities = {60, 60, 60, 60, 60};
        }) == "CodebookOptions::capacities: rank 1 and rank 0 must be given the same");
}

TEST_CASE("ranks: one that ends training ends it for all") {
  const Points<float> vectors = clouds<float>(2, 3000, 1);
  for (const auto& [method, asked] :
       {std::pair(CodebookMethod::lloyd, false), std::pair(CodebookMethod::lloyd, true),
        std::pair(CodebookMethod::exact, false), std::pair(CodebookMethod::exact, true)}) {
    ThreadRanks(3).run([&, method = method, asked = asked](ccvt::Ranks& ranks) {
      int heard = 0;
      CodebookOptions options{.method = method, .effort = 0, .threads = 1};
      options.on_iteration = [&](const ccvt::IterationRecord&) {
        ++heard;
        return asked || ranks.rank() != 1 || heard < 3;
      };
      options.cancelled = [&] { return asked && ranks.rank() == 2 && heard == 3; };
      const Training training = train_codebook(ranks, own_of(ranks, vectors), 40, options);
      CHECK(training.summary.termination == ccvt::Termination::cancelled);
      CHECK(training.summary.iterations == 3);
      if (method == CodebookMethod::exact) CHECK(training.summary.usage.largest == 75);
    });
  }
}

TEST_CASE("ranks: a part of a file of vectors") {
  const ccvt::test::TemporaryDirectory directory;
  const auto path = directory.path() / "v.fvecs";
  const auto bytes_path = directory.path() / "v.bvecs";
  const Index count = 57;
  Points<float> all(3, count);
  std::string floats;
  std::string bytes;
  const auto append = [](std::string& to, const auto& value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (Index p = 0; p < count; ++p) {
    append(floats, std::int32_t{3});
    append(bytes, std::int32_t{3});
    for (int d = 0; d < 3; ++d) {
      all(d, p) = static_cast<float>((p * 7 + d * 31) % 256);
      append(floats, all(d, p));
      append(bytes, static_cast<std::uint8_t>(all(d, p)));
    }
  }
  ccvt::test::put(path, floats);
  ccvt::test::put(bytes_path, bytes);
  for (const auto& file : {path, bytes_path}) {
    for (const auto& rows : {std::pair<Index, Index>{0, 57}, {0, 0}, {5, 6}, {56, 57}, {57, 57}}) {
      const Index begin = rows.first;
      const Index end = rows.second;
      const ccvt::ReadOptions part{.first_row = static_cast<std::uint64_t>(begin),
                                   .end_row = static_cast<std::uint64_t>(end)};
      const Points<float> expected = all.middleCols(begin, end - begin);
      CHECK((ccvt::read_points<float>(file, part) == expected));
      CHECK((ccvt::read_points<double>(file, part) == expected.cast<double>()));
      CHECK(ccvt::inspect_points(file, part).count == static_cast<std::uint64_t>(end - begin));
      const ccvt::MappedPoints<float> mapped(file, part);
      REQUIRE(mapped.view().count == end - begin);
      for (Index p = 0; p < end - begin; ++p) {
        CHECK(std::equal(expected.col(p).data(), expected.col(p).data() + 3, mapped.view()[p]));
      }
    }
  }
  // What is wrong is told by its place in the file, and only to whom it concerns.
  const std::size_t record = 4 * sizeof(float);
  std::string broken = floats;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  broken.replace(50 * record + 8, 4, reinterpret_cast<const char*>(&nan), 4);
  broken[40 * record] = 2;
  ccvt::test::put(path, broken);
  const auto message = [&](std::uint64_t begin, std::uint64_t end) {
    const ccvt::ReadOptions part{.first_row = begin, .end_row = end};
    std::string read = ccvt::test::message_of([&] { ccvt::read_points<float>(path, part); });
    CHECK(ccvt::test::message_of([&] { const ccvt::MappedPoints<float> mapped(path, part); }) ==
          read);
    return read;
  };
  CHECK(message(0, 40) == "nothing thrown");
  CHECK(message(41, 50) == "nothing thrown");
  CHECK(message(30, 41).find("vector 40 has 2 dimensions, but vector 0 has 3") !=
        std::string::npos);
  CHECK(message(45, 57).find("row 50, column 1: nan is not finite") != std::string::npos);
}

TEST_SUITE_END();
