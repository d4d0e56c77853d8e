#include "ccvt/solver.h"

#include <memory>
#include <utility>

#include "parallel/loops.h"
#include "run.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 16;

}  // namespace

template <class Scalar>
struct Solver<Scalar>::Implementation : Run<Scalar> {
  using Run<Scalar>::Run;
};

template <class Scalar>
Solver<Scalar>::Solver(Problem<Scalar> problem, Options options)
    : implementation_(std::make_unique<Implementation>(std::move(problem), std::move(options))) {}

template <class Scalar>
Solver<Scalar>::Solver(Solver&& other) noexcept
    : implementation_(std::move(other.implementation_)) {}
template <class Scalar>
Solver<Scalar>& Solver<Scalar>::operator=(Solver&& other) noexcept {
  implementation_ = std::move(other.implementation_);
  return *this;
}
template <class Scalar>
Solver<Scalar>::~Solver() {}  // NOLINT: where Implementation is complete

template <class Scalar>
bool Solver<Scalar>::step() {
  return implementation_->step();
}

template <class Scalar>
void Solver<Scalar>::run() {
  while (implementation_->step()) {
  }
}

template <class Scalar>
void Solver<Scalar>::cancel() {
  if (!implementation_->record.ended()) {
    implementation_->stop.enter();
    implementation_->end(Termination::cancelled);
  }
}

template <class Scalar>
Columns<Scalar> Solver<Scalar>::site_columns() const {
  const Run<Scalar>& i = *implementation_;
  Columns<Scalar> sites(i.problem.dimension(), i.problem.site_count());
  for (const SiteNumber k : i.state.sites.all()) {
    const double* position = i.state.sites.at(k);
    for (int d = 0; d < i.problem.dimension(); ++d) {
      sites(d, i.site_of[k].index()) = i.metric.template as<Scalar>(position[d], d);
    }
  }
  return sites;
}

template <class Scalar>
std::vector<Index> Solver<Scalar>::owners() const {
  const Run<Scalar>& i = *implementation_;
  std::vector<Index> owners(static_cast<std::size_t>(i.problem.point_count()), -1);
  const auto given = [&](SiteNumber site) { return i.site_of[site].index(); };
  const Arena arena(i.options.threads);  // not the run's: nothing of this belongs to it
  arena.for_each(i.dealt.size(), kPointsPerGrain,
                 [&](std::size_t p) { owners[p] = given(i.dealt[p]); });
  if (!i.dealt.empty()) return owners;
  for_each_site(arena, i.state.tiling, [&](SiteNumber k) {
    for (const PointNumber p : i.state.cells.points(k)) owners[p] = given(k);
  });
  return owners;
}

template <class Scalar>
const Summary& Solver<Scalar>::summary() const {
  return implementation_->record.summary();
}

// Each member that is compiled here; a whole class would bring along what is inline.
template CCVT_EXPORT Solver<float>::Solver(Problem<float>, Options);
template CCVT_EXPORT Solver<double>::Solver(Problem<double>, Options);
template CCVT_EXPORT Solver<float>::Solver(Solver&&) noexcept;
template CCVT_EXPORT Solver<double>::Solver(Solver&&) noexcept;
template CCVT_EXPORT Solver<float>& Solver<float>::operator=(Solver&&) noexcept;
template CCVT_EXPORT Solver<double>& Solver<double>::operator=(Solver&&) noexcept;
template CCVT_EXPORT Solver<float>::~Solver();
template CCVT_EXPORT Solver<double>::~Solver();
template CCVT_EXPORT bool Solver<float>::step();
template CCVT_EXPORT bool Solver<double>::step();
template CCVT_EXPORT void Solver<float>::run();
template CCVT_EXPORT void Solver<double>::run();
template CCVT_EXPORT void Solver<float>::cancel();
template CCVT_EXPORT void Solver<double>::cancel();
template CCVT_EXPORT Columns<float> Solver<float>::site_columns() const;
template CCVT_EXPORT Columns<double> Solver<double>::site_columns() const;
template CCVT_EXPORT std::vector<Index> Solver<float>::owners() const;
template CCVT_EXPORT std::vector<Index> Solver<double>::owners() const;
template CCVT_EXPORT const Summary& Solver<float>::summary() const;
template CCVT_EXPORT const Summary& Solver<double>::summary() const;

}  // namespace ccvt
