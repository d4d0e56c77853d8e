#include "descent/lbfgs.h"

#include <utility>

namespace ccvt {
namespace {

/// Steps remembered.
constexpr std::size_t kMemory = 7;
constexpr std::size_t kSitesPerGrain = 2048;

}  // namespace

double Lbfgs::dot(const Vector& a, const Vector& b) const {
  return sum_of(arena_, weights_.size(), kSitesPerGrain, [&](std::size_t s) {
    double sum = 0;
    for (std::size_t k = s * dimension_; k < (s + 1) * dimension_; ++k) sum += a[k] * b[k];
    return weights_[s] * sum;
  });
}

void Lbfgs::add_to(Vector& a, double factor, const Vector& b) const {
  arena_.for_each(a.size(), kSitesPerGrain, [&](std::size_t k) { a[k] += factor * b[k]; });
}

auto Lbfgs::direction(const Vector& gradient) const -> Vector {
  Vector result(gradient.size(), 0.0);
  add_to(result, -1, gradient);
  if (pairs_.empty()) return result;
  std::vector<double> factor(pairs_.size());
  for (std::size_t k = pairs_.size(); k-- > 0;) {
    factor[k] = dot(pairs_[k].step, result) / pairs_[k].product;
    add_to(result, -factor[k], pairs_[k].change);
  }
  const StepAndChange& last = pairs_.back();
  const double scale = last.product / dot(last.change, last.change);
  arena_.for_each(result.size(), kSitesPerGrain, [&](std::size_t k) { result[k] *= scale; });
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const double old = dot(pairs_[k].change, result) / pairs_[k].product;
    add_to(result, factor[k] - old, pairs_[k].step);
  }
  return result;
}

void Lbfgs::add(Vector step, Vector change) {
  constexpr double kLeastCurvature = 1e-10;
  const double product = dot(step, change);
  if (!(product > kLeastCurvature * dot(change, change))) return;
  if (pairs_.size() == kMemory) pairs_.pop_front();
  pairs_.push_back({std::move(step), std::move(change), product});
}

void Lbfgs::save(ByteWriter& out) const {
  out.put(std::uint64_t{pairs_.size()});
  for (const StepAndChange& pair : pairs_) {
    out.put(pair.step);
    out.put(pair.change);
    out.put(pair.product);
  }
}

void Lbfgs::load(ByteReader& in) {
  const auto count = in.get<std::uint64_t>();
  if (count > kMemory) throw Damaged();
  pairs_.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    Vector step = in.get_all<double>(weights_.size() * dimension_);
    Vector change = in.get_all<double>(weights_.size() * dimension_);
    pairs_.push_back({std::move(step), std::move(change), in.get<double>()});
  }
}

}  // namespace ccvt
