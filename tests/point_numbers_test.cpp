// Points of all ranks are numbered beyond what 32 bits tell apart; those of one process are not.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "ccvt/sampling.h"
#include "parallel/buffer.h"
#include "parallel/bytes.h"
#include "random.h"
#include "relax/cells.h"
#include "relax/home.h"
#include "relax/initialize.h"
#include "relax/levels.h"
#include "relax/own_points.h"
#include "relax/point_order.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/npy.h"
#include "support/thread_ranks.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Filling;
using ccvt::Index;
using ccvt::JoiningPoints;
using ccvt::Metric;
using ccvt::OwnPoints;
using ccvt::PointNumber;
using ccvt::PointOfAll;
using ccvt::PointOrder;
using ccvt::Points;
using ccvt::Ranks;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::Tiling;
using namespace ccvt::test;

namespace {

constexpr std::int64_t kFar = 2 * PointOrder::kMostPointsOfFour + 12345;

/// The points of the cells of some sites, less `before`; -1 ends each cell.
template <class Scalar>
std::vector<std::int64_t> listed(const Cells<Scalar>& cells,
                                 const ccvt::NumberRange<SiteNumber>& sites, std::int64_t before) {
  std::vector<std::int64_t> numbers;
  for (const SiteNumber s : sites) {
    for (const PointOfAll p : cells.points(s)) numbers.push_back(p.index() - before);
    numbers.push_back(-1);
  }
  return numbers;
}

template <class Scalar>
SiteState sites_of(const Points<Scalar>& places) {
  SiteState sites(static_cast<int>(places.rows()), places.cols());
  for (const SiteNumber s : sites.all()) {
    for (Index d = 0; d < places.rows(); ++d) {
      sites.at(s)[d] = static_cast<double>(places(d, s.index()));
    }
  }
  return sites;
}

}  // namespace

TEST_SUITE("point_numbers") {
  TEST_CASE("an order holds numbers of four bytes, and of five where there are more points") {
    struct {
      std::int64_t points;
      std::size_t bytes;
    } const cases[] = {{1000, 4},
                       {PointOrder::kMostPointsOfFour, 4},
                       {PointOrder::kMostPointsOfFour + 1, 5},
                       {PointOrder::kMostPointsOfFour << 8, 5}};
    for (const auto& c : cases) {
      const std::int64_t points = c.points;
      const std::size_t bytes = c.bytes;
      CAPTURE(points);
      constexpr std::size_t kPlaces = 100;
      PointOrder order(kPlaces, 0, kPlaces, points);
      PointOrder other(kPlaces, 0, kPlaces, points);
      CHECK(order.bytes() == bytes);
      ccvt::Random random(7);
      std::vector<std::int64_t> expected;
      for (std::size_t k = 0; k < kPlaces; ++k) {
        const auto below = static_cast<std::int64_t>(random.next() % 1000);
        expected.push_back(std::max(points - 1 - below, std::int64_t{0}));
        order.set(k, PointOfAll(expected.back()));
        other.set(k, PointOfAll(0));
      }
      const auto holds = [&](const PointOrder& held) {
        for (std::size_t k = 0; k < kPlaces; ++k) {
          if (held[k].index() != expected[k]) return false;
        }
        return true;
      };
      CHECK(holds(order));
      CHECK_FALSE(holds(other));
      order.exchange(3, 97);
      std::swap(expected[3], expected[97]);
      CHECK(holds(order));
      other.copy(order.view(0, kPlaces), 0);
      CHECK(holds(other));
      ccvt::ByteWriter out;
      order.write(out, 10, 50);
      CHECK(out.bytes.size() == 50 * bytes);
      for (std::size_t k = 10; k < 60; ++k) other.set(k, PointOfAll(0));
      CHECK_FALSE(holds(other));
      ccvt::ByteReader in(out.bytes);
      other.read(in, 10, 50);
      CHECK(in.done());
      CHECK(holds(other));
    }
  }

  TEST_CASE("cells hold the same points, however large their numbers are") {
    const std::vector<Index> sizes{5, 3, 9};
    const auto points = make_points<float>(Layout::random, uneven_box(2), 17, 1);
    const auto all = ccvt::sites_below(sizes.size());
    std::vector<std::vector<std::int64_t>> results;
    for (const std::int64_t first : {std::int64_t{0}, kFar}) {
      Cells<float> cells(2, sizes, all, first + 17);
      Cells<float> copy(2, sizes, all, first + 17);
      std::int64_t p = 0;
      for (const SiteNumber s : cells.sites()) {
        for (Index k = 0; k < cells.size(s); ++k, ++p) {
          cells.put(s, k, PointOfAll(first + p), points.col(p).data());
        }
      }
      cells.exchange(SiteNumber(0), 4, SiteNumber(2), 1);
      cells.copy_within(SiteNumber(1), 0, 2);
      std::vector<PointOfAll> scratch;
      std::vector<float> stream;
      const std::vector<Index> places{8, 0, 7, 1, 6, 2, 5, 3, 4};
      cells.reorder(SiteNumber(2), places, scratch, stream);
      for (const SiteNumber s : cells.sites()) copy.copy_points(cells, s);
      results.push_back(listed(copy, all, first));

      ccvt::ByteWriter saved;
      ccvt::ByteWriter written;
      for (const SiteNumber s : cells.sites()) {
        const std::size_t before = saved.bytes.size();
        cells.save(saved, s);
        CHECK(saved.bytes.size() - before == cells.saved_bytes(s));
        cells.write(written, s, cells.size(s));
      }
      Cells<float> loaded(2, sizes, all, first + 17);
      ccvt::ByteReader from_saved(saved.bytes);
      for (const SiteNumber s : cells.sites()) loaded.load(from_saved, s, first + 17);
      CHECK(listed(loaded, all, first) == results.back());
      const OwnPoints<float> own(ccvt::view_points(points), first);
      for (const SiteNumber s : cells.sites()) {
        loaded.fill(s, [&](PointOfAll q) { return own[q]; });
      }
      Cells<float> read(2, sizes, all, first + 17);
      ccvt::ByteReader from_written(written.bytes);
      for (const SiteNumber s : cells.sites()) read.read(from_written, s, cells.size(s));
      CHECK(listed(read, all, first) == results.back());
      for (const SiteNumber s : cells.sites()) {
        const auto count = static_cast<std::size_t>(cells.size(s)) * 2;
        CHECK(std::equal(cells.block(s), cells.block(s) + count, loaded.block(s)));
        CHECK(std::equal(cells.block(s), cells.block(s) + count, read.block(s)));
      }
      // The last point is one too many.
      Cells<float> damaged(2, sizes, all, first + 17);
      ccvt::ByteReader again(saved.bytes);
      const auto load = [&] {
        for (const SiteNumber s : cells.sites()) damaged.load(again, s, first + 16);
      };
      CHECK_THROWS_AS(load(), ccvt::Damaged);
    }
    CHECK(results[0] == results[1]);
  }

  TEST_CASE("points join by their numbers of this process, wherever these begin") {
    constexpr std::size_t kStart = std::size_t{1} << 33;
    constexpr std::size_t kBlock = JoiningPoints::kBlock;
    // From the middle of one block to that of another, within one, and whole ones.
    const std::size_t begins[] = {5 * kBlock + 100, 7 * kBlock + 3, 2 * kBlock, 10 * kBlock};
    const std::size_t ends[] = {8 * kBlock + 5, 7 * kBlock + 900, 4 * kBlock, 10 * kBlock + 77};
    for (const bool far_start : {true, false}) {
      CAPTURE(far_start);
      const std::size_t start = far_start ? kStart : 0;
      const std::size_t offset = far_start ? 0 : kStart;
      for (std::size_t k = 0; k < std::size(begins); ++k) {
        CAPTURE(k);
        auto joining = JoiningPoints::between(start, kStart + 10 * kBlock + 77);
        joining.keep_own(start + offset + begins[k], start + offset + ends[k]);
        CHECK(joining.own_begin().index() == static_cast<std::int64_t>(kStart + begins[k]));
        CHECK(joining.end().index() == static_cast<std::int64_t>(kStart + 10 * kBlock + 77));
        Index next = 0;
        std::size_t parts = 0;
        joining.for_own_parts(kBlock, 3 * kBlock, Arena(2),
                              [&](std::span<const PointNumber> points) {
                                ++parts;
                                for (const PointNumber p : points) REQUIRE(p.index() == next++);
                              });
        CHECK(next == static_cast<Index>(ends[k] - begins[k]));
        CHECK((parts > 1) == (k == 0 || k == 2));
      }
    }
  }

  /// Each rank's points join those of all; `before`: how many points have lower numbers than these.
  template <class Scalar>
  void check_joining(int dimension, bool periodic, const std::vector<Index>& counts) {
    CAPTURE(dimension);
    CAPTURE(periodic);
    const Box box = uneven_box(dimension);
    const Metric metric(dimension, periodic ? Domain::periodic(box) : Domain());
    const Index count = sum_of(counts);
    const auto points = make_points<Scalar>(Layout::clusters, box, count, 3);
    const SiteState sites = sites_of(make_points<Scalar>(Layout::random, box, 60, 4));
    const std::vector<Index> capacities = ccvt::equal_capacities(count, 60);
    const Tiling tiles(capacities.size(), 4);

    const auto all = JoiningPoints::between(0, static_cast<std::size_t>(count));
    const auto joined_by = [&](const Arena& arena) {
      Cells<Scalar> cells(dimension, capacities);
      Filling<Scalar> filling(cells, ccvt::view_points(points), tiles);
      ccvt::join_balanced(metric, sites, box, all, {}, arena, filling);
      return listed(cells, cells.sites(), 0);
    };
    const std::vector<std::int64_t> expected = joined_by(Arena(1));
    CHECK(joined_by(Arena(2)) == expected);
    // Points are grouped as for many workers.
    ccvt::Recorder recorder;
    recorder.listen([](const ccvt::Recorder::Loop&) {});
    CHECK(joined_by(Arena(1, nullptr, &recorder)) == expected);

    for (const std::int64_t before : {std::int64_t{0}, kFar}) {
      CAPTURE(before);
      std::vector<std::vector<std::int64_t>> found(counts.size());
      ThreadRanks(static_cast<int>(counts.size())).run([&](Ranks& ranks) {
        const auto r = static_cast<std::size_t>(ranks.rank());
        const Index first = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), 0);
        Tiling tiling = tiles;
        tiling.deal(ranks, capacities);
        auto joining = JoiningPoints::between(static_cast<std::size_t>(before),
                                              static_cast<std::size_t>(before + count));
        joining.keep_own(static_cast<std::size_t>(before + first),
                         static_cast<std::size_t>(before + first + counts[r]));
        const ccvt::PointsView<Scalar> own{points.col(0).data() + std::ptrdiff_t{first} * dimension,
                                           dimension, counts[r], dimension};
        Cells<Scalar> here(dimension, capacities, tiling.own_sites(), before + count);
        Filling<Scalar> filled(here, OwnPoints<Scalar>(own, before + first), tiling);
        Arena arena(1);
        arena.divide_among(&ranks);
        ccvt::join_balanced(metric, sites, box, joining, {}, arena, filled);
        found[r] = listed(here, tiling.own_sites(), before);
      });
      std::vector<std::int64_t> joined;
      for (const auto& part : found) joined.insert(joined.end(), part.begin(), part.end());
      CHECK(joined == expected);
    }
  }

  TEST_CASE("points of several ranks join as those of one, however large their numbers are") {
    for (const int dimension : {1, 2, 3, 4}) {
      check_joining<float>(dimension, dimension % 2 == 0, {900, 0, 1300, 800});
      check_joining<double>(dimension, dimension % 2 == 1, {1, 1999});
    }
  }

  TEST_CASE("points come home in the same order, however few numbers are told apart at once") {
    const std::vector<Index> counts{400, 0, 700, 1, 300};
    const Index count = sum_of(counts);
    const Box box = uneven_box(2);
    const Metric metric(2, Domain());
    const auto points = make_points<float>(Layout::random, box, count, 3);
    const SiteState sites = sites_of(make_points<float>(Layout::random, box, 20, 4));
    // Room for all at each site, so that none waits.
    const std::vector<Index> capacities(20, count);
    std::vector<std::vector<std::int64_t>> results;
    std::vector<std::string> orders;
    for (const std::int64_t most : {std::int64_t{1}, std::int64_t{700}, std::int64_t{1100},
                                    std::int64_t{count}, std::int64_t{INT32_MAX}}) {
      CAPTURE(most);
      std::vector<std::vector<std::int64_t>> found(counts.size());
      std::vector<std::string> in_order(counts.size());
      ThreadRanks(static_cast<int>(counts.size())).run([&](Ranks& ranks) {
        const auto r = static_cast<std::size_t>(ranks.rank());
        const Index first = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), 0);
        Tiling tiling(capacities.size(), 2);
        tiling.deal(ranks, capacities);
        const ccvt::PointsView<float> own{points.data() + std::ptrdiff_t{first} * 2, 2, counts[r],
                                          2};
        Cells<float> cells(2, capacities, tiling.own_sites(), kFar + count);
        Filling<float> filling(cells, OwnPoints<float>(own, kFar + first), tiling);
        ccvt::Arrivals arrivals(ranks, PointOfAll(kFar + first), PointOfAll(kFar + count), 20);
        const ccvt::NearestSites<float> nearest(metric, sites, box);
        ccvt::NearestSites<float>::Found<2> near;
        std::vector<PointNumber> which;
        for (Index p = 0; p < counts[r]; ++p) which.emplace_back(p);
        nearest.find<2>(own, which, Arena(1), near);
        ccvt::add_at_home<2>(near, Arena(1), filling, arrivals, most);
        for (const SiteNumber s : tiling.own_sites()) {
          in_order[r] += arrivals.in_order(s) ? '1' : '0';
          for (Index k = 0; k < filling.filled[s]; ++k) {
            const std::int64_t p = cells.point(s, k).index() - kFar;
            found[r].push_back(p);
            float x[2];
            cells.get(s, k, x);
            REQUIRE((x[0] == points(0, p) && x[1] == points(1, p)));
          }
          found[r].push_back(-1);
        }
      });
      auto& all = results.emplace_back();
      for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
      CHECK(all.size() == static_cast<std::size_t>(count) + 20);
      CHECK(all == results.front());
      std::string& order = orders.emplace_back();
      for (const std::string& part : in_order) order += part;
      CHECK(order == orders.front());
    }
  }

  TEST_CASE("more points than 32 bits number are drawn in parts, each where it belongs") {
    constexpr std::int64_t kCount = std::int64_t{1} << 33;
    constexpr std::int64_t kFirst = kCount - 70000;
    // In one dimension: the p-th of all cells has the p-th point of all.
    const Box line = Box::unit(1);
    for (const auto distribution : {ccvt::Distribution::jittered, ccvt::Distribution::square}) {
      const Points<double> points = ccvt::sample_uniform_part<double>(
          line, kCount, kFirst, kFirst + 50000, 3, distribution, 2);
      for (Index k = 0; k < 50000; ++k) {
        const double cell = points(0, k) * static_cast<double>(kCount);
        REQUIRE(static_cast<std::int64_t>(cell) == kFirst + k);
      }
    }
    // Parts are of the same whole.
    for (const int dimension : {2, 3}) {
      const Box box = uneven_box(dimension);
      for (const auto distribution :
           {ccvt::Distribution::white, ccvt::Distribution::jittered, ccvt::Distribution::square}) {
        const auto draw = [&](std::int64_t first, std::int64_t end) {
          return ccvt::sample_uniform_part<float>(box, kCount, first, end, 3, distribution, 2);
        };
        const Points<float> whole = draw(kFirst, kCount);
        CHECK(draw(kFirst, kFirst + 5000) == whole.leftCols(5000));
        CHECK(draw(kFirst + 5000, kCount) == whole.rightCols(65000));
        const auto of_box = [&](int d) {
          return (whole.row(d).array() >= static_cast<float>(box.lower[d])).all() &&
                 (whole.row(d).array() < static_cast<float>(box.upper[d])).all();
        };
        for (int d = 0; d < dimension; ++d) CHECK(of_box(d));
      }
    }
    CHECK(message_of([&] { ccvt::sample_uniform_part<float>(line, kCount, 5, kCount); }) ==
          "end: 8589934587 points are asked for: at most 2147483647 are drawn at once");
    constexpr std::int64_t kMost = std::int64_t{1} << 40;
    CHECK(ccvt::sample_uniform_part<double>(Box::unit(2), kMost, kMost - 5, kMost).cols() == 5);
    CHECK(message_of([&] { ccvt::sample_uniform_part<double>(line, kMost + 1, 0, 5); }) ==
          "count: is 1099511627777, but must be at most 1099511627776");
  }

  TEST_CASE("capacities sum to more than 32 bits count") {
    constexpr std::int64_t kCount = (std::int64_t{1} << 33) + 3;
    const std::vector<Index> capacities = ccvt::equal_capacities(kCount, 8);
    CHECK(capacities.front() == (1 << 30) + 1);
    CHECK(capacities.back() == 1 << 30);
    ccvt::validate_capacities(capacities, kCount);
    CHECK(message_of([&] { ccvt::validate_capacities(capacities, kCount - 1); }) ==
          "capacities: they sum to 8589934595, but there are 8589934594 points: the two must be "
          "equal");
    CHECK(message_of([] { ccvt::equal_capacities(kCount, 4); }) ==
          "sites: 4 for 8589934595 points: a site owns at most 2147483647");
    CHECK(ccvt::equal_capacities(INT32_MAX, 1) == std::vector<Index>{INT32_MAX});
    CHECK(ccvt::equal_capacities(std::int64_t{2} * INT32_MAX - 1, 2) ==
          std::vector<Index>{INT32_MAX, INT32_MAX - 1});
    CHECK_THROWS_AS(ccvt::equal_capacities(std::int64_t{2} * INT32_MAX + 1, 2), ccvt::InvalidInput);
    const Cells<float> cells(2, capacities, ccvt::sites_between(8, 8), kCount);
    CHECK(cells.point_count() == kCount);
    CHECK(cells.sizes() == capacities);
    CHECK(Tiling::of_points(8, kCount, 1024).sites_per_tile() == 1);
  }

  TEST_CASE("memory of which a part is used may be more than the machine has") {
    constexpr std::size_t kBytes = std::size_t{1} << 39;
    constexpr std::size_t kFirst = kBytes / 3;
    constexpr std::size_t kUsed = std::size_t{1} << 20;
    ccvt::Buffer<std::uint8_t> buffer(kBytes, kFirst, kUsed);
    for (std::size_t k = 0; k < kUsed; ++k) buffer[kFirst + k] = static_cast<std::uint8_t>(k);
    ccvt::Buffer<std::uint8_t> moved = std::move(buffer);
    CHECK(moved.size() == kBytes);
    CHECK(moved[kFirst + kUsed - 1] == 255);
  }

  TEST_CASE("of a file of more points than one process has, each reads its part") {
    const TemporaryDirectory directory;
    constexpr std::uint64_t kRows = 2200000000;
    const auto sparse = [&](const std::string& name, const std::string& head, std::uint64_t row) {
      const std::filesystem::path path = directory.path() / name;
      put(path, head);
      std::filesystem::resize_file(path, (name == "many.npy" ? head.size() : 0) + kRows * row);
      return path;
    };
    const std::string npy = npy_file("<f4", "(2200000000, 1)", "");
    const std::filesystem::path path = sparse("many.npy", npy, 4);
    CHECK(ccvt::inspect_points(path).count == kRows);
    const ccvt::ReadOptions part{.first_row = kRows - 3, .end_row = kRows - 1};
    CHECK(ccvt::inspect_points(path, part).count == 2);
    CHECK(ccvt::read_points<float>(path, part) == Points<float>::Zero(1, 2));
    CHECK(ccvt::MappedPoints<float>(path, part).view().count == 2);
    const std::string refused =
        path.string() +
        ": has 2200000000 points to be read; at most 2147483647 are supported at once";
    CHECK(message_of([&] { ccvt::read_points<float>(path); }) == refused);
    CHECK(message_of([&] { ccvt::MappedPoints<float>{path}; }) == refused);
    // Vectors of two bytes each, of whose dimensions the first is read, and those of the part.
    const std::filesystem::path vectors = sparse("many.bvecs", std::string("\2\0\0\0", 4), 6);
    CHECK(ccvt::inspect_points(vectors).count == kRows);
    CHECK(message_of([&] { ccvt::read_points<float>(vectors, part); }) ==
          vectors.string() +
              ": vector 2199999997 has 0 dimensions, but vector 0 has 2; all need the "
              "same number");
  }

}  // TEST_SUITE
