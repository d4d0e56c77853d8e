#include "exact/move_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "exact/distances.h"
#include "exact/packs.h"
#include "geometry/squares.h"
#include "kernels/about.h"
#include "kernels/nearest.h"
#include "kernels/products.h"
#include "kernels/rows.h"
#include "parallel/bytes.h"

namespace ccvt {
namespace {

/// In the units of the products: points farther from their site than this are not multiplied.
constexpr double kFar = 1e12;
/// A squared distance in double to a point that lies anywhere takes as long as so many in a product
/// at hand, with so many dimensions more.
constexpr std::size_t kScattered = 8;
constexpr std::size_t kDimensionsMore = 192;
/// What else is to be done for a product takes as long as this.
constexpr std::size_t kLeastWeighings = 32;

/// With fewer dimensions than this, float gains nothing over double.
constexpr int kLeastRounded = 16;
/// Squares above this, or sums of them, are not to be had in float.
constexpr double kLargeSquare = 1e37;
/// What rounding the sites does to squares is to be so many times less than they are. Else nearly
/// all points must be looked at in double as well: 6000 x 16 vectors at 1e4 took five times as
/// long.
constexpr double kFine = 64;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Points that lie anywhere are compared with so many sites at a time.
constexpr std::size_t kSitesAtOnce = 4;

/// Cells are looked at in parts of so many points.
constexpr std::size_t kPartPoints = 1024;

template <class Number>
Number padded(Number count, Number step) {
  return (count + step - 1) / step * step;
}

/// Squared distances in float, of some points to the first of some positions, then to the next.
void about_squared(PointsView<float> points, std::span<const PointNumber> which,
                   const std::vector<float>& positions, std::span<const SiteNumber> sites,
                   double* out) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const auto at_point = [&](PointNumber p) { return points[p.index()]; };
  while (!sites.empty()) {
    const auto some = sites.first(std::min(kSitesAtOnce, sites.size()));
    std::array<const float*, kSitesAtOnce> position{};
    std::transform(some.begin(), some.end(), position.begin(),
                   [&](SiteNumber s) { return positions.data() + s * dimension; });
    std::array<float, kSitesAtOnce * kRowsAtOnce> square{};
    for_rows(which, at_point, [&](const float* const* rows, Index count, std::size_t begin) {
      kernels::about_squared_distances_of(rows, count, points.dimension, position.data(),
                                          static_cast<Index>(some.size()), square.data(),
                                          static_cast<Index>(kRowsAtOnce));
      for (std::size_t s = 0; s < some.size(); ++s) {
        std::copy_n(square.data() + s * kRowsAtOnce, count, out + s * which.size() + begin);
      }
    });
    sites = sites.subspan(some.size());
    out += some.size() * which.size();
  }
}

}  // namespace

template <class Scalar>
SquaredDistances<Scalar>::SquaredDistances(const Metric& metric, PointsView<Scalar> points,
                                           std::span<const double> sites)
    : metric_(metric), points_(points), sites_(sites), packs_(packs_of(sites, dimension())) {
  if (metric_.periodic()) return;
  round_sites();
  mean_.assign(dimension(), 0.0);
  const std::size_t width = dimension();
  for (const SiteNumber s : sites_below(count())) {
    const double* const site = at(s);
    for (std::size_t d = 0; d < width; ++d) mean_[d] += site[d] / static_cast<double>(count());
  }
  double largest = 0;
  for (const SiteNumber s : sites_below(count())) {
    const double* const site = at(s);
    for (std::size_t d = 0; d < width; ++d) {
      largest = std::max(largest, std::abs(site[d] - mean_[d]));
    }
  }
  scale_ = scale_for(largest);
  const auto step = static_cast<std::size_t>(kernels::kDotSites);
  centred_.assign(padded(count(), step) * width, 0.0F);
  norm_.reserve(count());
  for (const SiteNumber s : sites_below(count())) {
    const double* const site = at(s);
    float* const centred = centred_.data() + s * width;
    double squared = 0;
    for (std::size_t d = 0; d < width; ++d) {
      const double x = scale_ * (site[d] - mean_[d]);
      centred[d] = static_cast<float>(x);
      squared += x * x;
    }
    norm_.push_back(std::sqrt(squared));
  }
}

template <class Scalar>
void SquaredDistances<Scalar>::round_sites() {
  if (!std::is_same_v<Scalar, float> || points_.dimension < kLeastRounded) return;
  rounded_.resize(sites_.size());
  off_.reserve(count());
  const std::size_t width = dimension();
  for (const SiteNumber s : sites_below(count())) {
    const double* const site = at(s);
    float* const rounded = rounded_.data() + s * width;
    double squared = 0;
    for (std::size_t d = 0; d < width; ++d) {
      rounded[d] = static_cast<float>(site[d]);
      const double off = site[d] - double{rounded[d]};
      squared += off * off;
    }
    off_.push_back(std::sqrt(squared));
  }
  most_off_ = *std::max_element(off_.begin(), off_.end());
  if (kFine * margin(0, most_off_).beside < squared_spacing()) {
    rounded_packs_ = packs_of<kernels::kFloatPack, float>(sites_, dimension());
  } else {
    rounded_.clear();
  }
}

/// How far sites are from the nearest others, squared: the mean of the first few.
template <class Scalar>
double SquaredDistances<Scalar>::squared_spacing() const {
  const std::size_t few = std::min<std::size_t>(16, count());
  Scratch scratch;
  double sum = 0;
  for (const SiteNumber s : sites_below(few)) {
    squares(at(s), scratch);
    double& own = scratch.squared[s];
    own = std::numeric_limits<double>::infinity();
    const auto end = scratch.squared.begin() + static_cast<std::ptrdiff_t>(count());
    sum += *std::min_element(scratch.squared.begin(), end);
  }
  return sum / static_cast<double>(few);
}

/// By what share of them squared distances to rounded sites may be off, and by how much beside
/// that, when none exceeds `largest`. With r the distance to the rounded site, and that `off` from
/// the site, the square differs from r^2 by 2 r off + off^2 at most, and 2 r off <= e r^2 + off^2 /
/// e for any e. No numbers where squares are too large for float.
template <class Scalar>
auto SquaredDistances<Scalar>::margin(double largest, double off) const -> Margin {
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  constexpr double kLeast = std::numeric_limits<float>::min();
  const double terms = points_.dimension + 5;
  const Margin margin{1.01 * terms * kEpsilon,
                      1.01 * (terms * kLeast + off * off * (1 + 1 / kEpsilon))};
  const bool sound = largest < kLargeSquare && margin.beside < kLargeSquare;
  return sound ? margin : Margin{kNoNumber, kNoNumber};
}

template <class Scalar>
void SquaredDistances<Scalar>::squared(std::span<const PointNumber> points, SiteNumber site,
                                       std::vector<double>& out) const {
  squared_distances(metric_, points_, points, at(site), out);
}

template <class Scalar>
void SquaredDistances<Scalar>::squared_at_least(std::span<const PointNumber> points,
                                                std::span<const SiteNumber> sites,
                                                std::vector<double>& out,
                                                std::vector<double>& slack) const {
  slack.assign(sites.size(), kNoNumber);
  out.resize(sites.size() * points.size());
  if constexpr (std::is_same_v<Scalar, float>) {
    if (!rounded_.empty()) about_squared(points_, points, rounded_, sites, out.data());
  }
  std::vector<double> exact;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    const std::span<double> squares = std::span(out).subspan(s * points.size(), points.size());
    if (!rounded_.empty()) {
      double largest = 0;
      for (const double square : squares) largest = std::max(largest, square);
      const Margin off = margin(largest, off_[sites[s]]);
      if (!std::isnan(off.share)) {
        for (double& square : squares) square -= off.share * square + off.beside;
        slack[s] = 2.02 * (off.share * largest + off.beside);
        continue;
      }
    }
    squared(points, sites[s], exact);
    std::copy(exact.begin(), exact.end(), squares.begin());
    slack[s] = 0;
  }
}

template <class Scalar>
void SquaredDistances<Scalar>::squared_to(PointNumber point, std::span<const SiteNumber> sites,
                                          std::vector<double>& out, Scratch& scratch) const {
  const Scalar* const x = row(point);
  if (!metric_.periodic()) {
    scratch.position.assign(x, x + dimension());
    squared_distances(
        sites, [&](SiteNumber s) { return at(s); }, points_.dimension, scratch.position.data(),
        out);
    return;
  }
  out.resize(sites.size());
  std::transform(sites.begin(), sites.end(), out.begin(),
                 [&](SiteNumber s) { return metric_.squared_distance(x, at(s)); });
}

template <class Scalar>
void SquaredDistances<Scalar>::squares(const double* from, Scratch& scratch) const {
  scratch.squared.resize(packs_.size() / dimension());
  kernels::squared_distances(
      from, packs_.data(), static_cast<Index>(scratch.squared.size()) / kernels::kPack,
      points_.dimension, metric_.periodic() ? metric_.extent() : nullptr, scratch.squared.data());
}

template <class Scalar>
std::span<const double> SquaredDistances<Scalar>::squared_at_least_to_all(PointNumber point,
                                                                          Scratch& scratch) const {
  const Scalar* const x = row(point);
  std::vector<double>& squared = scratch.squared;
  if constexpr (std::is_same_v<Scalar, float>) {
    if (!rounded_.empty()) {
      std::vector<float>& about = scratch.about;
      about.resize(rounded_packs_.size() / dimension());
      kernels::about_squared_distances(x, rounded_packs_.data(),
                                       static_cast<Index>(about.size()) / kernels::kFloatPack,
                                       points_.dimension, about.data());
      const auto end = about.begin() + static_cast<std::ptrdiff_t>(count());
      const Margin off = margin(*std::max_element(about.begin(), end), most_off_);
      if (!std::isnan(off.share)) {
        squared.resize(count());
        std::transform(about.begin(), end, squared.begin(), [off](float square) {
          return double{square} - (off.share * double{square} + off.beside);
        });
        return squared;
      }
    }
  }
  scratch.position.assign(x, x + dimension());
  squares(scratch.position.data(), scratch);
  squared.resize(count());
  for (double& square : squared) square -= rounding(square);
  return squared;
}

template <class Scalar>
std::size_t SquaredDistances<Scalar>::sites_at_once() const {
  return rounded_.empty() ? 1 : kSitesAtOnce;
}

template <class Scalar>
const Scalar* SquaredDistances<Scalar>::row(PointNumber point) const {
  const std::ptrdiff_t brought = std::ptrdiff_t{point.index()} - points_.count;
  return brought < 0 ? points_[point.index()] : brought_.data() + brought * points_.dimension;
}

template <class Scalar>
std::vector<PointNumber> SquaredDistances<Scalar>::bring(std::span<const Index> points,
                                                         const RankPart& part) {
  std::vector<PointNumber> places;
  ByteWriter message;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::int64_t own = points[k] - part.first;
    const bool here = own >= 0 && own < points_.count;
    places.emplace_back(here ? own : std::int64_t{points_.count} + std::ssize(places));
    if (!here) continue;
    message.put(std::uint64_t{k});
    message.put(std::span(points_[places[k].index()], dimension()));
  }
  brought_.resize(points.size() * dimension());
  for (const Ranks::Bytes& bytes : part.ranks->gather(message.bytes)) {
    ByteReader reader(bytes);
    while (!reader.done()) {
      const auto k = reader.get<std::uint64_t>();
      reader.get(std::span(brought_).subspan(k * dimension(), dimension()));
    }
  }
  return places;
}

template <class Scalar>
double SquaredDistances<Scalar>::rounding(double sum) const {
  return rounding_share(points_.dimension) * sum + underflow_of(points_.dimension);
}

/// The block of some points of a cell; returns how far the farthest point is from the site.
template <class Scalar>
double SquaredDistances<Scalar>::gather(SiteNumber site, std::span<const PointNumber> members,
                                        Scratch& scratch) const {
  const auto size = static_cast<Index>(members.size());
  scratch.stride = padded(size, kernels::dot_points<float>());
  const auto wide = static_cast<std::size_t>(scratch.stride);
  scratch.block.resize(wide * dimension());
  scratch.offset.assign(wide, 0.0F);
  squared(members, site, scratch.own);
  const double farthest = *std::max_element(scratch.own.begin(), scratch.own.end());
  const double radius = std::sqrt(farthest) * (1 + 1e-14 * points_.dimension);
  if (metric_.periodic()) return radius;  // no products
  const auto at_point = [&](PointNumber p) { return points_[p.index()]; };
  for_rows(members, at_point, [&](const Scalar* const* rows, Index count, std::size_t begin) {
    const auto width = static_cast<Index>(std::min(kRowsAtOnce, wide - begin));
    kernels::centred_rows(rows, count, width, points_.dimension, at(site), scale_,
                          scratch.block.data() + begin, scratch.stride);
  });
  const float* const centred = centred_.data() + site * dimension();
  const float* stream = scratch.block.data();
  for (std::size_t d = 0; d < dimension(); ++d, stream += wide) {
    for (std::size_t k = 0; k < wide; ++k) scratch.offset.data()[k] += stream[k] * centred[d];
  }
  return radius;
}

template <class Scalar>
std::span<const double> SquaredDistances<Scalar>::bounds(SiteNumber site,
                                                         std::span<const PointNumber> members,
                                                         Scratch& scratch) const {
  squares(at(site), scratch);
  scratch.bounds.assign(count(), std::numeric_limits<double>::infinity());
  scratch.radius = 0;
  for (auto rest = members; !rest.empty();) {
    const std::size_t part = std::min(rest.size(), kPartPoints);
    lower_bounds(site, rest.first(part), scratch);
    rest = rest.subspan(part);
  }
  return scratch.bounds;
}

template <class Scalar>
std::size_t SquaredDistances<Scalar>::weighings() const {
  return std::max(kLeastWeighings,
                  count() * dimension() / (kScattered * (dimension() + kDimensionsMore)));
}

/// With L the distance of two sites and x a point relative to its own: |x|^2 falls by
/// 2 x . (s_j - s_i) - L^2 on the way to the other, and 2 |x| L - L^2 at most (triangle
/// inequality).
template <class Scalar>
void SquaredDistances<Scalar>::lower_bounds(SiteNumber site, std::span<const PointNumber> members,
                                            Scratch& scratch) const {
  const double radius = gather(site, members, scratch);
  scratch.radius = std::max(scratch.radius, radius);
  const bool multiplied = !metric_.periodic() && radius * scale_ < kFar;
  if (multiplied) {
    scratch.largest.resize(centred_.size() / dimension());
    kernels::largest_dots(scratch.block.data(), scratch.stride, points_.dimension,
                          scratch.offset.data(), centred_.data(),
                          static_cast<Index>(scratch.largest.size()), scratch.largest.data());
  }
  const double relative = rounding_share(points_.dimension);
  const double underflow = underflow_of(points_.dimension);
  const double in_units = scale_ * scale_;
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  constexpr double kLeast = std::numeric_limits<float>::min();
  for (const SiteNumber j : sites_below(count())) {
    const double squared = scratch.squared[j];
    const double reach = 2 * radius * std::sqrt(squared);
    double bound = squared - reach - relative * (squared + reach) - underflow;
    if (multiplied) {
      const double most = 2 * scratch.largest[j] / in_units;
      const double margin =
          4 * (points_.dimension + 4) *
          (kEpsilon * radius * (norm_[site] + norm_[j]) / scale_ + kLeast / in_units);
      bound = std::max(bound, squared - most - margin - relative * squared);
    }
    scratch.bounds[j] = std::min(scratch.bounds[j], bound);
  }
}

template class SquaredDistances<float>;
template class SquaredDistances<double>;

}  // namespace ccvt
