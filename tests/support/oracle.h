#pragma once

#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

/// What a tessellation must be, written from the definitions, without the library's own code:
/// in long double, over all points and all pairs of sites.
namespace ccvt::test {

using Real = long double;

/// The shortest of the differences that `difference`, of two positions in the box, stands for.
Real wrapped(const Domain& domain, Real difference, int d);

template <class A, class B>
Real squared_distance(const Domain& domain, int dimension, const A* a, const B* b) {
  Real sum = 0;
  for (int d = 0; d < dimension; ++d) {
    const Real u = wrapped(domain, static_cast<Real>(a[d]) - static_cast<Real>(b[d]), d);
    sum += u * u;
  }
  return sum;
}

/// Empty if each point is owned once and each site owns as many points as its capacity; else what
/// is wrong.
template <class Scalar>
std::string ownership_faults(const Problem<Scalar>& problem, const std::vector<Index>& owners);

/// Empty if, besides, the sites are the centroids of their cells (on a torus: of the images of the
/// points nearest to them) and the summary's energies are theirs.
template <class Scalar>
std::string geometry_faults(const Problem<Scalar>& problem, const Points<Scalar>& sites,
                            const std::vector<Index>& owners, const Summary& summary);

/// Empty unless the energy rises between two iterations of one level.
template <class Scalar>
std::string descent_faults(const Problem<Scalar>& problem, const Summary& summary);

/// Empty unless two points exist whose exchange lowers the energy: all n^2 pairs of sites, all
/// pairs of their points.
template <class Scalar>
std::string stability_faults(const Problem<Scalar>& problem, const Points<Scalar>& sites,
                             const std::vector<Index>& owners);

/// All of the above, stability where the summary claims it.
template <class Scalar, int Dimension>
std::string faults(const Problem<Scalar>& problem, const Result<Scalar, Dimension>& result) {
  const Points<Scalar> sites = result.sites;
  std::string wrong = ownership_faults(problem, result.owners);
  if (!wrong.empty()) return wrong;
  wrong = geometry_faults(problem, sites, result.owners, result.summary) +
          descent_faults(problem, result.summary);
  if (result.summary.termination == Termination::stable) {
    wrong += stability_faults(problem, sites, result.owners);
  }
  return wrong;
}

}  // namespace ccvt::test
