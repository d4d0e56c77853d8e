#include "relax/initial_sites.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "random.h"
#include "relax/own_points.h"
#include "relax/subsets.h"
#include "schedule/tiling.h"
#include "spatial/site_tree.h"
#include "streams.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 4096;
constexpr std::size_t kPointsPerGrain = 1 << 16;

/// `count` distinct points, each set of so many equally likely, ascending.
Buffer<PointOfAll> distinct_points(std::size_t count, std::size_t points, std::uint64_t seed,
                                   const Arena& arena) {
  const NestedSubsets subset(NestedSubsets::Order::random, Random(seed, streams::initial_sites),
                             points, std::array{count}, arena);
  return collect_together<PointOfAll>(
      arena, points, kPointsPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<PointOfAll>& out, int) {
        for (std::size_t p = begin; p < end; ++p) {
          if (subset.smallest_with(p) == 0) out.emplace_back(p);
        }
      });
}

/// Sites that stay take the places of the nearest drawn ones, and the first numbers.
SiteState around_fixed(const Metric& metric, const SiteState& drawn, const SiteState& fixed) {
  SiteTree tree(metric, drawn.position);
  std::vector<std::uint8_t> replaced(drawn.count(), 0);
  for (const SiteNumber f : fixed.all()) {
    const Index nearest = tree.nearest(fixed.at(f));
    tree.remove(nearest);
    replaced[static_cast<std::size_t>(nearest)] = 1;
  }
  SiteState sites(drawn.dimension, drawn.count());
  double* next = sites.position.data() + fixed.position.size();
  for (const SiteNumber s : drawn.all()) {
    if (replaced[s] == 0) next = std::copy_n(drawn.at(s), drawn.dimension, next);
  }
  return sites;
}

/// Calls put(site, coordinates) for the k-th of the points drawn, which is site k, on whatever rank
/// it is.
template <class Scalar, class Put>
void put_drawn(const Problem<Scalar>& problem, const Buffer<PointOfAll>& drawn, const Arena& arena,
               const Put& put) {
  const OwnPoints<Scalar> points(problem.points(), problem.first_own_point());
  if (problem.ranks() == nullptr) {
    return for_each_site(arena, drawn.size(), kSitesPerGrain,
                         [&](SiteNumber s) { put(s, points[drawn[s]]); });
  }
  const auto dimension = static_cast<std::size_t>(problem.dimension());
  std::vector<Scalar> own;
  for (const PointOfAll p : drawn) {
    if (points.has(p)) own.insert(own.end(), points[p], points[p] + dimension);
  }
  // Points are drawn in ascending order, as ranks have them.
  const std::vector<Scalar> all = joined(problem.ranks(), std::move(own));
  for (const SiteNumber s : sites_below(drawn.size())) put(s, all.data() + s * dimension);
}

/// Calls put(site, x) for the first point that each site owns.
template <class Scalar, class Put>
void put_first(const Problem<Scalar>& problem, const Put& put) {
  const auto& points = problem.points();
  const std::vector<Index>& owners = problem.initial_owners();
  const auto n = static_cast<std::size_t>(problem.site_count());
  std::vector<Index> first(n, points.count);
  for (Index p = points.count; p-- > 0;) first[SiteNumber(owners[PointNumber(p)])] = p;
  Ranks* const ranks = problem.ranks();
  if (ranks == nullptr) {
    for (const SiteNumber s : sites_below(n)) put(s, points[first[s]]);
    return;
  }
  // Of each site, some rank finds out which rank's point is the first.
  const auto dimension = static_cast<std::size_t>(points.dimension);
  std::vector<ByteWriter> messages(static_cast<std::size_t>(ranks->count()));
  for (const SiteNumber s : sites_below(n)) {
    if (first[s] == points.count) continue;
    ByteWriter& message = messages[s * messages.size() / n];
    message.put(s);
    message.put(std::span(points[first[s]], dimension));
  }
  std::vector<std::uint8_t> found(n, 0);
  ByteWriter own;
  std::vector<Scalar> x(dimension);
  for (const Ranks::Bytes& come : exchanged(*ranks, std::move(messages))) {  // the lowest first
    for (ByteReader reader(come); !reader.done();) {
      const auto site = reader.get<SiteNumber>();
      reader.get(std::span(x));
      if (std::exchange(found[site], std::uint8_t{1}) != 0) continue;
      own.put(site);
      own.put(std::span(std::as_const(x)));
    }
  }
  for (const Ranks::Bytes& of_rank : ranks->gather(own.bytes)) {
    for (ByteReader reader(of_rank); !reader.done();) {
      const auto site = reader.get<SiteNumber>();
      reader.get(std::span(x));
      put(site, x.data());
    }
  }
}

}  // namespace

template <class Scalar>
SiteState initial_sites(const Problem<Scalar>& problem, const Metric& metric, std::uint64_t seed,
                        const Arena& arena) {
  const int dimension = problem.dimension();
  SiteState sites(dimension, problem.site_count());
  const auto put_in = [&](SiteState& into, SiteNumber site, const Scalar* x) {
    for (int d = 0; d < dimension; ++d) into.at(site)[d] = metric.into_box(x[d], d);
  };
  const auto put = [&](SiteNumber site, const Scalar* x) { put_in(sites, site, x); };
  SiteState fixed(dimension, problem.fixed_sites().cols());
  for (const SiteNumber f : fixed.all()) {
    put_in(fixed, f, problem.fixed_sites().col(f.index()).data());
  }
  bool drawn_freely = false;
  if (problem.initial_sites().size() > 0) {
    for (const SiteNumber s : sites.all()) put(s, problem.initial_sites().col(s.index()).data());
  } else if (has_initial_owners(problem)) {
    put_first(problem, put);
  } else {
    const auto points = static_cast<std::size_t>(problem.point_count());
    const auto drawn = distinct_points(sites.count(), points, seed, arena);
    put_drawn(problem, drawn, arena, put);
    drawn_freely = true;
  }
  if (fixed.count() == 0) return sites;
  if (drawn_freely) sites = around_fixed(metric, sites, fixed);
  std::copy(fixed.position.begin(), fixed.position.end(), sites.position.begin());
  sites.fixed.assign(sites.count(), 0);
  std::fill_n(sites.fixed.begin(), fixed.count(), std::uint8_t{1});
  return sites;
}

template SiteState initial_sites(const Problem<float>&, const Metric&, std::uint64_t, const Arena&);
template SiteState initial_sites(const Problem<double>&, const Metric&, std::uint64_t,
                                 const Arena&);

}  // namespace ccvt
