// Codebooks that are trained on some vectors and used for all.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/codebook.h"
#include "random.h"
#include "support/message.h"

using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Index;
using ccvt::Points;
using ccvt::Training;
using namespace ccvt::test;

namespace {

constexpr Index kCodewords = 40;

/// Clouds of unequal size.
Points<float> clouds(Index count) {
  ccvt::Random random(5);
  const auto uniform = [&] { return static_cast<float>(random.uniform()); };
  Points<float> centres(3, 12);
  for (float& x : centres.reshaped()) x = 10 * uniform();
  Points<float> points(3, count);
  for (Index p = 0; p < count; ++p) {
    const float u = uniform();
    const auto cloud = static_cast<Index>(12 * u * u);
    for (int d = 0; d < 3; ++d) points(d, p) = centres(d, cloud) + uniform() - uniform();
  }
  return points;
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("A codebook that is trained on a sample has all vectors in cells of equal size") {
  const Points<float> points = clouds(12'001);
  const Training whole = ccvt::train_codebook(points, kCodewords, {.effort = 0, .threads = 1});
  CodebookOptions options{.effort = 0, .threads = 1, .train_sample = 4000};
  std::int64_t most = 0;  // vectors of an iteration
  options.on_iteration = [&](const ccvt::IterationRecord& record) {
    most = std::max(most, record.points);
    return true;
  };
  const Training trained = ccvt::train_codebook(points, kCodewords, options);
  CHECK(most == 4000);
  const auto& summary = trained.summary;
  CHECK(summary.termination == ccvt::Termination::stable);
  CHECK(summary.vectors == 12'001);
  CHECK(trained.codes.size() == 12'001);
  CHECK(summary.usage.smallest == 300);
  CHECK(summary.usage.largest == 301);
  CHECK(summary.gap < 1e-12);
  CHECK(summary.distortion < 1.1 * whole.summary.distortion);
  CHECK(trained.codebook.codewords() != whole.codebook.codewords());
  CHECK(summary.distortion == trained.codebook.distortion(points, trained.codes));

  CodebookOptions more = options;
  more.threads = 3;
  const Training again = ccvt::train_codebook(points, kCodewords, more);
  CHECK(again.codes == trained.codes);
  CHECK(again.codebook.codewords() == trained.codebook.codewords());
}

TEST_CASE("Codewords that a sample has placed move with all vectors") {
  const Points<float> points = clouds(12'001);
  const Training trained =
      ccvt::train_codebook(points, kCodewords, {.effort = 0, .threads = 1, .train_sample = 400});
  // How far codewords are from the centroids of their cells, as a share of the distortion.
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(3, kCodewords);
  std::vector<Index> size(kCodewords, 0);
  for (Index p = 0; p < points.cols(); ++p) {
    const Index code = trained.codes[static_cast<std::size_t>(p)];
    mean.col(code) += points.col(p).cast<double>();
    ++size[static_cast<std::size_t>(code)];
  }
  double off = 0;
  for (Index k = 0; k < kCodewords; ++k) {
    const double count = size[static_cast<std::size_t>(k)];
    off += count * (mean.col(k) / count - trained.codebook.codewords().col(k)).squaredNorm();
  }
  // Ten vectors a codeword put centroids off by a tenth of the distortion.
  CHECK(off / 12'001 < 0.03 * trained.summary.distortion);
}

TEST_CASE("No two vectors would cost less with each other's codes, after a sample too") {
  const Points<float> points = clouds(2000);
  const Training trained =
      ccvt::train_codebook(points, kCodewords, {.effort = 0, .train_sample = 500});
  const auto codewords = trained.codebook.codewords();
  const auto cost = [&](Index p, Index code) {
    return (points.col(p).cast<double>() - codewords.col(code)).squaredNorm();
  };
  double most = 0;
  for (Index p = 0; p < 2000; ++p) {
    for (Index q = 0; q < p; ++q) {
      const Index a = trained.codes[static_cast<std::size_t>(p)];
      const Index b = trained.codes[static_cast<std::size_t>(q)];
      most = std::max(most, cost(p, a) + cost(q, b) - cost(p, b) - cost(q, a));
    }
  }
  CHECK(most < 1e-9);
}

TEST_CASE("Capacities are those of all vectors, and a sample of all is no sample") {
  const Points<float> points = clouds(3000);
  std::vector<Index> capacities(10, 50);
  capacities.front() = 2550;
  const Training trained = ccvt::train_codebook(
      points, 10, {.effort = 0, .capacities = capacities, .train_sample = 600});
  std::vector<Index> held(10, 0);
  for (const Index code : trained.codes) ++held[static_cast<std::size_t>(code)];
  CHECK(held == capacities);

  const Training all = ccvt::train_codebook(points, 10, {.effort = 0});
  const Training sampled = ccvt::train_codebook(points, 10, {.effort = 0, .train_sample = 5000});
  CHECK(all.codes == sampled.codes);
}

TEST_CASE("A sample that says nothing of all codewords is refused, and so are other methods") {
  const Points<float> points = clouds(100);
  const auto refused = [&](const CodebookOptions& options) {
    return message_of([&] { static_cast<void>(ccvt::train_codebook(points, 20, options)); });
  };
  CHECK(refused({.train_sample = -1}) ==
        "CodebookOptions::train_sample is -1: it must be 0 or more");
  CHECK(refused({.train_sample = 19}) ==
        "train_sample is 19: it must be 0, or at least the number of codewords, 20");
  CHECK(refused({.method = CodebookMethod::lloyd, .train_sample = 50}) ==
        "CodebookOptions::train_sample is 50: it must be 0 but for exact");
}

TEST_SUITE_END();
