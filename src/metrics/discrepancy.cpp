#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "ccvt/metrics.h"
#include "compensated_sum.h"
#include "metrics/sets.h"
#include "parallel/arena.h"
#include "thread_count.h"

namespace ccvt {

namespace {

/// Up to so many points all pairs are looked at: of one set, or with the smaller of two.
constexpr std::size_t kFew = 16;
/// Sums over pairs of one set are divided until they are about so many, for threads.
constexpr std::size_t kParts = 64;
/// And those over pairs of two sets that are more than this share of the points.
constexpr std::size_t kCrossingParts = 4;
/// Sums over more are told of a stop in between.
constexpr std::size_t kLong = std::size_t{1} << 12;
/// Nanoseconds, about: an item in a sum that is divided to its end, and a coordinate of a pair.
constexpr double kItem = 30;
constexpr double kPair = 0.6;

/// A point in a sum over pairs of points, perhaps of two sets.
struct Item {
  Index point;
  bool second;  ///< it is of the second set
  double weight;
};
using Items = std::vector<Item>;

/// A sum over pairs of points, those of one set or one point of each of two, of their weights times
/// the lesser of their coordinates along each of the first axes.
struct PairSum {
  Items items;
  bool crosses;  ///< there are two sets
  int axes;
};

/// Divides sums by what is on either side of a plane: of a pair across it the point below has the
/// lesser coordinate, which leaves a sum over one axis less [Heinrich 1996].
class PairSums {
 public:
  PairSums(const Points<double>& points, const Arena& arena) : points_(points), arena_(arena) {}

  [[nodiscard]] double of(PairSum sum) const;

 private:
  [[nodiscard]] double value(PairSum sum) const;
  [[nodiscard]] double of_all_pairs(const PairSum& sum) const;
  [[nodiscard]] double along_axis(PairSum sum) const;
  [[nodiscard]] std::vector<PairSum> halves(PairSum sum) const;

  const Points<double>& points_;
  const Arena& arena_;
};

bool is_few(const PairSum& sum) {
  if (!sum.crosses) return sum.items.size() <= kFew;
  const auto second = static_cast<std::size_t>(
      std::count_if(sum.items.begin(), sum.items.end(), [](const Item& i) { return i.second; }));
  return std::min(second, sum.items.size() - second) <= kFew;
}

double PairSums::of_all_pairs(const PairSum& sum) const {
  double result = 0;
  const auto add = [&](const Item& a, const Item& b) {
    double product = a.weight * b.weight;
    for (Eigen::Index d = 0; d < sum.axes; ++d) {
      product *= std::min(points_(d, a.point), points_(d, b.point));
    }
    result += product;
  };
  if (!sum.crosses) {
    for (std::size_t k = 0; k < sum.items.size(); ++k) {
      for (std::size_t l = 0; l < k; ++l) add(sum.items[k], sum.items[l]);
    }
    return result;
  }
  Items first;
  Items second;
  for (const Item& item : sum.items) (item.second ? second : first).push_back(item);
  for (const Item& a : first) {
    for (const Item& b : second) add(a, b);
  }
  return result;
}

/// Along one axis, from the highest coordinate down; along none the same without coordinates.
double PairSums::along_axis(PairSum sum) const {
  if (sum.axes == 1) {
    std::sort(sum.items.begin(), sum.items.end(), [this](const Item& a, const Item& b) {
      return points_(0, a.point) > points_(0, b.point);
    });
  }
  CompensatedSum result;
  std::array<CompensatedSum, 2> before;  // weights of either set
  for (const Item& item : sum.items) {
    const bool of = sum.crosses ? !item.second : item.second;
    const double coordinate = sum.axes == 1 ? points_(0, item.point) : 1;
    result.add(coordinate * item.weight * before.data()[of ? 1 : 0].value());
    before.data()[item.second ? 1 : 0].add(item.weight);
  }
  return result.value();
}

/// What is on either side of a plane half way along the last axis, and pairs across it.
std::vector<PairSum> PairSums::halves(PairSum sum) const {
  const Eigen::Index axis = sum.axes - 1;
  const auto coordinate = [&](const Item& item) { return points_(axis, item.point); };
  Items& items = sum.items;
  const auto middle = items.begin() + std::ssize(items) / 2;
  std::nth_element(items.begin(), middle, items.end(), [&](const Item& a, const Item& b) {
    return std::tuple(coordinate(a), a.second, a.point) <
           std::tuple(coordinate(b), b.second, b.point);
  });
  const std::span<const Item> below(items.begin(), middle);
  const std::span<const Item> above(middle, items.end());
  std::vector<PairSum> result;
  for (const auto& half : {below, above}) {
    result.push_back({Items(half.begin(), half.end()), sum.crosses, sum.axes});
  }
  for (const bool second_below : {false, true}) {
    if (second_below && !sum.crosses) break;
    PairSum across{{}, true, sum.axes - 1};
    for (const Item& item : below) {
      if (item.second != second_below) continue;
      across.items.push_back({item.point, second_below, item.weight * coordinate(item)});
    }
    for (const Item& item : above) {
      if (sum.crosses && item.second == second_below) continue;
      across.items.push_back({item.point, !second_below, item.weight});
    }
    result.push_back(std::move(across));
  }
  return result;
}

double PairSums::value(PairSum sum) const {
  if (sum.axes <= 1) return along_axis(std::move(sum));
  if (is_few(sum)) return of_all_pairs(sum);
  if (sum.items.size() > kLong) arena_.check();
  double result = 0;
  for (PairSum& part : halves(std::move(sum))) result += value(std::move(part));
  return result;
}

double PairSums::of(PairSum sum) const {
  const std::size_t large = sum.items.size() / kParts;
  const std::size_t large_crossing = sum.items.size() / kCrossingParts;
  std::vector<PairSum> parts;
  std::vector<PairSum> whole;
  whole.push_back(std::move(sum));
  while (!whole.empty()) {
    PairSum next = std::move(whole.back());
    whole.pop_back();
    const std::size_t enough = next.crosses ? large_crossing : large;
    if (next.axes <= 1 || next.items.size() <= enough || is_few(next)) {
      parts.push_back(std::move(next));
      continue;
    }
    for (PairSum& half : halves(std::move(next))) whole.push_back(std::move(half));
  }
  std::vector<double> values(parts.size());
  arena_.for_each(parts.size(), 1, [&](std::size_t k) { values[k] = value(std::move(parts[k])); });
  CompensatedSum result;
  for (const double value : values) result.add(value);
  return result.value();
}

/// Whether that takes less time than to look at all pairs: of n points in D dimensions, n C(log2 n
/// + D - 1, D - 1) items are in sums that are no more divided.
bool is_divided(double n, int dimension) {
  const double halvings = std::max(0.0, std::log2(n / kFew));
  double items = 1;
  for (int d = 1; d < dimension; ++d) items *= (halvings + d) / d;
  return kItem * items < kPair * n / 2 * dimension;
}

/// One by one.
double sum_of_all_pairs(const Points<double>& points, const Arena& arena) {
  std::vector<double> rows(static_cast<std::size_t>(points.cols()));
  arena.for_each(rows.size(), 16, [&](std::size_t row) {
    const auto i = static_cast<Eigen::Index>(row);
    double pairs = 0;
    for (Eigen::Index j = 0; j < i; ++j) {
      double product = 1;
      for (Eigen::Index d = 0; d < points.rows(); ++d) {
        product *= std::min(points(d, i), points(d, j));
      }
      pairs += product;
    }
    rows[row] = pairs;
  });
  CompensatedSum result;
  for (const double row : rows) result.add(row);
  return result.value();
}

}  // namespace

double star_discrepancy(const PointSet& set, int threads) {
  require_points(set);
  require_threads(threads);
  return star_discrepancy(set, Arena(threads));
}

double star_discrepancy(const PointSet& set, const Arena& arena) {
  const Points<double> x = in_unit_cube(set);
  const Points<double> to_corner = 1 - x.array();  // the upper one
  const double n = set.count();
  const int dimension = set.dimension();
  double pairs = 0;
  if (is_divided(n, dimension)) {
    Items items;
    items.reserve(static_cast<std::size_t>(set.count()));
    for (Index p = 0; p < set.count(); ++p) items.push_back({p, false, 1});
    pairs = PairSums(to_corner, arena).of({std::move(items), false, dimension});
  } else {
    pairs = sum_of_all_pairs(to_corner, arena);
  }
  CompensatedSum singles;
  for (Eigen::Index p = 0; p < x.cols(); ++p) {
    singles.add(to_corner.col(p).prod() / n - 2 * ((1 - x.col(p).array().square()) / 2).prod());
  }
  const double square = std::pow(3.0, -dimension) + (2 * pairs / n + singles.value()) / n;
  return std::sqrt(std::max(0.0, square));
}

}  // namespace ccvt
