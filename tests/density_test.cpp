#include "ccvt/density.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "parallel/arena.h"
#include "random.h"
#include "sampling/hilbert.h"
#include "sampling/mass.h"
#include "streams.h"

using ccvt::Box;
using ccvt::DensityGrid;
using ccvt::DensitySampling;
using ccvt::Index;
using ccvt::InvalidInput;
using ccvt::sample_density;
using ccvt::sample_function;

namespace {

constexpr DensitySampling both[] = {DensitySampling::white, DensitySampling::stratified};

using Shape = std::vector<std::int64_t>;

std::int64_t cells_of(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

Box box_of(const Shape& shape) {
  Box box = Box::unit(static_cast<int>(shape.size()));
  for (Eigen::Index d = 0; d < box.lower.size(); ++d) {
    box.lower[d] = 1 - static_cast<double>(d);
    box.upper[d] = box.lower[d] + 2 + static_cast<double>(d);
  }
  return box;
}

// Random values from 0 to 1, a fifth of them 0.
template <class Value>
std::vector<Value> rough_values(const Shape& shape, std::uint64_t seed) {
  ccvt::Random random(seed);
  std::vector<Value> values(static_cast<std::size_t>(cells_of(shape)));
  for (Value& value : values) {
    value = static_cast<Value>(std::max(random.uniform() * 1.25 - 0.25, 0.0));
  }
  return values;
}

// The number of points in each cell of a grid.
std::vector<double> histogram(const Eigen::MatrixXd& points, const Shape& shape, const Box& box) {
  std::vector<double> counts(static_cast<std::size_t>(cells_of(shape)));
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    std::int64_t cell = 0;
    std::int64_t stride = 1;
    for (std::size_t d = 0; d < shape.size(); ++d) {
      const auto e = static_cast<Eigen::Index>(d);
      const double share = (points(e, p) - box.lower[e]) / (box.upper[e] - box.lower[e]);
      cell += stride * static_cast<std::int64_t>(share * static_cast<double>(shape[d]));
      stride *= shape[d];
    }
    ++counts.at(static_cast<std::size_t>(cell));
  }
  return counts;
}

// Pearson's statistic over its degrees of freedom: near 1 for independent draws from `values`.
template <class Value>
double relative_chi_square(const std::vector<double>& counts, const std::vector<Value>& values) {
  const double points = std::accumulate(counts.begin(), counts.end(), 0.0);
  const double total = std::accumulate(values.begin(), values.end(), 0.0);
  double sum = 0;
  int freedom = -1;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double expected = points * static_cast<double>(values[i]) / total;
    if (expected == 0) {
      CHECK(counts[i] == 0);
      continue;
    }
    sum += (counts[i] - expected) * (counts[i] - expected) / expected;
    ++freedom;
  }
  return sum / std::max(freedom, 1);
}

// The message that refuses a call, or "" when it is not refused.
template <class Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

bool mentions(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

double bump(std::span<const double> x) {
  double squared = 0;
  for (const double c : x) squared += (c - 0.4) * (c - 0.4);
  return std::exp(-10 * squared);
}

}  // namespace

TEST_SUITE_BEGIN("density");

TEST_CASE("the Hilbert curve visits each cell of any shape once") {
  for (const Shape& shape : std::vector<Shape>{{1},
                                               {7},
                                               {5, 3},
                                               {1, 9, 1},
                                               {16, 16},
                                               {3, 17, 2},
                                               {4, 4, 4, 4},
                                               {100, 1, 2},
                                               {2, 2, 2, 2, 2, 2, 2, 3}}) {
    std::vector<int> seen(static_cast<std::size_t>(cells_of(shape)));
    ccvt::HilbertCurve(shape).visit(
        [&](std::int64_t cell) { ++seen.at(static_cast<std::size_t>(cell)); });
    CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  }
}

TEST_CASE("the Hilbert curve steps from face to face in grids of equal powers of two") {
  for (const Shape& shape : std::vector<Shape>{
           {64}, {2, 2}, {32, 32}, {8, 8, 8}, {4, 4, 4, 4}, {8, 8, 8, 8, 8}, {2, 2, 2, 2, 2, 2}}) {
    std::int64_t before = -1;
    int jumps = 0;
    ccvt::HilbertCurve(shape).visit([&](std::int64_t cell) {
      std::int64_t distance = 0;
      std::int64_t a = before;
      std::int64_t b = cell;
      for (const std::int64_t n : shape) {
        distance += std::abs(a % n - b % n);
        a /= n;
        b /= n;
      }
      jumps += before >= 0 && distance != 1 ? 1 : 0;
      before = cell;
    });
    CHECK(jumps == 0);
  }
}

TEST_CASE("parts of the Hilbert curve, strung together, are the curve") {
  for (const Shape& shape : std::vector<Shape>{
           {1}, {70}, {5, 3}, {1, 9, 1}, {32, 32}, {3, 40, 2}, {9, 10, 11}, {4, 4, 4, 4}}) {
    ccvt::HilbertCurve curve(shape);
    std::vector<std::int64_t> whole;
    curve.visit([&](std::int64_t cell) { whole.push_back(cell); });
    for (int level = 0; level < 8; ++level) {
      std::vector<std::int64_t> cells;
      bool same_cells = true;
      for (const auto& part : curve.parts(level)) {
        std::vector<std::int64_t> along;
        std::vector<std::int64_t> in_rows;
        curve.visit(part, level, [&](std::int64_t cell) { along.push_back(cell); });
        bool same_places = true;
        curve.visit_rows(
            part, level, [&](std::int64_t first, std::int64_t count, std::int64_t place) {
              for (std::int64_t i = 0; i < count; ++i) {
                in_rows.push_back(first + i);
                same_places = same_places && curve.cell(part, level, place + i) == first + i;
              }
            });
        CHECK(same_places);
        CHECK(curve.cells(part, level) == std::ssize(in_rows));
        cells.insert(cells.end(), along.begin(), along.end());
        CHECK(std::is_sorted(in_rows.begin(), in_rows.end()));
        std::sort(along.begin(), along.end());
        same_cells = same_cells && along == in_rows;
      }
      CHECK(cells == whole);
      CHECK(same_cells);
    }
  }
}

TEST_CASE("sorted draws are ascending, independent and even up to both ends") {
  const ccvt::Arena arena(2);
  for (const Index count : {1, 15, 16, 1000}) {
    std::vector<double> counts(100);
    for (std::uint64_t seed = 0; seed < 200000 / static_cast<std::uint64_t>(count); ++seed) {
      const ccvt::SortedDraws draws(seed, count, arena);
      double before = 0;
      bool ascending = true;
      Index total = 0;
      std::vector<double> bin;
      for (std::size_t b = 0; b < draws.bins(); ++b) {
        CHECK_MESSAGE(draws.before(b) == total, "bin " << b);
        draws.open(b, bin);
        total += static_cast<Index>(bin.size());
        for (const double draw : bin) {
          ascending = ascending && draw >= before && draw < 1;
          before = draw;
          ++counts.at(static_cast<std::size_t>(draw * 100));
        }
      }
      if (!ascending || total != count) FAIL_CHECK("not ascending in [0, 1), or not all");
    }
    const double statistic = relative_chi_square(counts, std::vector<double>(100, 1.0));
    CHECK(statistic > 0.5);
    CHECK(statistic < 1.6);
  }
}

TEST_CASE("sorted draws are counted over more bins than a row has") {
  const std::int64_t count = 2'500'000;
  const ccvt::SortedDraws one(3, count, ccvt::Arena(1));
  const ccvt::SortedDraws two(3, count, ccvt::Arena(2));
  // Dealt as documented, by chunks of 2^16 with random numbers of their own.
  std::vector<std::int64_t> in_bin(one.bins(), 0);
  for (std::int64_t k = 0; k < count;) {
    ccvt::Random random(3, ccvt::streams::density_deal + static_cast<std::uint64_t>(k >> 16));
    for (const std::int64_t end = std::min(count, k + 65'536); k < end; ++k) {
      ++in_bin[random.below(one.bins())];
    }
  }
  std::int64_t before = 0;
  bool counted = true;
  std::vector<double> bin;
  for (std::size_t b = 0; b < one.bins(); ++b) {
    one.open(b, bin);
    counted = counted && one.before(b) == before && two.before(b) == before &&
              std::ssize(bin) == in_bin[b];
    before += in_bin[b];
  }
  CHECK(counted);
  CHECK(one.before(one.bins()) == count);
}

TEST_CASE("of more than 2^32 draws each group gets those of its share, with their numbers") {
  constexpr std::int64_t half = std::int64_t{1} << 32;
  const std::vector<double> masses{half + 10, 20, half - 40, 10};  // one for each draw
  const ccvt::StratifiedDraws draws(5, 2 * half);
  const std::vector<std::size_t> groups{1, 3};
  std::vector<std::int64_t> first(4, -1);
  ccvt::deal(ccvt::Shares(masses), groups, draws, ccvt::Arena(1),
             [&](std::size_t g, int, std::int64_t number, std::span<const double> targets) {
               first[g] = number;
               REQUIRE(std::ssize(targets) == static_cast<std::ptrdiff_t>(masses[g]));
               for (std::size_t k = 0; k < targets.size(); ++k) CHECK(std::floor(targets[k]) == k);
             });
  CHECK(first == std::vector<std::int64_t>{-1, half + 10, -1, 2 * half - 10});
}

TEST_CASE("no bin has the random numbers of another, or of the places in a part") {
  std::set<std::uint64_t> first;
  constexpr std::uint64_t far = std::uint64_t{1} << 32;
  for (const std::uint64_t bin : {std::uint64_t{0}, far - 1, far, far + 1, far << 7, far << 8}) {
    first.insert(ccvt::random_of_bin(7, bin).next());
  }
  first.insert(ccvt::Random(7, ccvt::streams::density_place).next());
  first.insert(ccvt::Random(7, ccvt::streams::density_place + 1).next());
  CHECK(first.size() == 8);
}

TEST_CASE("draws at the ends of groups and cells go to those with mass") {
  struct Fixed {  // one draw a bin
    std::vector<double> values;
    [[nodiscard]] std::size_t bins() const { return values.size(); }
    [[nodiscard]] static std::int64_t before(std::size_t bin) {
      return static_cast<std::int64_t>(bin);
    }
    void open(std::size_t bin, std::vector<double>& draws) const { draws = {values[bin]}; }
  };
  const std::vector<double> masses{0, 1, 0, 0, 1, 2, 0};
  using Hits = std::vector<Index>;
  // Bin b of B must hold draws from b/B up to (b+1)/B.
  const auto groups = [&](const std::vector<double>& draws) {
    Hits found(masses.size());
    ccvt::deal(masses, Fixed{draws}, ccvt::Arena(1),
               [&](std::size_t g, int, std::int64_t, std::span<const double> targets) {
                 for (const double target : targets) CHECK(target >= 0);
                 found[g] += static_cast<Index>(targets.size());
               });
    return found;
  };
  CHECK(groups({0, 0.25, 0.5, 0.75}) == Hits{0, 1, 0, 0, 1, 2, 0});
  CHECK(groups({0.249, 0.499, 0.5, 0.999}) == Hits{0, 1, 0, 0, 1, 2, 0});
  CHECK(groups({1}) == Hits{0, 0, 0, 0, 0, 1, 0});  // rounded up
  const auto cells = [&](const std::vector<double>& targets) {
    Hits found(masses.size());
    ccvt::deal_to_cells(
        targets,
        [&](const auto& f) {
          for (std::size_t i = 0; i < masses.size(); ++i)
            f(static_cast<std::int64_t>(i), masses[i]);
        },
        [&](std::int64_t cell, std::int64_t n) {
          found[static_cast<std::size_t>(cell)] += static_cast<Index>(n);
        });
    return found;
  };
  CHECK(cells({0, 1, 2, 3}) == Hits{0, 1, 0, 0, 1, 2, 0});
  CHECK(cells({0, 0, 0.8, 1.999}) == Hits{0, 3, 0, 0, 1, 0, 0});
  CHECK(cells({2.4, 4, 4.5}) == Hits{0, 0, 0, 0, 0, 3, 0});  // rounded up beyond the masses
}

TEST_CASE_TEMPLATE("points follow the grid in any dimension", Value, float, double) {
  for (const Shape& shape : std::vector<Shape>{
           {50}, {13, 7}, {16, 16}, {5, 4, 6}, {3, 2, 4, 3}, {2, 1, 2, 2, 1, 3, 2}}) {
    const std::vector<Value> values = rough_values<Value>(shape, 5);
    const DensityGrid grid{values, shape, box_of(shape)};
    for (const Index count : {1, 10, 1000, 40000}) {
      const auto white = sample_density<double>(grid, count, 1, DensitySampling::white);
      const auto stratified = sample_density<double>(grid, count, 1, DensitySampling::stratified);
      CHECK(white.cols() == count);
      CHECK(stratified.cols() == count);
      const double w = relative_chi_square(histogram(white, shape, grid.box), values);
      const double s = relative_chi_square(histogram(stratified, shape, grid.box), values);
      if (count < 40000) continue;
      const double spread = std::sqrt(2.0 / static_cast<double>(values.size()));
      CHECK(w > 1 - 4 * spread);
      CHECK(w < 1 + 4 * spread);
      // Every cell gets its share to within two draws.
      CHECK(s < 0.1);
    }
  }
}

TEST_CASE("stratified: unbiased, with about one point a cell") {
  // Mean counts over many seeds are those of the grid, to the accuracy that their variance allows.
  const Shape shape{9, 7};
  const std::vector<double> values = rough_values<double>(shape, 6);
  const double total = std::accumulate(values.begin(), values.end(), 0.0);
  const DensityGrid grid{values, shape, box_of(shape)};
  constexpr int runs = 4000;
  constexpr Index count = 50;
  std::vector<double> sums(values.size());
  for (std::uint64_t seed = 0; seed < runs; ++seed) {
    const auto counts = histogram(sample_density<double>(grid, count, seed), shape, grid.box);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += counts[i];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double expected = count * values[i] / total;
    // A count is the sum of at most expected + 2 draws that may go either way.
    CHECK(std::abs(sums[i] / runs - expected) <= 4.5 * std::sqrt(std::min(expected, 0.5) / runs));
  }
}

TEST_CASE("stratified: counts of regions vary far less than white ones") {
  const Shape shape{64, 64};
  const std::vector<double> values = rough_values<double>(shape, 7);
  const double total = std::accumulate(values.begin(), values.end(), 0.0);
  const DensityGrid grid{values, shape, Box::unit(2)};
  for (const Index count : {1000, 20000}) {
    double squared[2] = {0, 0};
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      for (const DensitySampling sampling : both) {
        const auto counts =
            histogram(sample_density<double>(grid, count, seed, sampling), shape, grid.box);
        for (std::size_t x = 0; x < 64; x += 16) {  // windows of 16 by 64 cells
          double deviation = 0;
          for (std::size_t i = 0; i < counts.size(); ++i) {
            if (i % 64 >= x && i % 64 < x + 16) deviation += counts[i] - count * values[i] / total;
          }
          squared[sampling == DensitySampling::stratified] += deviation * deviation;
        }
      }
    }
    CAPTURE(count);
    CHECK(squared[0] > 0.5 * 160 * count * 3.0 / 16);
    CHECK(squared[1] < 0.1 * squared[0]);
  }
}

TEST_CASE("points fill a cell uniformly, and stratified ones jittered") {
  const std::vector<float> values{0, 0, 0, 1, 0, 0};
  const DensityGrid grid{values, {3, 2}, Box{Eigen::Vector2d(0, 0), Eigen::Vector2d(3, 2)}};
  for (const DensitySampling sampling : both) {
    // The only cell with a density is [0, 1] x [1, 2].
    const auto points = sample_density<float, 2>(grid, 1024, 3, sampling);
    Box cell{Eigen::Vector2d(0, 1), Eigen::Vector2d(1, 2)};
    std::vector<double> fine = histogram(points.cast<double>(), {32, 32}, cell);
    const bool even = std::all_of(fine.begin(), fine.end(), [](double n) { return n == 1; });
    CHECK(even == (sampling == DensitySampling::stratified));
    const auto coarse = histogram(points.cast<double>(), {5, 5}, cell);
    CHECK(relative_chi_square(coarse, std::vector<double>(25, 1.0)) < 2);
  }
}

namespace {

// The multilinear interpolant, from its definition: the 2^D nearest centres, those outside taken
// from the border. `x` in cells from the corner of the grid.
double interpolated(const std::vector<double>& values, const Shape& shape, const double* x) {
  double sum = 0;
  for (std::size_t corner = 0; corner < std::size_t{1} << shape.size(); ++corner) {
    double weight = 1;
    std::size_t index = 0;
    std::size_t stride = 1;
    for (std::size_t d = 0; d < shape.size(); ++d) {
      const double low = std::floor(x[d] - 0.5);
      const double share = x[d] - 0.5 - low;
      const bool high = (corner >> d & 1) != 0;
      weight *= high ? share : 1 - share;
      const auto last = static_cast<double>(shape[d] - 1);
      index += stride * static_cast<std::size_t>(std::clamp(low + (high ? 1 : 0), 0.0, last));
      stride *= static_cast<std::size_t>(shape[d]);
    }
    sum += weight * values[index];
  }
  return sum;
}

// The mean of that over each cell of a grid `fine` times as fine. Exact: midpoints of cells in
// which the interpolant is linear along each axis, for even `fine`.
std::vector<double> refined(const std::vector<double>& values, const Shape& shape,
                            std::int64_t fine) {
  Shape all = shape;
  for (auto& n : all) n *= fine;
  std::vector<double> result(static_cast<std::size_t>(cells_of(all)));
  std::vector<double> x(shape.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    auto rest = static_cast<std::int64_t>(i);
    for (std::size_t d = 0; d < all.size(); ++d) {
      x[d] = (static_cast<double>(rest % all[d]) + 0.5) / static_cast<double>(fine);
      rest /= all[d];
    }
    result[i] = interpolated(values, shape, x.data());
  }
  return result;
}

}  // namespace

TEST_CASE("points follow the multilinear interpolant in any dimension") {
  for (const Shape& shape :
       std::vector<Shape>{{1}, {2}, {20}, {7, 5}, {1, 6}, {5, 4, 6}, {3, 2, 1, 3}, {2, 2, 2, 2}}) {
    std::vector<double> values = rough_values<double>(shape, 15);
    for (double& value : values) value += 0.01;  // a cell of 0 would stay empty: see mask_test.cpp
    DensityGrid grid{values, shape, box_of(shape)};
    grid.interpolation = ccvt::Interpolation::linear;
    const std::int64_t fine = shape.size() > 2 ? 2 : 4;
    const std::vector<double> expected = refined(values, shape, fine);
    Shape cells = shape;
    for (auto& n : cells) n *= fine;
    const double spread = std::sqrt(2.0 / static_cast<double>(expected.size()));
    CAPTURE(shape.size());
    const auto white = sample_density<double>(grid, 200000, 4, DensitySampling::white);
    const double w = relative_chi_square(histogram(white, cells, grid.box), expected);
    CHECK(w > 1 - 4.5 * spread);
    CHECK(w < 1 + 4.5 * spread);
    const auto stratified = sample_density<double>(grid, 200000, 4);
    CHECK(relative_chi_square(histogram(stratified, cells, grid.box), expected) < 0.5);
    // The oracle can tell: a piecewise constant density is another distribution.
    if (shape.size() < 3 && values.size() > 2) {
      grid.interpolation = ccvt::Interpolation::constant;
      const auto constant = sample_density<double>(grid, 200000, 4, DensitySampling::white);
      CHECK(relative_chi_square(histogram(constant, cells, grid.box), expected) > 10);
    }
  }
}

TEST_CASE("one axis of a multilinear density passes the test of Kolmogorov and Smirnov") {
  // Values 1 and 3 in two cells: the density over [0, 2] is 1, then rises to 3, then stays.
  const std::vector<double> values{1, 3};
  DensityGrid grid{values, {2}, Box{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, 2)}};
  grid.interpolation = ccvt::Interpolation::linear;
  const auto distribution = [](double x) {
    if (x < 0.5) return x / 4;
    if (x < 1.5) return (0.5 + (x - 0.5) + (x - 0.5) * (x - 0.5)) / 4;
    return (2.5 + 3 * (x - 1.5)) / 4;
  };
  constexpr Index count = 100000;
  auto points = sample_density<double>(grid, count, 3, DensitySampling::white);
  std::sort(points.data(), points.data() + count);
  double distance = 0;
  for (Index k = 0; k < count; ++k) {
    const double f = distribution(points(0, k));
    distance = std::max({distance, f - k / double{count}, (k + 1) / double{count} - f});
  }
  CHECK(distance < 1.63 / std::sqrt(count));  // at the level of 1 %
}

TEST_CASE("values of any type, mapped and masked, are the densities that they stand for") {
  const Shape shape{9, 8, 5};
  const std::size_t cells = 360;
  std::vector<std::uint8_t> mask(cells, 1);
  for (std::size_t i = 0; i < cells; i += 3) mask[i] = 0;
  const std::function<double(double)> map = [](double v) { return 0.5 * v + 70; };
  const auto check = [&](auto zero) {
    using Value = decltype(zero);
    ccvt::Random random(3);
    std::vector<Value> values(cells);
    std::vector<double> densities(cells);
    for (std::size_t i = 0; i < cells; ++i) {
      const double least = std::is_signed_v<Value> ? -100 : 0;
      values[i] = static_cast<Value>(least + 200 * random.uniform());
      densities[i] = mask[i] == 0 ? 0 : 0.5 * static_cast<double>(values[i]) + 70;
    }
    DensityGrid given{values, shape, box_of(shape)};
    given.map = map;
    given.mask = mask;
    const DensityGrid plain{densities, shape, box_of(shape)};
    for (const DensitySampling sampling : both) {
      const auto a = sample_density<float>(given, 3000, 5, sampling);
      const auto b = sample_density<float>(plain, 3000, 5, sampling);
      CHECK((a.array() == b.array()).all());
    }
  };
  check(std::int8_t{});
  check(std::uint8_t{});
  check(std::int16_t{});
  check(std::uint16_t{});
  check(std::int32_t{});
  check(std::uint32_t{});
  check(std::int64_t{});
  check(std::uint64_t{});
  check(float{});
  check(double{});
}

TEST_CASE("an affine map takes points to the world") {
  const Shape shape{6, 5, 4};
  const std::vector<double> values = rough_values<double>(shape, 9);
  DensityGrid grid{values, shape, box_of(shape)};
  grid.interpolation = ccvt::Interpolation::linear;
  ccvt::Affine affine{Eigen::MatrixXd::Zero(3, 3), Eigen::Vector3d(100, -20, 3)};
  affine.matrix.eigen() << 0, -2, 0.3, 1, 0, 0, 0.1, 0, 3;
  // Independent draws do not depend on the shape of the cells.
  const auto box = sample_density<double>(grid, 5000, 1, DensitySampling::white);
  grid.to_world = affine;
  const auto world = sample_density<double>(grid, 5000, 1, DensitySampling::white);
  CHECK(((affine.matrix.eigen() * box).colwise() + affine.offset.eigen() - world)
            .cwiseAbs()
            .maxCoeff() < 1e-12);
  affine.matrix.eigen().row(2) = affine.matrix.eigen().row(0);
  grid.to_world = affine;
  CHECK(mentions(refusal([&] { sample_density<double>(grid, 5); }), "singular"));
  grid.to_world = ccvt::Affine{Eigen::MatrixXd::Identity(2, 2), Eigen::Vector2d(0, 0)};
  CHECK(mentions(refusal([&] { sample_density<double>(grid, 5); }), "matrix of 2 x 2"));
}

TEST_CASE("any number of threads gives the same points") {
  const Shape shape{40, 30, 20};
  const std::vector<float> values = rough_values<float>(shape, 10);
  DensityGrid grid{values, shape, box_of(shape)};
  grid.interpolation = ccvt::Interpolation::linear;
  const auto f = [](std::span<const double> x) { return bump(x); };
  for (const DensitySampling sampling : both) {
    const auto one = sample_density<float>(grid, 30000, 6, sampling, 1);
    const auto function = sample_function<float>(f, 1, Box::unit(3), 20000, 6, sampling, 1);
    for (const int threads : {2, 3}) {
      CHECK(
          (sample_density<float>(grid, 30000, 6, sampling, threads).array() == one.array()).all());
      CHECK((sample_function<float>(f, 1, Box::unit(3), 20000, 6, sampling, threads).array() ==
             function.array())
                .all());
    }
  }
}

TEST_CASE("refused densities are named by the value, the density and the first cell") {
  std::vector<std::int16_t> values(60000, 1);
  values[40000] = -7;
  values[50000] = -9;
  DensityGrid grid{values, {200, 300}, Box::unit(2)};
  for (const int threads : {1, 2}) {
    const auto message =
        refusal([&] { sample_density<float>(grid, 5, 0, DensitySampling::white, threads); });
    CHECK(mentions(message, "values[40000], cell (0, 200) (fastest axis first), is -7, but"));
  }
  grid.map = [](double v) { return v - 1; };
  CHECK(mentions(refusal([&] { sample_density<float>(grid, 5); }), "is -7, and its density -8"));
  grid.map = [](double) { return 0.0; };
  CHECK(mentions(refusal([&] { sample_density<float>(grid, 5); }), "all 60000 densities are 0"));
  const std::vector<std::uint8_t> mask(7, 1);
  grid.mask = mask;
  CHECK(mentions(refusal([&] { sample_density<float>(grid, 5); }), "mask has 7 entries"));
}

TEST_CASE("one seed gives the same bytes, another does not, and the dimension may be fixed") {
  const Shape shape{20, 30, 4};
  const std::vector<float> values = rough_values<float>(shape, 8);
  const DensityGrid grid{values, shape, box_of(shape)};
  const auto f = [](std::span<const double> x) { return bump(x); };
  for (const DensitySampling sampling : both) {
    const auto a = sample_density<float>(grid, 5000, 1, sampling);
    CHECK((sample_density<float, 3>(grid, 5000, 1, sampling).array() == a.array()).all());
    CHECK((sample_density<float>(grid, 5000, 2, sampling).array() == a.array()).count() < 100);
    const auto b = sample_function<double>(f, 1, Box::unit(2), 500, 1, sampling);
    CHECK((sample_function<double, 2>(f, 1, Box::unit(2), 500, 1, sampling).array() == b.array())
              .all());
    CHECK((sample_function<double>(f, 1, Box::unit(2), 500, 2, sampling).array() == b.array())
              .count() < 10);
  }
}

TEST_CASE("extreme values: one bright cell, huge and tiny densities, points inside in float") {
  for (const double scale : {1e-300, 1.0, 1e290}) {
    std::vector<double> values(1000, 1e-6 * scale);
    values[617] = scale;
    const DensityGrid grid{values, {10, 10, 10}, Box::unit(3)};
    for (const DensitySampling sampling : both) {
      const auto points = sample_density<float, 3>(grid, 20000, 4, sampling);
      CHECK(points.minCoeff() >= 0);
      CHECK(points.maxCoeff() < 1);
      const auto counts = histogram(points.cast<double>(), grid.shape, grid.box);
      CHECK(counts[617] == doctest::Approx(20000 / (1 + 999e-6)).epsilon(0.002));
    }
  }
}

TEST_CASE("points follow a function in any dimension, stratified ones with less variance") {
  const auto f = [](std::span<const double> x) { return bump(x); };
  for (const int dimension : {1, 2, 3}) {
    // Cell probabilities by product of one-dimensional integrals.
    constexpr int cells = 6;
    std::vector<double> line(cells);
    for (int i = 0; i < 600; ++i) {
      const double x[] = {(i + 0.5) / 600};
      line[static_cast<std::size_t>(i / 100)] += bump(x);
    }
    const Shape shape(static_cast<std::size_t>(dimension), cells);
    std::vector<double> values(static_cast<std::size_t>(cells_of(shape)), 1.0);
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t rest = i, d = 0; d < shape.size(); ++d, rest /= cells) {
        values[i] *= line[rest % cells];
      }
    }
    const Box box = Box::unit(dimension);
    const double spread = std::sqrt(2.0 / static_cast<double>(values.size()));
    const auto white = sample_function<double>(f, 1, box, 30000, 2, DensitySampling::white);
    const auto stratified = sample_function<float>(f, 1, box, 30000, 2);
    const double w = relative_chi_square(histogram(white, shape, box), values);
    const double s = relative_chi_square(histogram(stratified.cast<double>(), shape, box), values);
    CAPTURE(dimension);
    CHECK(w > 1 - 4 * spread);
    CHECK(w < 1 + 4 * spread);
    CHECK(s < 0.5 * w);
  }
}

TEST_CASE("a function is never sampled where it is zero, and may be called in 20 dimensions") {
  const auto half = [](std::span<const double> x) { return x[0] < 0.5 ? 1.0 : 0.0; };
  for (const DensitySampling sampling : both) {
    const auto points = sample_function<float>(half, 1, Box::unit(20), 3000, 2, sampling);
    CHECK(points.row(0).maxCoeff() < 0.5F);
    CHECK(points.cols() == 3000);
    CHECK(std::abs(points.row(7).mean() - 0.5F) < 0.03F);
  }
}

TEST_CASE("a function concentrated in a small part is found, by both") {
  const auto spot = [](std::span<const double> x) {
    return x[0] < 0.02 && x[1] < 0.02 ? 5.0 : 0.0;
  };
  for (const DensitySampling sampling : both) {
    const auto points = sample_function<double, 2>(spot, 5, Box::unit(2), 2000, 2, sampling);
    CHECK(points.maxCoeff() < 0.02);
    CHECK((points.array() * 50).mean() == doctest::Approx(0.5).epsilon(0.05));
  }
}

TEST_CASE("refused grids name index and value") {
  const std::vector<double> good(12, 1.0);
  const auto message = [](const std::vector<double>& values, Shape shape,
                          const Box& box = Box::unit(2)) {
    const DensityGrid grid{values, std::move(shape), box};
    return refusal([&] { sample_density<float>(grid, 5); });
  };
  CHECK(message(good, {3, 4}).empty());
  for (const double bad : {-0.5, std::nan(""), HUGE_VAL}) {
    std::vector<double> values = good;
    values[7] = bad;
    CHECK(mentions(message(values, {3, 4}), "values[7], cell (1, 2) (fastest axis first), is"));
  }
  std::vector<double> negative = good;
  negative[7] = -0.5;
  CHECK(mentions(message(negative, {3, 4}), "is -0.5,"));
  CHECK(mentions(message(std::vector<double>(12, 0.0), {3, 4}), "all 12 values are 0"));
  CHECK(mentions(message(std::vector<double>(12, 1e308), {3, 4}), "overflows"));
  CHECK(mentions(message(good, {3, 5}), "(3, 5) has 15 cells, but there are 12"));
  CHECK(mentions(message(good, {3, 0}), "shape[1] is 0"));
  CHECK(mentions(message(good, {12}), "shape has 1 dimensions, but the box has 2"));
  CHECK(mentions(message(good, {1LL << 40, 1LL << 40}), "2^63"));
  CHECK(mentions(message(good, {3, 4}, Box::unit(0)), "0 dimensions"));
  const DensityGrid grid{good, {3, 4}, Box::unit(2)};
  CHECK(mentions(refusal([&] { sample_density<float>(grid, 0); }), "count: is 0"));
  CHECK(mentions(refusal([&] { sample_density<float, 3>(grid, 1); }), "points of 3"));
}

TEST_CASE("refused functions name point and value") {
  for (const DensitySampling sampling : both) {
    const auto message = [&](const ccvt::DensityFunction& f, double maximum = 1) {
      return refusal([&] { sample_function<double>(f, maximum, Box::unit(1), 50, 1, sampling); });
    };
    using X = std::span<const double>;
    CHECK(message([](X x) { return x[0]; }).empty());
    CHECK(mentions(message([](X x) { return x[0] < 0.9 ? 1 : -2.5; }), "density: is -2.5 at (0.9"));
    CHECK(mentions(message([](X x) { return x[0] < 0.9 ? 1 : 1.5; }), "density: is 1.5 at (0.9"));
    CHECK(mentions(message([](X x) { return x[0] < 0.9 ? 1 : std::nan(""); }), "is nan at (0.9"));
    CHECK(mentions(message([](X) { return 1; }, 0), "maximum: is 0"));
    CHECK(mentions(message([](X) { return 1; }, HUGE_VAL), "maximum: is inf"));
    CHECK(mentions(message([](X) { return 0; }), "density: "));
    CHECK(mentions(message(ccvt::DensityFunction()), "density: is empty"));
  }
}

TEST_SUITE_END();
