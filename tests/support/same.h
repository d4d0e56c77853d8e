#pragma once

#include <cstring>
#include <string>

#include "ccvt/solver.h"

namespace ccvt::test {

/// Bit for bit, also for NaN and for zeros of either sign.
template <class A, class B>
bool same_bits(const Eigen::DenseBase<A>& a, const Eigen::DenseBase<B>& b) {
  const Points<typename A::Scalar> left = a;
  const Points<typename B::Scalar> right = b;
  return left.rows() == right.rows() && left.cols() == right.cols() &&
         std::memcmp(left.data(), right.data(),
                     static_cast<std::size_t>(left.size()) * sizeof(typename A::Scalar)) == 0;
}

/// Empty if two runs did the same, bit for bit; else where they differ.
template <class A, class B>
std::string differences(const A& a, const B& b) {
  std::string result;
  if (!same_bits(a.sites, b.sites)) result += "sites ";
  if (a.owners != b.owners) result += "owners ";
  const Summary& s = a.summary;
  const Summary& t = b.summary;
  if (std::memcmp(&s.energy, &t.energy, sizeof s.energy) != 0) result += "energy ";
  if (s.termination != t.termination) result += "termination ";
  if (s.iterations != t.iterations) result += "iterations ";
  if (s.pairs != t.pairs) result += "pairs ";
  if (s.exchanged != t.exchanged) result += "exchanged ";
  return result;
}

}  // namespace ccvt::test
