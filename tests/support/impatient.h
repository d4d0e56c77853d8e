#pragma once

#include "ccvt/solver.h"
#include "run.h"

namespace ccvt::test {

/// A tessellation whose sites descend again after so few passes over pairs, where they descend to
/// the end; 0: after as many as always.
template <class Scalar>
Result<Scalar> tessellate_impatiently(const Problem<Scalar>& problem, const Options& options,
                                      double patience) {
  Run<Scalar> run(problem, options);
  if (patience > 0) run.patience = patience;
  while (run.step()) {
  }
  return {run.site_columns(), run.owners(), run.record.summary()};
}

/// How often sites have descended on the finest level.
inline int descents_of(const Summary& summary) {
  int count = 0;
  bool descending = false;
  for (const IterationRecord& record : summary.iterations_log) {
    const bool now = record.level + 1 == record.levels && record.pairs == 0;
    count += now && !descending ? 1 : 0;
    descending = now;
  }
  return count;
}

}  // namespace ccvt::test
