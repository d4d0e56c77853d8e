// Run by several ranks: each compares what they get together with what one process gets.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/mpi.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::PointsView;
using ccvt::Problem;

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
};

template <class Scalar>
void compare(const Case<Scalar>& given) {
  const ccvt::Points<Scalar> points =
      ccvt::sample_uniform<Scalar>(Box::unit(given.dimension), given.points, 5);
  const auto set_up = [&](Problem<Scalar>& problem) {
    problem.set_domain(given.domain);
    if (!given.capacities.empty()) problem.set_capacities(given.capacities);
  };
  Problem<Scalar> alone(points, given.sites);
  set_up(alone);
  const auto expected = ccvt::tessellate(alone, given.options);

  CAPTURE(sizeof(Scalar));
  ccvt::MpiRanks ranks(MPI_COMM_WORLD);
  const Share share(ranks, given.points);
  const ccvt::Points<Scalar> own = points.middleCols(share.first, share.end - share.first);
  Problem<Scalar> together(ranks, ccvt::view_points(own), given.sites);
  set_up(together);
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
      CAPTURE(dimension);
      const Box box = Box::unit(dimension);
      compare<float>({dimension, 20000, 301, Domain::periodic(box), options});
      compare<double>({dimension, 20000, 150, Domain::euclidean(box), options});
    }
  }
}
