// Densities of which each of several ranks, which are threads here, has some layers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/volume.h"
#include "sampling/density_parts.h"
#include "support/files.h"
#include "support/message.h"
#include "support/thread_ranks.h"
#include "support/volumes.h"

using ccvt::DensityGrid;
using ccvt::DensityLayers;
using ccvt::DensitySampling;
using ccvt::Grid;
using ccvt::Index;
using ccvt::Interpolation;
using ccvt::LayerRange;
using ccvt::Ranks;
using ccvt::ValueMap;
using ccvt::Volume;
using ccvt::VolumeOptions;
using ccvt::VolumeSamples;
using ccvt::test::message_of;
using ccvt::test::messages_of;

namespace {

using Shape = std::vector<std::int64_t>;

/// A field with layers that are empty, and a bright corner.
std::vector<float> field(const Shape& shape) {
  const auto cells =
      std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<std::int64_t>());
  std::vector<float> values;
  for (std::int64_t cell = 0; cell < cells; ++cell) {
    const double at = static_cast<double>(cell) / static_cast<double>(cells);
    const bool bright = at > 0.2 && at < 0.7 && cell % 7 != 0;
    values.push_back(bright ? static_cast<float>(1 + std::cos(20 * at)) : 0.0F);
  }
  values.back() = 100;
  return values;
}

/// What a rank has of a grid; `cells` has the values.
struct Part {
  std::vector<float> values;
  std::vector<std::uint8_t> mask;
  DensityLayers density;

  Part(const DensityGrid& whole, const std::vector<float>& all,
       const std::vector<std::uint8_t>& all_mask, const Ranks& ranks)
      : density{whole, ccvt::layers_of_rank(whole.shape, ranks.rank(), ranks.count())} {
    const auto layers = ccvt::layers_of_rank(whole.shape, 0, 1).end;
    const std::int64_t layer = std::ssize(all) / layers;
    const auto cut = [&](const auto& of_all, auto& own) {
      if (of_all.empty()) return;
      own.assign(of_all.begin() + density.layers.begin * layer,
                 of_all.begin() + density.layers.end * layer);
    };
    cut(all, values);
    cut(all_mask, mask);
    density.grid.values = values;
    density.grid.mask = mask;
  }
};

VolumeOptions volume_options(int threads) {
  VolumeOptions options;
  options.points_per_site = 40;
  options.keep_points = true;
  options.tessellation.threads = threads;
  options.tessellation.seed = 4;
  return options;
}

}  // namespace

TEST_SUITE_BEGIN("ranks");

TEST_CASE(
    "ranks: the layers that they need cover a grid, whole parts each, and one to either side") {
  for (const Shape& shape :
       {Shape{64, 64, 64}, Shape{181, 217, 181}, Shape{5, 4, 3}, Shape{300, 400, 1},
        Shape{1, 70000, 1}, Shape{1, 1, 1}, Shape{9}, Shape{8, 8, 8, 40}}) {
    const ccvt::GridLayers layers(shape, ccvt::level_of_parts(shape));
    for (const int ranks : {1, 2, 3, 7, 64}) {
      std::int64_t covered = 0;
      for (int rank = 0; rank < ranks; ++rank) {
        const LayerRange own = layers.of(rank, ranks);
        const LayerRange needed = ccvt::layers_of_rank(shape, rank, ranks);
        CHECK(own.begin == covered);
        CHECK((own.end % layers.thickness == 0 || own.end == layers.count));
        covered = own.end;
        const bool none = own.begin == own.end;
        if (!none) CHECK(layers.rank_of(own.begin, ranks) == rank);
        if (!none) CHECK(layers.rank_of(own.end - 1, ranks) == rank);
        CHECK(needed.begin == (none || own.begin == 0 ? own.begin : own.begin - 1));
        CHECK(needed.end == (none || own.end == layers.count ? own.end : own.end + 1));
      }
      CHECK(covered == layers.count);
    }
  }
  CHECK(message_of([] {
          (void)ccvt::layers_of_rank(Shape{4, 4}, 2, 2);
        }) == "rank: is 2 of 2: it must hold that 0 <= rank < 2");
  CHECK(message_of([] {
          (void)ccvt::layers_of_rank(Shape{4, 0}, 0, 2);
        }) == "shape: is (4, 0): no entry may be below 1");
  CHECK(message_of([] {
          (void)ccvt::layers_of_rank(Shape{1LL << 40, 1LL << 40}, 0, 2);
        }) == "shape: is (1099511627776, 1099511627776): has 2^63 cells or more");
}

TEST_CASE("ranks: points of a density have the bits of one process") {
  for (const Shape& shape : {Shape{40, 30, 50}, Shape{90, 110}, Shape{5000}, Shape{60, 50, 1},
                             Shape{12, 11, 10, 9}, Shape{1, 1}}) {
    const std::vector<float> values = field(shape);
    std::vector<std::uint8_t> mask(values.size(), 1);
    for (std::size_t i = 0; i < mask.size(); i += 5) mask[i] = mask.size() == 1 ? 1 : 0;
    const Grid grid = Grid::spaced(shape, Eigen::VectorXd::Constant(std::ssize(shape), 0.7).eval(),
                                   Eigen::VectorXd::Constant(std::ssize(shape), 30).eval());
    for (const bool masked : {false, true}) {
      for (const auto interpolation : {Interpolation::constant, Interpolation::linear}) {
        for (const auto sampling : {DensitySampling::stratified, DensitySampling::white}) {
          DensityGrid whole = grid.density(values, interpolation);
          if (masked) whole.mask = mask;
          const Index count = 20011;
          const ccvt::Points<float> expected =
              ccvt::sample_density<float>(whole, count, 9, sampling, 1);
          for (const int ranks : {1, 2, 3, 7}) {
            CAPTURE(shape.size());
            CAPTURE(ranks);
            std::vector<int> same(static_cast<std::size_t>(ranks), 0);
            ThreadRanks(ranks).run([&](Ranks& own) {
              const Part part(whole, values, masked ? mask : std::vector<std::uint8_t>{}, own);
              const auto points = ccvt::sample_density<float>(own, part.density, count, 9, sampling,
                                                              own.rank() % 2 + 1);
              const Index first = static_cast<Index>(std::int64_t{count} * own.rank() / ranks);
              same[static_cast<std::size_t>(own.rank())] =
                  points == expected.middleCols(first, points.cols()) ? 1 : 0;
              if (own.rank() + 1 == ranks) {
                same[static_cast<std::size_t>(own.rank())] *=
                    first + points.cols() == count ? 1 : 0;
              }
            });
            CHECK(std::count(same.begin(), same.end(), 1) == ranks);
          }
        }
      }
    }
  }
}

TEST_CASE("ranks: samples of a volume have the bits of one process, those put back too") {
  const Shape shape{30, 28, 41};
  std::vector<float> values = field(shape);
  // A shell: the centroids of its cells lie inside, where there is nothing.
  for (std::size_t cell = 0; cell < values.size(); ++cell) {
    const double x = static_cast<double>(cell % 30) - 15;
    const double y = static_cast<double>(cell / 30 % 28) - 14;
    const double z = static_cast<double>(cell / 840) - 20;
    const double radius = std::sqrt(x * x + y * y + z * z);
    values[cell] = radius > 10 && radius < 11 ? 1.0F : 0.0F;
  }
  const Grid grid = Grid::spaced(shape, Eigen::Vector3d(1, 1, 1.5), Eigen::Vector3d(7, 0, -9));
  const DensityGrid whole = grid.density(values);
  const VolumeSamples expected = ccvt::sample_volume<float>(whole, 40, volume_options(1));
  CHECK(expected.put_back > 0);
  for (const int count : {1, 2, 3, 7}) {
    CAPTURE(count);
    std::vector<int> same(static_cast<std::size_t>(count), 0);
    ThreadRanks(count).run([&](Ranks& ranks) {
      const Part part(whole, values, {}, ranks);
      const VolumeSamples samples =
          ccvt::sample_volume<float>(ranks, part.density, 40, volume_options(ranks.rank() % 2 + 1));
      const auto first = static_cast<std::ptrdiff_t>(std::int64_t{std::ssize(expected.owners)} *
                                                     ranks.rank() / count);
      same[static_cast<std::size_t>(ranks.rank())] =
          samples.sites.eigen() == expected.sites.eigen() &&
                  samples.capacities == expected.capacities &&
                  samples.weights == expected.weights && samples.radii == expected.radii &&
                  samples.put_back == expected.put_back &&
                  samples.farthest_put_back == expected.farthest_put_back &&
                  samples.summary.energy == expected.summary.energy &&
                  std::equal(samples.owners.begin(), samples.owners.end(),
                             expected.owners.begin() + first) &&
                  samples.points.eigen() ==
                      expected.points.eigen().middleCols(first, std::ssize(samples.owners))
              ? 1
              : 0;
    });
    CHECK(std::count(same.begin(), same.end(), 1) == count);
  }
}

TEST_CASE("ranks: layers of a file's volume, and the densities that maps make of them") {
  const ccvt::test::TemporaryDirectory directory;
  const Shape shape{20, 16, 33};
  std::vector<std::int16_t> numbers;
  for (int cell = 0; cell < 20 * 16 * 33; ++cell) {
    numbers.push_back(static_cast<std::int16_t>(cell * 37 % 1000 - (cell < 5 ? 0 : 100)));
  }
  const std::string bytes =
      ccvt::test::nifti1({20, 16, 33}, 4, 16) + ccvt::test::bytes_of_values(numbers);
  ccvt::test::put(directory / "v.nii", bytes);
  ccvt::test::put(directory / "v.nii.gz", ccvt::test::gzipped(bytes));
  for (const char* const name : {"v.nii", "v.nii.gz"}) {
    const auto path = directory / name;
    const Volume whole = ccvt::read_volume(path);
    for (const LayerRange& layers :
         {LayerRange{0, 33}, {0, 0}, {0, 5}, {7, 20}, {30, 33}, {33, 33}}) {
      const Volume part = ccvt::read_volume(path, {}, layers);
      CHECK(part.grid.shape == Shape{20, 16, layers.end - layers.begin});
      CHECK(part.data == std::vector<std::byte>(whole.data.begin() + layers.begin * 640,
                                                whole.data.begin() + layers.end * 640));
      const Eigen::Vector3d origin =
          whole.grid.origin.eigen() +
          whole.grid.axes.eigen() * Eigen::Vector3d(0, 0, static_cast<double>(layers.begin));
      CHECK((part.grid.origin.eigen() - origin).norm() < 1e-12);
    }
    CHECK(message_of([&] {
            (void)ccvt::read_volume(path, {}, {3, 34});
          }) == "layers: 3 to 34 are asked for, of 33 in " + path.string() +
                    ": it must hold that 0 <= begin <= end <= 33");
    for (const ValueMap& map :
         {ValueMap{.kind = ValueMap::Kind::window, .low = -50, .high = 600},
          ValueMap{.invert = true},
          ValueMap{.kind = ValueMap::Kind::gamma, .gamma = 2, .invert = true}}) {
      std::vector<std::uint8_t> mask(whole.cells(), 0);
      std::fill(mask.begin() + 2000, mask.begin() + 7000, std::uint8_t{1});
      const auto expected = ccvt::sample_density<double>(whole.density(map, mask), 3000, 2);
      ThreadRanks(3).run([&](Ranks& ranks) {
        const auto layers = ccvt::layers_of_rank(shape, ranks.rank(), 3);
        const Volume part = ccvt::read_volume(path, {}, layers);
        const std::vector<std::uint8_t> own(mask.begin() + 320 * layers.begin,
                                            mask.begin() + 320 * layers.end);
        const auto points = ccvt::sample_density<double>(
            ranks, ccvt::density_layers(ranks, whole, part, map, own), 3000, 2);
        CHECK((points == expected.middleCols(1000 * ranks.rank(), 1000)));
      });
    }
  }
}

TEST_CASE("ranks: what is wrong with a density is thrown on all, in the words of one process") {
  const Shape shape{16, 16, 64};
  std::vector<float> values(16 * 16 * 64, 1);
  const Grid grid = Grid::spaced(shape, Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0, 0, 0));
  const auto compare = [&](const DensityGrid& whole, Index sites) {
    const std::string alone =
        message_of([&] { (void)ccvt::sample_volume<float>(whole, sites, volume_options(1)); });
    CHECK(alone != "");
    const std::set<std::string> together = messages_of(3, [&](Ranks& ranks) {
      Part part(whole, values, {}, ranks);
      (void)ccvt::sample_volume<float>(ranks, part.density, sites, volume_options(1));
    });
    CHECK(together == std::set<std::string>{alone});
  };
  compare(grid.density(values), 0);
  values[3000] = -2;
  values[15000] = NAN;
  compare(grid.density(values), 10);
  values.assign(values.size(), 0);
  compare(grid.density(values), 10);
  values.assign(values.size(), 1);
  const auto refused = messages_of(2, [&](Ranks& ranks) {
    Part part(grid.density(values), values, {}, ranks);
    if (ranks.rank() == 1) ++part.density.layers.begin;
    (void)ccvt::sample_density<float>(ranks, part.density, 100);
  });
  REQUIRE(refused.size() == 1);
  CHECK(refused.begin()->starts_with("layers: rank 1 of 2 has "));
  const auto many = messages_of(2, [&](Ranks& ranks) {
    Part part(grid.density(values), values, {}, ranks);
    (void)ccvt::sample_density<float>(ranks, part.density, 4294967295);
  });
  CHECK(many ==
        std::set<std::string>{"count: is 4294967295, but 2 ranks have at most 4294967294 points"});
  const auto of_sites = messages_of(2, [&](Ranks& ranks) {
    Part part(grid.density(values), values, {}, ranks);
    (void)ccvt::sample_volume<float>(ranks, part.density, 1 << 30, volume_options(1));
  });
  REQUIRE(of_sites.size() == 1);
  CHECK(of_sites.begin()->ends_with(" points; at most 4294967294 are supported"));
  const auto cut = messages_of(2, [&](Ranks& ranks) {
    Part part(grid.density(values), values, {}, ranks);
    if (ranks.rank() == 1) part.values.pop_back();
    part.density.grid.values = part.values;
    (void)ccvt::sample_density<float>(ranks, part.density, 100);
  });
  REQUIRE(cut.size() == 1);
  CHECK(cut.begin()->starts_with("layers: "));
}

TEST_CASE("ranks: parts and masks that do not fit a volume are refused") {
  Volume whole;
  whole.grid = Grid::spaced({8, 8, 8}, Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0, 0, 0));
  whole.data.assign(512, std::byte{1});
  const std::vector<std::uint8_t> mask(511, 1);
  Volume other = whole;
  other.slope = 2;
  const auto refused = [&](const Volume& part, const std::vector<std::uint8_t>& own) {
    return messages_of(2, [&](Ranks& ranks) {
      (void)ccvt::density_layers(ranks, whole, ranks.rank() == 1 ? part : whole, {}, own);
    });
  };
  CHECK(refused(other, {}) ==
        std::set<std::string>{"part: its numbers are not of the volume's type and scale"});
  CHECK(refused(whole, mask) ==
        std::set<std::string>{"mask: has 511 entries for 512 cells; needs one for each"});
  CHECK(message_of([&] { (void)whole.greatest(mask); }) ==
        "mask: has 511 entries for 512 cells; needs one for each");
  whole.slope = -2;
  CHECK(whole.greatest(std::vector<std::uint8_t>(512, 0)) ==
        -std::numeric_limits<double>::infinity());
  CHECK(whole.greatest() == -2);
  whole.data.resize(1024);
  CHECK(message_of([&] { (void)whole.greatest(); }) ==
        "volume: has 1024 bytes of data for 512 cells of uint8; needs 512");
}

TEST_SUITE_END();
