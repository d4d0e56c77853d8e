#include "ccvt/codebook.h"

#include <doctest/doctest.h>
#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/generate.h"

namespace ccvt::test {
namespace {

/// `clouds` well separated clouds of equal size.
Points<float> clouds(Index count, int cloud_count, int dimension) {
  Points<float> points = sample_uniform<float>(Box::unit(dimension), count, 3, Distribution::white);
  for (Index p = 0; p < count; ++p) {
    const int cloud = p % cloud_count;
    points(0, p) += 10.0F * static_cast<float>(cloud % 5);
    points(1, p) += 10.0F * static_cast<float>(cloud / 5);
  }
  return points;
}

CodebookOptions with(CodebookMethod method, std::uint64_t seed = 0) {
  CodebookOptions options;
  options.method = method;
  options.seed = seed;
  return options;
}

std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("exact training keeps sizes, ends at centroids and certifies itself") {
  for (const Layout layout : all_layouts) {
    CAPTURE(name_of(layout));
    const auto points = make_points<double>(layout, uneven_box(3), 2000);
    const auto [codebook, codes, summary] = train_codebook(points, 30, {});
    CHECK(summary.usage.smallest == 66);
    CHECK(summary.usage.largest == 67);
    CHECK(summary.gap <= 1e-12);
    CHECK(summary.termination == Termination::stable);
    // Under the weights no vector is cheaper elsewhere.
    const double scale = uneven_box(3).extent().squaredNorm();
    double moved = 0;
    for (Eigen::Index p = 0; p < points.cols(); ++p) {
      const Eigen::VectorXd reduced =
          (codebook.codewords().colwise() - points.col(p)).colwise().squaredNorm().transpose() -
          codebook.weights();
      const double own = reduced[codes[static_cast<std::size_t>(p)]];
      moved = std::max(moved, own - reduced.minCoeff());
    }
    CHECK(moved <= 1e-11 * scale);
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, 30);
    Eigen::VectorXd count = Eigen::VectorXd::Zero(30);
    for (Eigen::Index p = 0; p < points.cols(); ++p) {
      sum.col(codes[static_cast<std::size_t>(p)]) += points.col(p);
      ++count[codes[static_cast<std::size_t>(p)]];
    }
    CHECK((sum.array().rowwise() / count.transpose().array() - codebook.codewords().array())
              .abs()
              .maxCoeff() < 1e-5 * std::sqrt(scale));
  }
}

TEST_CASE("exact training ends, and certifies itself, where two groups are far apart") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Points<float> points = Points<float>::Constant(2, 1000, -6);  // about normal, variance 1
    for (std::uint64_t k = 0; k < 12; ++k) {
      points += sample_uniform<float>(Box::unit(2), 1000, 12 * seed + k, Distribution::white);
    }
    points.rightCols(500).array() += 1e4F;
    CodebookOptions options = with(CodebookMethod::exact, seed);
    const auto start = std::chrono::steady_clock::now();
    options.cancelled = [&] {  // what does not end is not to hold up the others
      return std::chrono::steady_clock::now() - start > std::chrono::seconds(60);
    };
    const auto summary = train_codebook(points, 32, options).summary;
    CHECK(summary.termination == Termination::stable);
    CHECK(summary.gap <= 1e-12);
  }
}

TEST_CASE("exact training goes on to the end where vectors are far from the origin") {
  // As seconds are since 1970.
  const Points<double> times =
      1.7e9 + sample_uniform(Box::unit(1), 20000, 1, Distribution::white).array();
  const auto summary = train_codebook(times, 64, {.effort = 0}).summary;
  CHECK(summary.termination == Termination::stable);
  CHECK(summary.gap <= 1e-12);
}

TEST_CASE("codewords may start farther away than vectors may be") {
  const Points<float> vectors = clouds(400, 4, 3);
  Points<double> start = Points<double>::Zero(3, 4);
  start(1, 2) = -1e60;
  const auto training =
      train_codebook_from(vectors, Columns<double>(start), with(CodebookMethod::pairwise));
  CHECK(training.summary.usage.smallest == 100);
  CHECK(training.codebook.codewords().cwiseAbs().maxCoeff() < 50);
}

TEST_CASE("what a cancelled training ends with goes to near codewords") {
  const auto points = sample_uniform<float>(Box::unit(2), 20'000, 5, Distribution::white);
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    CAPTURE(to_string(method));
    CodebookOptions options = with(method);
    options.cancelled = [] { return true; };
    const auto [codebook, codes, summary] = train_codebook(points, 100, options);
    CHECK(summary.termination == Termination::cancelled);
    CHECK(summary.distortion < 0.05);  // .17 where codes hang on nothing, .0017 at the end
    if (method != CodebookMethod::lloyd) CHECK(summary.usage.smallest == summary.usage.largest);
  }
}

TEST_CASE("what ends before an exact assignment says so") {
  const auto points = sample_uniform<float>(Box::unit(8), 200'000, 5, Distribution::white);
  CodebookOptions options = with(CodebookMethod::exact);
  options.seeding = Seeding::random;
  options.cancelled = [] { return true; };
  const auto [codebook, codes, summary] = train_codebook(points, 4000, options);
  CHECK(summary.gap == 1);
  CHECK(codebook.weights().isZero());
  CHECK(summary.usage.smallest == 50);
  CHECK(summary.usage.largest == 50);
  REQUIRE(summary.warnings.size() == 1);
  CHECK(summary.warnings[0].starts_with("training ended before "));
}

TEST_CASE("capacities of one beside those of many, where training starts on samples") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 20'000);
  std::vector<Index> capacities(10, 1);
  capacities[4] = 19'991;
  const CodebookOptions options{.capacities = capacities};
  const Training training = train_codebook(points, 10, options);
  const Training again =
      train_codebook_from(points, Columns<double>(training.codebook.codewords()), options);
  for (const auto& codes : {training.codes, again.codes}) {
    std::vector<Index> sizes(10, 0);
    for (const Index code : codes) ++sizes[static_cast<std::size_t>(code)];
    CHECK(sizes == capacities);
  }
}

TEST_CASE("a gap ends training sooner, is kept, and leaves sizes exact") {
  const auto points = make_points<double>(Layout::random, uneven_box(3), 4000);
  const Training exact = train_codebook(points, 40, {});
  const Training near = train_codebook(points, 40, {.gap = 1e-3});
  CHECK(near.summary.usage.smallest == 100);
  CHECK(near.summary.usage.largest == 100);
  CHECK(near.summary.termination == Termination::stable);
  CHECK(near.summary.iterations < exact.summary.iterations);
  CHECK(near.summary.distortion < 1.05 * exact.summary.distortion);
  // By brute force: what vectors could save under the weights, each alone.
  double saved = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Eigen::VectorXd reduced =
        (near.codebook.codewords().colwise() - points.col(p)).colwise().squaredNorm().transpose() -
        near.codebook.weights();
    saved += reduced[near.codes[static_cast<std::size_t>(p)]] - reduced.minCoeff();
  }
  CHECK(saved > 0);
  CHECK(near.summary.gap <= 1e-3);
  CHECK(near.summary.gap == doctest::Approx(saved / near.summary.energy).epsilon(1e-9));
  const Training again = train_codebook(points, 40, {.threads = 3, .gap = 1e-3});
  CHECK(again.codes == near.codes);
}

TEST_CASE("progress tells how far a training is, never falls, and never runs ahead of the end") {
  const auto vectors = clouds(20'000, 10, 4);
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    for (const Index codewords : {3, 40}) {  // with and without levels
      CAPTURE(to_string(method));
      CAPTURE(codewords);
      std::vector<double> progress;
      CodebookOptions options = with(method);
      options.on_iteration = [&](const IterationRecord& record) {
        progress.push_back(record.progress);
        return true;
      };
      const auto summary = train_codebook(vectors, codewords, options).summary;
      REQUIRE(std::ssize(progress) == summary.iterations);
      CHECK(std::is_sorted(progress.begin(), progress.end()));
      CHECK(progress.front() >= 0);
      if (progress.size() > 5) CHECK(progress.front() < 0.5);
      CHECK(progress.back() <= 1);
      CHECK(progress.back() > (method == CodebookMethod::exact ? 0.7 : 0.99));
    }
  }
}

TEST_CASE("all methods find separated clouds from any seed") {
  const auto points = clouds(3000, 15, 2);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    for (const auto method :
         {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
      const auto training = train_codebook(points, 15, with(method, seed));
      CHECK(training.summary.distortion < 0.18);  // 1/6 in a unit square
      CHECK(training.summary.usage.imbalance == doctest::Approx(1));
    }
  }
}

TEST_CASE("exact beats pairwise, and Lloyd both, from the same codewords") {
  const auto points = sample_uniform<float>(Box::unit(2), 4096, 2, Distribution::white);
  const Eigen::MatrixXd start = points.leftCols(64).cast<double>();
  const auto energy = [&](CodebookMethod method) {
    return train_codebook_from(points, start, with(method)).summary.energy;
  };
  const double exact = energy(CodebookMethod::exact);
  CHECK(exact < energy(CodebookMethod::pairwise));
  CHECK(energy(CodebookMethod::lloyd) < 1.02 * exact);
}

TEST_CASE("few vectors a codeword: exact training is not held back by what pairs would end at") {
  const auto vectors = clouds(2000, 20, 16);
  const auto distortion = [&](CodebookMethod method, Index codewords) {
    const CodebookOptions options{.method = method, .threads = 1, .seed = 3};
    return train_codebook(vectors, codewords, options).summary.distortion;
  };
  const double of_four = distortion(CodebookMethod::exact, 500);
  const double of_two = distortion(CodebookMethod::exact, 1000);
  CHECK(of_four < .612);  // as without pairs
  CHECK(of_two < .3145);
  CHECK(of_four < .98 * distortion(CodebookMethod::pairwise, 500));
  CHECK(of_two < .96 * distortion(CodebookMethod::pairwise, 1000));
}

TEST_CASE("capacities, one codeword, as many as vectors, and one place") {
  const auto points = make_points<float>(Layout::random, uneven_box(4), 60);
  CodebookOptions options;
  options.capacities = {10, 45, 5};
  const auto uneven = train_codebook(points, 3, options);
  std::vector<Index> sizes(3, 0);
  for (const Index code : uneven.codes) ++sizes[static_cast<std::size_t>(code)];
  CHECK(sizes == options.capacities);
  CHECK(train_codebook(points, 1).summary.usage.largest == 60);
  const auto all = train_codebook(points, 60);
  CHECK(all.summary.usage.imbalance == doctest::Approx(1));
  CHECK(all.summary.energy < 1e-25);
  const auto one_place = make_points<float>(Layout::one_place, uneven_box(4), 60);
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    CHECK(train_codebook(one_place, 7, with(method)).summary.energy < 1e-6);
  }
}

TEST_CASE("weighted codes of new vectors keep the balance, nearest ones do not") {
  for (const int dimension : {2, 12}) {
    const auto sample = [&](std::uint64_t seed) {
      Points<float> points =
          sample_uniform<float>(Box::unit(dimension), 8000, seed, Distribution::white);
      return Points<float>(points.array().cube());
    };
    const auto points = sample(1);
    const auto fresh = sample(2);
    const auto training = train_codebook(points, 16, {});
    const auto imbalance = [&](const Points<float>& vectors, Coding coding) {
      return code_usage(training.codebook.encode(vectors, coding), 16).imbalance;
    };
    CHECK(imbalance(fresh, Coding::weighted) < 1.05);
    CHECK(imbalance(fresh, Coding::nearest) > imbalance(fresh, Coding::weighted));
    // Encoding agrees with the definition.
    const auto codes = training.codebook.encode(fresh, Coding::weighted);
    for (Eigen::Index p = 0; p < 500; ++p) {
      const Eigen::VectorXd reduced =
          (training.codebook.codewords().colwise() - fresh.col(p).cast<double>())
              .colwise()
              .squaredNorm()
              .transpose() -
          training.codebook.weights();
      CHECK(reduced[codes[static_cast<std::size_t>(p)]] <= reduced.minCoeff() + 1e-12);
    }
  }
}

TEST_CASE("vectors in one place get one code, whatever their numbers") {
  for (const auto& shape : {std::pair{2, 50}, {3, 200}, {12, 50}, {12, 3000}}) {
    const int dimension = shape.first;
    const int words = shape.second;
    CAPTURE(dimension);
    CAPTURE(words);
    // Whole numbers of few values: half of the vectors are as near to several codewords.
    const auto lattice = [&](Index count, std::uint64_t seed) {
      const Points<float> points =
          sample_uniform<float>(Box::unit(dimension), count, seed, Distribution::white);
      return Points<float>((2 * points).array().round());
    };
    const Codebook codebook(lattice(words, 1));
    const Points<float> vectors = lattice(500, 2);
    Points<float> twice(dimension, 1001);
    twice << vectors.rowwise().reverse(), vectors.col(0), vectors;
    for (const Coding coding : {Coding::nearest, Coding::weighted}) {
      const std::vector<Index> codes = codebook.encode(vectors, coding);
      std::vector<Index> expected(codes.rbegin(), codes.rend());
      expected.push_back(codes[0]);
      expected.insert(expected.end(), codes.begin(), codes.end());
      CHECK(codebook.encode(twice, coding) == expected);
      std::vector<Index> alone;
      for (Index p = 0; p < 500; ++p) {
        alone.push_back(codebook.encode(Points<float>(vectors.col(p)), coding)[0]);
      }
      CHECK(alone == codes);
    }
  }
}

TEST_CASE("the number of threads changes no bit") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(5), 3000);
  CodebookOptions one;
  one.threads = 1;
  CodebookOptions four;
  four.threads = 4;
  const auto a = train_codebook(points, 40, one);
  const auto b = train_codebook(points, 40, four);
  CHECK(a.codes == b.codes);
  CHECK(a.codebook.codewords() == b.codebook.codewords());
  CHECK(a.codebook.weights() == b.codebook.weights());
}

TEST_CASE("vectors may lie as far apart as memory goes") {
  constexpr Index count = 40;
  constexpr std::ptrdiff_t stride = std::ptrdiff_t{1} << 27;  // 2^32 numbers in all, and more
  const Points<float> dense = clouds(count, 4, 3);
  constexpr std::size_t bytes = sizeof(float) * count * stride;
  void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  REQUIRE(memory != MAP_FAILED);
  auto* const far = static_cast<float*>(memory);
  for (Index p = 0; p < count; ++p) std::copy_n(dense.col(p).data(), 3, far + p * stride);
  const PointsView<float> view{far, 3, count, stride};
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    const Training near = train_codebook(dense, 4, with(method));
    const Training apart = train_codebook(view, 4, with(method));
    CHECK(near.codes == apart.codes);
    CHECK(near.summary.energy == apart.summary.energy);
    CHECK(near.codebook.encode(dense) == near.codebook.encode(view, Coding::nearest, 1));
  }
  ::munmap(memory, bytes);
}

TEST_CASE("a saved codebook comes back bit for bit") {
  const TemporaryDirectory directory;
  const auto points = make_points<double>(Layout::random, uneven_box(3), 200);
  const auto training = train_codebook(points, 9, {});
  for (const char* extension : {".npy", ".csv"}) {
    const auto words = directory / ("words" + std::string(extension));
    const auto weights = directory / ("weights" + std::string(extension));
    training.codebook.save(words, weights);
    const Codebook back = Codebook::load(words, weights);
    CHECK(back.codewords() == training.codebook.codewords());
    CHECK(back.weights() == training.codebook.weights());
    CHECK(Codebook::load(words).weights().isZero());
  }
  std::filesystem::create_symlink("loop", directory / "loop");
  CHECK_THROWS_AS(training.codebook.save(directory / "w.npy", directory / "loop" / "w.npy"),
                  ccvt::IoError);
  const auto same = directory / "." / "words.npy";
  CHECK(refusal([&] {
          training.codebook.save(directory / "words.npy", same);
        }).starts_with("weights: are to go into "));
  // NumPy's arrays of one dimension are weights, too.
  const std::vector<Index> whole = {3, 1, 4, 1, 5, 9, 2, 6, 5};
  write_owners(directory / "flat.npy", whole);
  const Codebook flat = Codebook::load(directory / "words.npy", directory / "flat.npy");
  CHECK(std::equal(whole.begin(), whole.end(), flat.weights().data()));
  write_owners(directory / "few.npy", std::span(whole).first(4));
  CHECK(refusal([&] {
          Codebook::load(directory / "words.npy", directory / "few.npy");
        }).find("few.npy: has 4 numbers, but one for each of the 9 codewords") !=
        std::string::npos);
  CHECK(refusal([&] {
          Codebook::load(directory / "words.npy", directory / "words.npy");
        }).find("words.npy: has 3 numbers a row; there must be one") != std::string::npos);
}

TEST_CASE("bad input is refused by name") {
  const auto points = make_points<float>(Layout::random, uneven_box(3), 20);
  const auto refused = [&](Index codewords, const CodebookOptions& options) {
    return refusal([&] { train_codebook(points, codewords, options); });
  };
  CHECK(refused(21, {}).find("codewords: is 21 for 20 vectors") != std::string::npos);
  CHECK(refused(0, {}).find("codewords: is 0 for 20 vectors") != std::string::npos);
  CHECK(refusal([&] { train_codebook(points.leftCols(0), 2); }) == "vectors: there are none");
  CHECK(refused(2, {.effort = -1}).find("effort is -1") != std::string::npos);
  CHECK(refused(2, {.method = CodebookMethod::lloyd, .effort = 3}).find("effort is 3") !=
        std::string::npos);
  CHECK(refused(2, {.restarts = -1}).find("restarts is -1") != std::string::npos);
  CHECK(refused(2, {.tolerance = 1}).find("tolerance is 1") != std::string::npos);
  CHECK(refused(2, {.gap = -0.1}).find("gap is -0.1") != std::string::npos);
  CHECK(refused(2, {.time_limit = -1}).find("time_limit is -1: it must be 0 (none)") !=
        std::string::npos);
  CHECK(refused(2, {.method = CodebookMethod::pairwise, .gap = 0.1}).find("gap is 0.1") !=
        std::string::npos);
  CHECK(refused(2, {.method = CodebookMethod::lloyd, .capacities = {10, 10}}).find("capacities") !=
        std::string::npos);
  CHECK(refused(2, {.capacities = {1, 2}}) != "");
  CHECK(refusal([&] {
          const ccvt::Columns<double> given(Eigen::MatrixXd::Identity(3, 2));
          static_cast<void>(ccvt::train_codebook_from(points, given, {.effort = 3}));
        }).find("effort is 3") != std::string::npos);
  const Codebook codebook(Eigen::MatrixXd::Identity(3, 3));
  CHECK(refusal([&] {
          static_cast<void>(codebook.decode(std::vector<Index>{0, 3}));
        }).find("codes[1] is 3") != std::string::npos);
  CHECK(refusal([&] {
          static_cast<void>(codebook.encode(Points<float>(2, 5)));
        }).find("2 dimensions") != std::string::npos);
  CHECK(refusal([] {
          Codebook(Eigen::MatrixXd::Identity(3, 3), Eigen::VectorXd::Zero(2));
        }).find("weights") != std::string::npos);
  CHECK(refusal([] {
          static_cast<void>(code_usage(std::vector<Index>{0, 2}, 2));
        }).find("codes[1] is 2") != std::string::npos);
}

TEST_SUITE_END();

}  // namespace ccvt::test
