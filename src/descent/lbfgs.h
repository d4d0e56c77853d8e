#pragma once

#include <deque>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "parallel/loops.h"

namespace ccvt {

/// Directions of descent by the limited-memory method of Broyden, Fletcher, Goldfarb and Shanno
/// [Nocedal 1980], in the inner product a . b = sum over sites of weight * a_s . b_s. Sums are in a
/// fixed order.
class Lbfgs {
 public:
  using Vector = std::vector<double>;

  /// `weights` > 0, one for each of the vectors' blocks of `dimension` numbers; must outlive it.
  Lbfgs(std::span<const double> weights, std::size_t dimension, const Arena& arena)
      : weights_(weights), dimension_(dimension), arena_(arena) {}

  [[nodiscard]] double dot(const Vector& a, const Vector& b) const;

  /// The direction of descent for a gradient in that inner product.
  [[nodiscard]] Vector direction(const Vector& gradient) const;

  /// What a step has changed the gradient by; left out where the energy does not curve upwards.
  void add(Vector step, Vector change);
  [[nodiscard]] bool empty() const { return pairs_.empty(); }
  void forget() { pairs_.clear(); }

  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  struct StepAndChange {
    Vector step;
    Vector change;
    double product;
  };
  void add_to(Vector& a, double factor, const Vector& b) const;

  std::span<const double> weights_;
  std::size_t dimension_;
  const Arena& arena_;
  std::deque<StepAndChange> pairs_;
};

}  // namespace ccvt
