#include "ccvt/grid_values.h"

#include <doctest/doctest.h>

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/volume.h"
#include "support/message.h"

using ccvt::DensityGrid;
using ccvt::Grid;
using ccvt::GridValues;
using ccvt::MaskView;
using ccvt::Volume;
using namespace ccvt::test;

namespace {

// What outlives the view is taken, what does not is refused, both at compile time.
template <class From>
constexpr bool taken = std::constructible_from<GridValues, From>;
static_assert(taken<std::vector<float>&> && taken<const std::vector<std::int16_t>&>);
static_assert(!taken<std::vector<float>> && !taken<const std::vector<float>>);
static_assert(taken<std::array<double, 3>&> && !taken<std::array<double, 3>>);
static_assert(taken<std::span<const float>> && taken<std::span<std::uint8_t>>);
static_assert(taken<Eigen::VectorXi&> && !taken<Eigen::VectorXi>);
static_assert(taken<Eigen::Map<Eigen::VectorXf>> && taken<const Eigen::ArrayXXd&>);
static_assert(!taken<decltype(std::declval<Eigen::VectorXi&>() * 2)>);  // has no numbers in memory
static_assert(taken<GridValues&> && taken<GridValues>);
static_assert(std::constructible_from<MaskView, const std::vector<std::uint8_t>&>);
static_assert(!std::constructible_from<MaskView, std::vector<std::uint8_t>>);
static_assert(std::constructible_from<MaskView, const MaskView>);

template <class V>
concept HasDensity = requires(V&& volume) {
  std::forward<V>(volume).density();
};
template <class V>
concept HasStored = requires(V&& volume) {
  std::forward<V>(volume).stored();
};
static_assert(HasDensity<Volume&> && HasDensity<const Volume&> && !HasDensity<Volume>);
static_assert(HasStored<const Volume&> && !HasStored<Volume> && !HasStored<const Volume>);

template <class Mask>
concept MasksVolume = requires(const Volume& volume, Mask&& mask) {
  volume.density({}, std::forward<Mask>(mask));
};
static_assert(MasksVolume<std::vector<std::uint8_t>&> && !MasksVolume<std::vector<std::uint8_t>>);

template <class Values>
concept FillsGrid = requires(const Grid& grid, Values&& values) {
  grid.density(std::forward<Values>(values));
};
static_assert(FillsGrid<std::vector<float>&> && !FillsGrid<std::vector<float>>);

template <class Values>
concept MakesDensity = requires(Values&& values) {
  DensityGrid{std::forward<Values>(values), {4}, ccvt::Box::unit(1)};
};
static_assert(MakesDensity<const std::vector<float>&> && !MakesDensity<std::vector<float>>);

// The values of four cells in a row, from how many points each gets.
template <class Values>
std::vector<int> counts_of(const Values& values) {
  DensityGrid grid{
      values, {4}, ccvt::Box{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, 4)}};
  const auto points = ccvt::sample_density<double>(grid, 1000);
  std::vector<int> counts(4);
  for (Eigen::Index p = 0; p < 1000; ++p) ++counts[static_cast<std::size_t>(points(0, p))];
  return counts;
}

}  // namespace

TEST_SUITE_BEGIN("density");

TEST_CASE_TEMPLATE("values lie in vectors of Eigen's as well", Number, float, double, int,
                   std::uint8_t, std::int64_t) {
  const std::vector<int> expected{0, 200, 300, 500};
  Eigen::Matrix<Number, Eigen::Dynamic, 1> vector(4);
  vector << 0, 2, 3, 5;
  CHECK(counts_of(vector) == expected);
  const Eigen::Array<Number, 2, 2> square = vector.array().reshaped(2, 2);
  CHECK(counts_of(square) == expected);
  const Eigen::Matrix<Number, 1, Eigen::Dynamic> row = vector.transpose();
  CHECK(counts_of(row) == expected);
  CHECK(counts_of(std::vector<Number>{0, 2, 3, 5}) == expected);
}

TEST_CASE("a part of a matrix that lies in memory with gaps is refused") {
  const Eigen::MatrixXf matrix = Eigen::MatrixXf::Ones(3, 4);
  CHECK(message_of([&] { (void)GridValues(matrix.row(1)); }).find("has gaps in memory") !=
        std::string::npos);
  CHECK(message_of([&] { (void)GridValues(matrix.topRows(2)); }).find("has gaps in memory") !=
        std::string::npos);
  const GridValues columns(matrix.middleCols(1, 2));
  CHECK(std::get<std::span<const float>>(columns).size() == 6);
  CHECK(std::get<std::span<const float>>(columns).data() == matrix.data() + 3);
}

TEST_SUITE_END();
