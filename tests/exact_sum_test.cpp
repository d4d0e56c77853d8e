#include "exact_sum.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "random.h"

using ccvt::ExactSum;

namespace {

double sum_of(const std::vector<double>& terms) {
  ExactSum sum;
  for (const double term : terms) sum.add(term);
  return sum.value();
}

}  // namespace

TEST_SUITE_BEGIN("exact_sum");

TEST_CASE("exact_sum: nothing is lost between terms of any size") {
  CHECK(sum_of({}) == 0);
  CHECK(sum_of({1e300, 1, -1e300}) == 1);
  CHECK(sum_of({-1e300, 1e-300, 1e300}) == 1e-300);
  constexpr double least = std::numeric_limits<double>::denorm_min();
  CHECK(sum_of({least, 1e308, least, -1e308}) == 2 * least);
  CHECK(sum_of({-3.5, 1.25}) == -2.25);
  // Rounded once: two halves of a unit in the last place make one.
  const double half = std::numeric_limits<double>::epsilon() / 2;
  CHECK(sum_of({1, half, half}) == 1 + 2 * half);
  for (const double term : {0.1, -7.0 / 3, 1e-310, 5e307, std::numeric_limits<double>::max()}) {
    CHECK(sum_of({term}) == term);
    CHECK(sum_of({term, -term}) == 0);
  }
}

TEST_CASE("exact_sum: neither order nor parts change it") {
  ccvt::Random random(3, 5);
  std::vector<double> terms;
  long double reference = 0;
  for (int k = 0; k < 10'000; ++k) {
    terms.push_back((random.uniform() - 0.4) * std::exp2(static_cast<int>(random.below(30))));
    reference += terms.back();
  }
  const double expected = sum_of(terms);
  CHECK(expected == doctest::Approx(static_cast<double>(reference)).epsilon(1e-14));
  std::vector<double> ascending = terms;
  std::sort(ascending.begin(), ascending.end());
  CHECK(sum_of(ascending) == expected);
  for (const std::size_t parts : {2U, 7U, 100U}) {
    std::vector<ExactSum> part(parts);
    for (std::size_t k = 0; k < terms.size(); ++k) part[k * k % parts].add(terms[k]);
    ExactSum all;
    for (const ExactSum& one : part) all.add(one);
    CHECK(all.value() == expected);
    ExactSum rest = all;
    for (std::size_t k = 1; k < parts; ++k) rest = rest.less(part[k]);
    CHECK(rest.value() == part[0].value());
  }
}

TEST_SUITE_END();
