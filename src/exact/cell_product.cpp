#include "exact/cell_product.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "exact/distances.h"
#include "kernels/products.h"
#include "kernels/rows.h"

namespace ccvt {
namespace {

/// Sites whose costs are looked at together.
constexpr Index kChunkSites = 1020;
static_assert(kChunkSites % kernels::kCostSites == 0);

/// An exponent of two; at most half of double's.
constexpr double kMostScale = 500;

}  // namespace

void CellProduct::clear() {
  near_.clear();
  constant_.clear();
  longest_ = 0;
}

void CellProduct::add(SiteNumber site, double squared, double constant) {
  near_.push_back(site);
  constant_.push_back(constant);
  longest_ = std::max(longest_, squared);
}

void CellProduct::prepare(const WeightedSites& sites, const double* centre, double radius) {
  own_ = centre;
  dimension_ = static_cast<int>(sites.dimension);
  double largest_constant = 0;
  for (const double constant : constant_) {
    largest_constant = std::max(largest_constant, std::abs(constant));
  }
  const double largest = std::max({radius * radius, longest_, largest_constant});
  // No more than what still has a square.
  scale_ = largest > 0 ? std::exp2(std::min(kMostScale, -std::ceil(std::log2(largest) / 2))) : 1;
  const double squared_scale = scale_ * scale_;
  const std::size_t tile = kernels::kCostSites;
  const std::size_t padded = (near_.size() + tile - 1) / tile * tile;
  v_.resize(padded * sites.dimension);
  c_.resize(padded);
  for (std::size_t n = 0; n < padded; ++n) {
    c_[n] = n < near_.size() ? static_cast<float>(constant_[n] * squared_scale)
                             : std::numeric_limits<float>::max();
  }
  float* v = v_.data();
  const auto position = [&](SiteNumber s) { return sites.at(s); };
  const auto centre_some = [&](const double* const* rows, Index count, std::size_t) {
    kernels::centred_points(rows, count, dimension_, own_, 2 * scale_, v);
    v += std::ptrdiff_t{count} * dimension_;
  };
  for_rows(std::span<const SiteNumber>(near_), position, centre_some);
  for (; v != v_.data() + v_.size(); v += dimension_) std::copy_n(v - dimension_, dimension_, v);
  // Rounding of x, v and the constant, and of a sum of dimension + 1 terms; and underflow, of v
  // times an x of at most 1.
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  constexpr double kLeast = std::numeric_limits<float>::min();
  const double terms = 2 * radius * std::sqrt(longest_) + largest_constant;
  margin_ = (dimension_ + 6) * (kEpsilon * terms * squared_scale + kLeast);
  fall_.assign(near_.size(), std::numeric_limits<float>::max());
}

template <class Scalar>
void CellProduct::gather(PointsView<Scalar> points, std::span<const PointNumber> members) {
  const auto count = static_cast<Index>(members.size());
  const Index step = kernels::product_points();
  stride_ = (count + step - 1) / step * step;
  block_.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(dimension_));
  static_assert(kPoints <= kRowsAtOnce);
  const auto at = [&](PointNumber p) { return points[p.index()]; };
  for_rows(members, at, [&](const Scalar* const* rows, Index, std::size_t) {
    kernels::centred_rows(rows, count, stride_, dimension_, own_, scale_, block_.data(), stride_);
  });
}

template <class Scalar>
void CellProduct::multiply(PointsView<Scalar> points, std::span<const PointNumber> members) {
  gather(points, members);
  const auto near = static_cast<Index>(near_.size());
  const auto padded = static_cast<Index>(c_.size());
  const auto wide = static_cast<std::size_t>(stride_);
  lowest_.assign(wide, std::numeric_limits<float>::max());
  limit_.assign(wide, std::numeric_limits<float>::lowest());
  cost_.resize(wide * static_cast<std::size_t>(std::min(padded, kChunkSites)));
  place_.resize(cost_.size());
  found_.resize(kPoints);
  for (auto& list : found_) list.clear();
  for (Index first = 0; first < near; first += kChunkSites) {
    const std::ptrdiff_t offset = first;
    kernels::site_costs(block_.data(), stride_, dimension_, v_.data() + offset * dimension_,
                        c_.data() + offset, std::min(kChunkSites, padded - first), cost_.data(),
                        lowest_.data());
    find_cheapest(first, std::min(kChunkSites, near - first), members.size());
  }
}

/// Among `rows` sites from the `first`; costs found before may turn out not to be the least.
void CellProduct::find_cheapest(Index first, Index rows, std::size_t points) {
  for (std::size_t k = 0; k < points; ++k) {
    const double limit = lowest_[k] + 2 * margin_;
    limit_[k] = std::nextafter(static_cast<float>(limit), std::numeric_limits<float>::infinity());
  }
  const Index found =
      kernels::costs_within(cost_.data(), stride_, rows, limit_.data(), place_.data());
  const SiteNumber* const chunk = near_.data() + first;
  const Index* place = place_.data();
  for (const Index* const end = place + found; place < end; ++place) {
    found_.data()[*place % stride_].push_back(chunk[*place / stride_]);
  }
  row_fall_.resize(static_cast<std::size_t>(rows));
  kernels::least_costs(cost_.data(), stride_, rows, row_fall_.data());
  float* const fall = fall_.data() + first;
  std::transform(row_fall_.begin(), row_fall_.end(), fall, fall,
                 [](float a, float b) { return std::min(a, b); });
}

template void CellProduct::multiply(PointsView<float>, std::span<const PointNumber>);
template void CellProduct::multiply(PointsView<double>, std::span<const PointNumber>);

}  // namespace ccvt
