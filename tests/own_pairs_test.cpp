// Lists of pairs where several ranks have the tiles: each has those of its own sites, and no more.
#include "schedule/own_pairs.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ccvt/domain.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "random.h"
#include "relax/meeting_pairs.h"
#include "relax/site_graph.h"
#include "schedule/schedule.h"
#include "support/generate.h"
#include "support/thread_ranks.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Buffer;
using ccvt::Domain;
using ccvt::Index;
using ccvt::MeetingPairs;
using ccvt::Metric;
using ccvt::Pair;
using ccvt::Random;
using ccvt::Schedule;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::Tiling;
using namespace ccvt::test;

namespace {

using Pairs = std::vector<Pair>;

/// Calls work(tiling, rank) on so many ranks, of which some may have no tile.
template <class Work>
void on_ranks(int count, Index sites, Index tile_sites, const Work& work) {
  ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
    Tiling tiling(sites, tile_sites);
    tiling.deal(ranks, std::vector<Index>(static_cast<std::size_t>(sites), 5));
    work(tiling, static_cast<std::size_t>(ranks.rank()));
  });
}

Pairs own_of(const Tiling& tiling, const Pairs& all) {
  Pairs own;
  std::copy_if(all.begin(), all.end(), std::back_inserter(own), [&](const Pair& pair) {
    return tiling.is_own(tiling.tile_of(pair.first)) || tiling.is_own(tiling.tile_of(pair.second));
  });
  return own;
}

Pairs sorted(std::span<const Pair> pairs) {
  Pairs in_order(pairs.begin(), pairs.end());
  std::sort(in_order.begin(), in_order.end());
  return in_order;
}

/// Sites at random places of a box, each with a sphere about as large as its cell.
SiteState scattered_sites(const Box& box, Index count) {
  const auto places = make_points<double>(Layout::random, box, count, 3);
  SiteState sites(box.dimension(), count);
  std::copy_n(places.data(), places.size(), sites.position.begin());
  for (double& radius : sites.radius) radius = 0.5 * std::pow(1.0 / count, 1.0 / box.dimension());
  return sites;
}

/// What a list of pairs that meet holds.
struct Pass {
  MeetingPairs::Refreshed done;
  Pairs first;
  Pairs added;
  Pairs gabriel;
  friend bool operator==(const Pass&, const Pass&) = default;
};

/// Some sites go elsewhere, or their cells grow: few, or many.
void disturb(SiteState& sites, const Metric& metric, Random& random, std::size_t how_many) {
  for (std::size_t k = 0; k < how_many; ++k) {
    const SiteNumber s(random.below(sites.count()));
    for (int d = 0; d < metric.dimension(); ++d) {
      sites.at(s)[d] = metric.into_box(sites.at(s)[d] + 0.1 * (random.uniform() - 0.5), d);
    }
    sites.radius[s] *= 1 + 0.5 * random.uniform();
  }
}

}  // namespace

TEST_SUITE_BEGIN("own pairs");

TEST_CASE("own pairs: of those that ranks find, both ranks of each have it, and all can be had") {
  Random random(5);
  constexpr Index kSites = 60;
  Pairs all;
  for (int k = 0; k < 400; ++k) {
    const SiteNumber a(random.below(kSites));
    const SiteNumber b(random.below(kSites));
    if (a != b) all.push_back(Pair::ascending(a, b));
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (const int count : {1, 2, 3, 5}) {
    for (const Index tile_sites : {1, 7, 40}) {  // with 40 there are ranks without a tile
      CAPTURE(count);
      CAPTURE(tile_sites);
      std::vector<Pairs> listed(static_cast<std::size_t>(count));
      std::vector<Pairs> due(listed.size());
      std::vector<Pairs> together(listed.size());
      on_ranks(count, kSites, tile_sites, [&](const Tiling& tiling, std::size_t rank) {
        Pairs found;  // each by the rank of its first site
        for (const Pair& pair : all) {
          if (tiling.is_own(tiling.tile_of(pair.first))) found.push_back(pair);
        }
        Buffer<Pair> given(found.size());
        std::copy(found.begin(), found.end(), given.begin());
        listed[rank] = sorted(ccvt::with_pairs_of_others(tiling, std::move(given)).span());
        due[rank] = own_of(tiling, all);
        const Buffer<Pair> gathered = ccvt::pairs_of_all(tiling, listed[rank]);
        together[rank] = {gathered.begin(), gathered.end()};
      });
      CHECK(listed == due);
      for (const Pairs& each : together) CHECK(each == all);
    }
  }
}

TEST_CASE("own pairs: the schedule of all ranks is that of one process") {
  Random random(8);
  constexpr Index kSites = 90;
  Pairs all;
  for (Index i = 0; i < kSites; ++i) {
    for (Index j = i + 1; j < kSites; ++j) {
      if (j - i < 12 && random.uniform() < 0.7) all.emplace_back(i, j);
    }
  }
  for (const int count : {1, 2, 3, 7}) {
    for (const Index tile_sites : {1, 4, 8}) {
      CAPTURE(count);
      CAPTURE(tile_sites);
      const Schedule alone = ccvt::schedule_pairs(all, Tiling(kSites, tile_sites));
      std::vector<std::size_t> wrong(static_cast<std::size_t>(count), 0);
      std::vector<std::size_t> with_pairs(wrong.size(), 0);
      on_ranks(count, kSites, tile_sites, [&](const Tiling& tiling, std::size_t rank) {
        const Pairs own = own_of(tiling, all);
        const Schedule schedule = ccvt::schedule_own_pairs(own, tiling, Arena(2));
        const auto differ = [&](bool differs) { wrong[rank] += differs ? 1 : 0; };
        differ(schedule.pairs.size() != own.size());
        differ(schedule.batch_begin != alone.batch_begin);
        differ(schedule.tasks.size() != alone.tasks.size());
        for (std::size_t t = 0; t < std::min(schedule.tasks.size(), alone.tasks.size()); ++t) {
          const Schedule::Task& task = schedule.tasks[t];
          const Schedule::Task& same = alone.tasks[t];
          differ(task.a != same.a || task.b != same.b || task.size() != same.size());
          if (!tiling.is_own(task.a) && !tiling.is_own(task.b)) continue;
          const auto here = schedule.pairs_of(task);
          const auto there = alone.pairs_of(same);
          differ(!std::equal(here.begin(), here.end(), there.begin(), there.end()));
          with_pairs[rank] += here.size();
        }
        differ(with_pairs[rank] != own.size());
      });
      CHECK(std::count(wrong.begin(), wrong.end(), 0) == count);
      CHECK(std::accumulate(with_pairs.begin(), with_pairs.end(), std::size_t{0}) >= all.size());
    }
  }
}

TEST_CASE("own pairs: lists of ranks that contradict each other make no schedule") {
  const Pairs all{Pair(0, 1), Pair(1, 2), Pair(1, 3), Pair(2, 3)};  // of sites 0 and 1, and 2 and 3
  std::vector<int> thrown(2, 0);
  on_ranks(2, 4, 2, [&](const Tiling& tiling, std::size_t rank) {
    Pairs own = own_of(tiling, all);
    if (rank == 1) own.erase(std::find(own.begin(), own.end(), Pair(1, 3)));
    try {
      static_cast<void>(ccvt::schedule_own_pairs(own, tiling, Arena(1)));
    } catch (const std::logic_error&) {
      thrown[rank] = 1;
    }
  });
  CHECK(thrown == std::vector<int>{0, 1});
}

TEST_CASE(
    "own pairs: ranks list the pairs that meet of their sites, as sites move and cells grow") {
  for (const int dimension : {2, 3}) {
    for (const int count : {2, 3, 6}) {
      CAPTURE(dimension);
      CAPTURE(count);
      const Box box = Box::unit(dimension);
      const Metric metric(dimension, Domain::periodic(box));
      constexpr Index kSites = 240;
      constexpr int kPasses = 8;
      constexpr std::size_t kMost = 850;
      /// As a run does it, on ranks or not: what one process has, of which a rank's part is due.
      const auto passes = [&](const Tiling& tiling, const Arena& arena) {
        SiteState sites = scattered_sites(box, kSites);
        MeetingPairs meeting;
        Random random(11);
        std::vector<Pass> all;
        for (int pass = 0; pass < kPasses; ++pass) {
          const auto done = meeting.refresh(metric, sites, tiling, arena, 1 << 20);
          const Buffer<Pair> gabriel =
              ccvt::gabriel_pairs(metric, sites, meeting.pairs(), tiling, arena);
          all.push_back({done,
                         sorted(meeting.pairs()),
                         {meeting.added().begin(), meeting.added().end()},
                         {gabriel.begin(), gabriel.end()}});
          disturb(sites, metric, random, pass % 4 == 3 ? kSites : 6);
        }
        // More than any rank finds, fewer than all do.
        meeting.forget();
        all.push_back({meeting.refresh(metric, sites, tiling, arena, kMost), {}, {}, {}});
        return all;
      };
      const std::vector<Pass> alone = passes(Tiling(kSites, 8), Arena(2));
      using Refreshed = MeetingPairs::Refreshed;
      const auto times = [&](Refreshed done) {
        return std::count_if(alone.begin(), alone.end(),
                             [&](const Pass& p) { return p.done == done; });
      };
      REQUIRE(times(Refreshed::extended) > 0);
      REQUIRE(times(Refreshed::rebuilt) > 1);
      REQUIRE(times(Refreshed::too_many) == 1);
      std::vector<std::vector<Pass>> expected(static_cast<std::size_t>(count));
      std::vector<std::vector<Pass>> found(expected.size());
      on_ranks(count, kSites, 8, [&](const Tiling& tiling, std::size_t rank) {
        Arena arena(1 + static_cast<int>(rank % 2));
        arena.divide_among(tiling.ranks());
        found[rank] = passes(tiling, arena);
        expected[rank] = alone;
        for (Pass& pass : expected[rank]) {
          pass.first = own_of(tiling, pass.first);
          pass.added = own_of(tiling, pass.added);
        }
      });
      CHECK(found == expected);
      // No rank has the list of all.
      for (const auto& pass : found) CHECK(pass[0].first.size() < alone[0].first.size());
      REQUIRE(alone[kPasses - 1].first.size() > kMost);
    }
  }
}

TEST_SUITE_END();
