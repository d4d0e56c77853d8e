#include "relax/initial_sites.h"

#include <algorithm>
#include <array>

#include "parallel/loops.h"
#include "relax/subsets.h"

namespace ccvt {
namespace {

constexpr std::uint64_t kSiteStream = 1;
constexpr std::size_t kSitesPerGrain = 4096;

/// `count` distinct points, each set of so many equally likely, ascending.
Buffer<Index> distinct_points(std::size_t count, std::size_t points, std::uint64_t seed,
                              const Arena& arena) {
  const NestedSubsets subset(seed, kSiteStream, points, std::array{count}, arena);
  return collect<Index>(arena, points, NestedSubsets::kBlock,
                        [&](std::size_t begin, std::size_t end, std::vector<Index>& out, int) {
                          for (std::size_t p = begin; p < end; ++p) {
                            if (subset.smallest_with(p) == 0) out.push_back(static_cast<Index>(p));
                          }
                        });
}

}  // namespace

template <class Scalar>
SiteState initial_sites(const Problem<Scalar>& problem, const Metric& metric, std::uint64_t seed,
                        const Arena& arena) {
  const int dimension = problem.dimension();
  const Index count = problem.site_count();
  SiteState sites(dimension, count);
  const auto put = [&](Index site, const Scalar* x) {
    for (int d = 0; d < dimension; ++d) {
      sites.at(site)[d] = metric.into_box(static_cast<double>(x[d]), d);
    }
  };
  if (problem.initial_sites().size() > 0) {
    for (Index s = 0; s < count; ++s) put(s, problem.initial_sites().col(s).data());
  } else if (!problem.initial_owners().empty()) {
    const auto& owners = problem.initial_owners();
    for (Index p = problem.point_count(); p-- > 0;) {
      put(owners[static_cast<std::size_t>(p)], problem.points()[p]);
    }
  } else {
    const auto drawn = distinct_points(
        sites.radius.size(), static_cast<std::size_t>(problem.point_count()), seed, arena);
    arena.for_each(drawn.size(), kSitesPerGrain,
                   [&](std::size_t s) { put(static_cast<Index>(s), problem.points()[drawn[s]]); });
  }
  return sites;
}

template SiteState initial_sites(const Problem<float>&, const Metric&, std::uint64_t, const Arena&);
template SiteState initial_sites(const Problem<double>&, const Metric&, std::uint64_t,
                                 const Arena&);

}  // namespace ccvt
