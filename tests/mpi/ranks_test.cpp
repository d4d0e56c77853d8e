// Run by several ranks: each compares what they get together with what one process gets.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/domain.h"
#include "ccvt/mpi.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/message.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::PointsView;
using ccvt::Problem;
using ccvt::test::message_of;

namespace {

/// Of so many points, those of a rank: not as many for each, and for some none.
struct Share {
  Index first;
  Index end;
  Share(const ccvt::Ranks& ranks, Index points) {
    const auto place = [&](int rank) {
      if (rank == 0 || rank == ranks.count()) return rank == 0 ? 0 : points;
      const double part = static_cast<double>(rank) / ranks.count();
      return static_cast<Index>(points * part * part);
    };
    first = place(ranks.rank());
    end = place(ranks.rank() + 1);
  }
};

template <class Scalar>
struct Case {
  int dimension;
  Index points;
  Index sites;
  Domain domain;
  Options options;
  std::vector<Index> capacities = {};
  ccvt::Points<Scalar> initial_sites = {};
  ccvt::Points<Scalar> fixed_sites = {};
  ccvt::Distribution distribution = ccvt::Distribution::jittered;
};

template <class Scalar>
void set_up(const Case<Scalar>& given, Problem<Scalar>& problem) {
  problem.set_domain(given.domain);
  if (!given.capacities.empty()) problem.set_capacities(given.capacities);
  if (given.initial_sites.size() > 0) problem.set_initial_sites(given.initial_sites);
  if (given.fixed_sites.size() > 0) problem.set_fixed_sites(given.fixed_sites);
}

template <class Scalar>
void compare(const Case<Scalar>& given) {
  CAPTURE(given.dimension);
  CAPTURE(sizeof(Scalar));
  const ccvt::Points<Scalar> points =
      ccvt::sample_uniform<Scalar>(Box::unit(given.dimension), given.points, 5, given.distribution);
  Problem<Scalar> alone(points, given.sites);
  set_up(given, alone);
  const auto expected = ccvt::tessellate(alone, given.options);

  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  const Share share(ranks, given.points);
  const auto own = ccvt::sample_uniform_part<Scalar>(Box::unit(given.dimension), given.points,
                                                     share.first, share.end, 5, given.distribution);
  CHECK((own == points.middleCols(share.first, share.end - share.first)));
  Problem<Scalar> together(ranks, ccvt::view_points(own), given.sites);
  set_up(given, together);
  const auto result = ccvt::tessellate(together, given.options);

  CHECK((result.sites == expected.sites));
  CHECK((std::equal(result.owners.begin(), result.owners.end(),
                    expected.owners.begin() + share.first, expected.owners.begin() + share.end)));
  CHECK(result.summary.energy == expected.summary.energy);
  CHECK(result.summary.iterations == expected.summary.iterations);
  CHECK(result.summary.swaps == expected.summary.swaps);
  CHECK(result.summary.pairs == expected.summary.pairs);
}

}  // namespace

TEST_CASE("ranks: the bits of one process") {
  for (const int threads : {1, 2}) {
    CAPTURE(threads);
    Options options;
    options.threads = threads;
    for (const int dimension : {1, 2, 3, 4}) {
      const Box box = Box::unit(dimension);
      compare<float>({dimension, 20000, 301, Domain::periodic(box), options});
      compare<double>({dimension, 20000, 150, Domain::euclidean(box), options});
    }
  }
}

TEST_CASE("ranks: points that come in several parts") {
  const Box box = Box::unit(2);
  for (const auto distribution : {ccvt::Distribution::white, ccvt::Distribution::jittered,
                                  ccvt::Distribution::square, ccvt::Distribution::hexagonal}) {
    Options options;
    options.max_iterations = 20;
    compare<float>({2, 700001, 2000, Domain::periodic(box), options, {}, {}, {}, distribution});
  }
}

TEST_CASE("ranks: unequal capacities, sites that are given, and partly periodic domains") {
  const Index sites = 400;
  std::vector<Index> capacities(sites, 1);
  Index points = 0;
  for (Index s = 0; s < sites; ++s) {
    capacities[static_cast<std::size_t>(s)] += s % 7 == 0 ? 3 * s : s % 50;
    points += capacities[static_cast<std::size_t>(s)];
  }
  const Box box = Box::unit(2);
  const ccvt::Points<double> given = ccvt::sample_uniform<double>(box, sites, 9);
  const Domain partly = Domain::periodic(box, {true, false});
  compare<double>({2, points, sites, {}, {}, capacities});
  compare<double>({2, points, sites, partly, {}, capacities, given});
  compare<double>({2, points, sites, partly, {}, capacities, {}, given.leftCols(30)});
}

TEST_CASE("ranks: every way to choose and to swap pairs") {
  const Box box = Box::unit(2);
  for (const auto pairs : {ccvt::PairSelection::meeting, ccvt::PairSelection::all}) {
    for (const int cached_passes : {0, 3}) {
      for (const int tile_sites : {1, 7, 64}) {
        Options options;
        options.pairs = pairs;
        options.cached_passes = cached_passes;
        options.tile_sites = tile_sites;
        options.multilevel = tile_sites != 7;
        compare<float>({2, 6000, 120, Domain::periodic(box), options});
      }
    }
  }
}

TEST_CASE("ranks: cells that are divided into patches") {
  Options options;
  options.descent_points = 0;
  compare<float>({2, 60 * 4000, 60, Domain::periodic(Box::unit(2)), options});
}

TEST_CASE("ranks: many points a site") {
  for (const int threads : {1, 2}) {
    Options options;
    options.threads = threads;
    for (const int dimension : {2, 3}) {
      const Box box = Box::unit(dimension);
      compare<float>({dimension, 90'000, 150, Domain::periodic(box), options});
      compare<double>({dimension, 90'000, 40, Domain::euclidean(box), options});
    }
    options.until = ccvt::Until::blue_noise;
    compare<float>({2, 90'000, 100, Domain::periodic(Box::unit(2)), options});
    options.descent_points = 1;
    compare<double>({3, 1800, 150, {}, options});
  }
}

TEST_CASE("ranks: fewer tiles than ranks, and ranks without points") {
  compare<double>({2, 40, 3, {}, {}});
  compare<double>({2, 1, 1, {}, {}});
  compare<double>({2, 5, 5, {}, {}});
}

TEST_CASE("ranks: what is wrong on one is thrown on all") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  ccvt::Points<double> own = ccvt::sample_uniform<double>(Box::unit(2), 50, 3);
  if (ranks.rank() == ranks.count() - 1) own(1, 7) = 2;
  const std::string number = std::to_string(50 * (ranks.count() - 1) + 7);
  Problem<double> problem(ranks, ccvt::view_points(own), 4);
  CHECK(message_of([&] { problem.set_domain(Domain::euclidean(Box::unit(2))); }) ==
        "points: coordinate 1 of points[" + number + "] is 2: it must lie in the box, from 0 to 1");
  own.setConstant(0.5);
  if (ranks.rank() == ranks.count() - 1) own(0, 7) = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of([&] {
          Problem<double>(ranks, ccvt::view_points(own), 4);
        }).starts_with("points: coordinate 0 of points[" + number + "] is nan: "));
  CHECK(message_of([&] { Problem<double>(ranks, ccvt::view_points(own.leftCols(0)), 4); }) ==
        "points: there are none");
  if (ranks.count() == 1) return;
  const ccvt::Points<double> other = own.topRows(ranks.rank() == 1 ? 1 : 2).leftCols(3);
  CHECK(message_of([&] { Problem<double>(ranks, ccvt::view_points(other), 4); }) ==
        "ranks: rank 1 has points of 1 dimensions for 4 sites, rank 0 has 2 for 4: they must be "
        "equal");
}

TEST_CASE("ranks: what several cannot do is refused") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  if (ranks.count() == 1) return;
  const ccvt::Points<double> own = ccvt::sample_uniform<double>(Box::unit(2), 6000, 3);
  Problem<double> problem(ranks, ccvt::view_points(own), 4);
  CHECK(message_of([&] {
          ccvt::tessellate(problem, {.initialization = ccvt::Initialization::random});
        }).starts_with("options.initialization: is random, "));
  CHECK(message_of([&] { problem.set_initial_owners({0}); }) ==
        "initial_owners: there are 1 for 6000 points: there must be one per point");
}

TEST_CASE("ranks: all end when one is cancelled, or the time is over") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  const ccvt::Points<float> own =
      ccvt::sample_uniform<float>(Box::unit(2), 100000 / ranks.count(), 3);
  Problem<float> problem(ranks, ccvt::view_points(own), 1000);
  Options options;
  int iterations = 0;
  options.on_iteration = [&](const ccvt::IterationRecord&) {
    return ++iterations < 3 || ranks.rank() != ranks.count() - 1;
  };
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == ccvt::Termination::cancelled);
  CHECK(result.summary.iterations == 3);
  CHECK(std::none_of(result.owners.begin(), result.owners.end(), [](Index o) { return o < 0; }));
  options.on_iteration = {};
  options.time_limit = 1e-9;
  CHECK(ccvt::tessellate(problem, options).summary.termination == ccvt::Termination::time_limit);
}

TEST_CASE("ranks: codebooks and codes are those of one process") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  const Index vectors = 12'000;
  for (const int dimension : {3, 8}) {
    const ccvt::Points<float> all =
        ccvt::sample_uniform<float>(Box::unit(dimension), vectors, 3, ccvt::Distribution::white);
    const Share share(ranks, vectors);
    const PointsView<float> own{all.data() + share.first * std::ptrdiff_t{dimension}, dimension,
                                share.end - share.first, dimension};
    const ccvt::CodebookOptions options{
        .method = dimension == 3 ? ccvt::CodebookMethod::lloyd : ccvt::CodebookMethod::exact,
        .max_iterations = 12,
        .threads = 1};
    const auto expected = ccvt::train_codebook(all, 300, options);
    const auto result = ccvt::train_codebook(ranks, own, 300, options);
    const std::vector<Index> codes(expected.codes.begin() + share.first,
                                   expected.codes.begin() + share.end);
    CHECK(result.codes == codes);
    CHECK(result.codebook.codewords() == expected.codebook.codewords());
    CHECK(result.codebook.weights() == expected.codebook.weights());
    CHECK(result.summary.energy == expected.summary.energy);
    CHECK(result.summary.iterations == expected.summary.iterations);
    const std::vector<Index> nearest = expected.codebook.encode(all);
    const std::vector<Index> own_nearest = result.codebook.encode(ranks, own);
    CHECK(std::equal(own_nearest.begin(), own_nearest.end(), nearest.begin() + share.first));
    CHECK(result.codebook.distortion(ranks, own, own_nearest) ==
          expected.codebook.distortion(all, nearest));
  }
}

TEST_CASE("a message that is too long for MPI fails on all ranks, which go on") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  const std::byte one{7};
  // Of so many bytes only the number is looked at.
  const std::span<const std::byte> huge(&one, std::size_t{1} << 40U);
  std::string message;
  try {
    (void)ranks.gather(ranks.rank() + 1 == ranks.count() ? huge : std::span(&one, 1));
  } catch (const ccvt::MpiFailure& failure) {
    message = failure.message;
  }
  CHECK(message == "ranks: a message has more than 256 GB");
  const std::vector<ccvt::Ranks::Bytes> come = ranks.gather(std::span(&one, 1));
  CHECK(come == std::vector<ccvt::Ranks::Bytes>(static_cast<std::size_t>(ranks.count()), {one}));
}

TEST_CASE("a message of any length arrives: whole pieces, and what is left, if any") {
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  constexpr std::size_t kPiece = std::size_t{1} << 30U;
  for (const std::size_t size : {std::size_t{0}, kPiece, kPiece + 5}) {
    CAPTURE(size);
    if (ranks.rank() == 0 && ranks.count() > 1) {
      ccvt::Ranks::Bytes message(size, std::byte{3});
      if (size > 0) message.back() = std::byte{4};
      ranks.send(1, std::move(message));
      ranks.send(1, {std::byte{5}});
    }
    if (ranks.rank() == 1) {
      const ccvt::Ranks::Bytes message = ranks.receive(0);
      REQUIRE(message.size() == size);
      if (size > 0) {
        CHECK(std::count(message.begin(), message.end(), std::byte{3}) == std::ssize(message) - 1);
        CHECK(message.back() == std::byte{4});
      }
      CHECK(ranks.receive(0) == ccvt::Ranks::Bytes{std::byte{5}});
    }
  }
}

TEST_CASE("an exception does not wait for who has not taken a message yet") {
  auto ranks = std::make_unique<ccvt::MpiRanks>(MPI_COMM_WORLD);
  if (ranks->count() == 1) return;
  const int rank = ranks->rank();
  const ccvt::Ranks::Bytes large(std::size_t{1} << 24U, std::byte{5});
  ccvt::Ranks::Bytes come;
  // The first is gone before the second takes what it has sent.
  const auto leave = [&] {
    try {
      const auto own = std::move(ranks);
      if (rank == 0) own->send(1, large);
      if (rank == 1) come = own->receive(0);
      throw std::runtime_error("for a test");
    } catch (const std::runtime_error& error) {
      CHECK(error.what() == std::string("for a test"));
    }
  };
  if (rank == 0) leave();
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank > 0) leave();
  MPI_Barrier(MPI_COMM_WORLD);
  CHECK((rank != 1 || come == large));
}
