#include "ccvt/solver.h"

#include <memory>
#include <string>
#include <utility>

#include "checks.h"
#include "run.h"

namespace ccvt {

template <class Scalar>
struct Solver<Scalar>::Implementation : Run<Scalar> {
  using Run<Scalar>::Run;
};

namespace {

/// The run, which is between two iterations: not in the middle of one, where Options::cancelled is
/// asked.
template <class Implementation>
Implementation& resting(const char* function,
                        const std::unique_ptr<Implementation>& implementation) {
  Implementation& run = whole("solver", implementation);
  if (run.asking() == nullptr) return run;
  throw InvalidInput(std::string(function) +
                     ": is called by Options::cancelled, which is asked in the middle of an "
                     "iteration; it may be called by on_iteration");
}

}  // namespace

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
  return resting("Solver::step", implementation_).step();
}

template <class Scalar>
void Solver<Scalar>::run() {
  while (resting("Solver::run", implementation_).step()) {
  }
}

template <class Scalar>
void Solver<Scalar>::cancel() {
  Implementation& run = whole("solver", implementation_);
  if (Stop* const asking = run.asking(); asking != nullptr) return asking->wish();
  if (!run.record.ended()) {
    run.stop.enter();
    run.end_for_now(Termination::cancelled);
  }
}

template <class Scalar>
void Solver<Scalar>::save(const std::filesystem::path& file) const {
  if (file.empty()) throw InvalidInput("file: is empty, but must name the file to be written");
  resting("Solver::save", implementation_).save(file);
}

template <class Scalar>
void Solver<Scalar>::load(const std::filesystem::path& file) {
  resting("Solver::load", implementation_).load(file);
}

template <class Scalar>
Columns<Scalar> Solver<Scalar>::site_columns() const {
  return whole("solver", implementation_).site_columns();
}

template <class Scalar>
std::vector<Index> Solver<Scalar>::owners() const {
  return resting("Solver::owners", implementation_).owners();
}

template <class Scalar>
const Summary& Solver<Scalar>::summary() const {
  return whole("solver", implementation_).record.summary();
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
template CCVT_EXPORT void Solver<float>::save(const std::filesystem::path&) const;
template CCVT_EXPORT void Solver<double>::save(const std::filesystem::path&) const;
template CCVT_EXPORT void Solver<float>::load(const std::filesystem::path&);
template CCVT_EXPORT void Solver<double>::load(const std::filesystem::path&);
template CCVT_EXPORT Columns<float> Solver<float>::site_columns() const;
template CCVT_EXPORT Columns<double> Solver<double>::site_columns() const;
template CCVT_EXPORT std::vector<Index> Solver<float>::owners() const;
template CCVT_EXPORT std::vector<Index> Solver<double>::owners() const;
template CCVT_EXPORT const Summary& Solver<float>::summary() const;
template CCVT_EXPORT const Summary& Solver<double>::summary() const;

}  // namespace ccvt
