#include "relax/initial_sites.h"

#include <algorithm>
#include <vector>

#include "random.h"

namespace ccvt {
namespace {

constexpr std::uint64_t kSiteStream = 1;

/// `count` distinct numbers below `total`, ascending: Floyd's algorithm [Bentley, Floyd 1987] with
/// a bitmap for a set.
std::vector<Index> distinct_indices(Index count, Index total, std::uint64_t seed) {
  Random random(seed, kSiteStream);
  std::vector<bool> drawn(static_cast<std::size_t>(total), false);
  std::vector<Index> indices;
  indices.reserve(static_cast<std::size_t>(count));
  for (Index last = total - count; last < total; ++last) {
    const auto k = static_cast<Index>(random.below(static_cast<std::uint64_t>(last) + 1));
    const Index index = drawn[static_cast<std::size_t>(k)] ? last : k;
    drawn[static_cast<std::size_t>(index)] = true;
    indices.push_back(index);
  }
  std::sort(indices.begin(), indices.end());
  return indices;
}

}  // namespace

template <class Scalar>
SiteState initial_sites(const Problem<Scalar>& problem, const Metric& metric, std::uint64_t seed) {
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
    Index site = 0;
    for (const Index p : distinct_indices(count, problem.point_count(), seed)) {
      put(site++, problem.points()[p]);
    }
  }
  return sites;
}

template SiteState initial_sites(const Problem<float>&, const Metric&, std::uint64_t);
template SiteState initial_sites(const Problem<double>&, const Metric&, std::uint64_t);

}  // namespace ccvt
