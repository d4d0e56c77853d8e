// The map that whitens points, which may be those of several ranks.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/linear_map.h"
#include "geometry/as_matrix.h"
#include "geometry/finite_points.h"
#include "number_text.h"
#include "parallel/alike.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// Points whose products are added at a time.
constexpr Eigen::Index kBlock = 4096;

/// What add(values) makes of them, in turn on each rank: it goes on where the lower one ended, so
/// that sums have the bits of one process. What the last ends with, on all.
template <class Add>
std::vector<double> in_turn(Ranks* ranks, std::vector<double> values, const Add& add) {
  if (ranks != nullptr && ranks->rank() > 0) {
    const Ranks::Bytes come = ranks->receive(ranks->rank() - 1);
    values.resize(come.size() / sizeof(double));
    ByteReader(come).get(std::span(values));
  }
  add(values);
  if (ranks == nullptr) return values;
  if (ranks->rank() + 1 < ranks->count()) {
    const auto bytes = std::as_bytes(std::span(values));
    ranks->send(ranks->rank() + 1, Ranks::Bytes(bytes.begin(), bytes.end()));
    values.clear();
  }
  return joined(ranks, std::move(values));
}

/// A sum of products of deviations, block by block of all ranks' points.
class Covariance {
 public:
  Covariance(std::span<const double> values, std::int64_t dimension, double count)
      : sum_(Eigen::Map<const Eigen::MatrixXd>(values.data(), dimension, dimension)),
        block_(dimension, kBlock),
        count_(count) {
    const auto rest = values.subspan(static_cast<std::size_t>(sum_.size()));
    size_ = std::ssize(rest) / dimension;
    std::copy(rest.begin(), rest.end(), block_.data());
  }

  template <class Deviation>
  void add(const Eigen::MatrixBase<Deviation>& deviation) {
    block_.col(size_++) = deviation;
    if (size_ == kBlock) end_block();
  }
  void end_block() {
    if (size_ == 0) return;
    const auto block = block_.leftCols(size_);
    sum_ += block * block.transpose() / count_;
    size_ = 0;
  }
  /// The sum, and the block that is not full.
  [[nodiscard]] std::vector<double> values() const {
    std::vector<double> values(sum_.data(), sum_.data() + sum_.size());
    values.insert(values.end(), block_.data(), block_.data() + size_ * block_.rows());
    return values;
  }
  [[nodiscard]] const Eigen::MatrixXd& sum() const { return sum_; }

 private:
  Eigen::MatrixXd sum_;
  Eigen::MatrixXd block_;
  Eigen::Index size_ = 0;
  double count_;
};

struct Spread {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

/// Of the points of all ranks. Throws InvalidInput unless there are any, and all are finite.
template <class Scalar>
Spread spread_of(Ranks* ranks, const PointsView<Scalar>& own) {
  const auto points = as_matrix(own);
  if (ranks != nullptr) {
    require_alike(*ranks, std::vector<Given>{{"points.dimension", concat(own.dimension)}});
  }
  const PartOfAll part = part_of_all(ranks, own.count);
  if (own.dimension < 1 || part.count < 1) throw InvalidInput("points: there are none");
  agree(ranks, [&] { require_finite(points, "is", part.first); });

  // Deviations from a point, then from the mean: far from the origin squares would cost digits.
  const auto dimension = static_cast<std::size_t>(own.dimension);
  std::vector<double> head;
  if (own.count > 0) head.assign(own[0], own[0] + own.dimension);
  const std::vector<double> heads = joined(ranks, std::move(head));
  const Eigen::VectorXd first = Eigen::Map<const Eigen::VectorXd>(heads.data(), own.dimension);
  const auto count = static_cast<double>(part.count);
  const std::vector<double> shifts =
      in_turn(ranks, std::vector<double>(dimension, 0.0), [&](std::vector<double>& values) {
        Eigen::Map<Eigen::VectorXd> sum(values.data(), own.dimension);
        for (Eigen::Index p = 0; p < points.cols(); ++p) {
          sum += points.col(p).template cast<double>() - first;
        }
      });
  const Eigen::VectorXd mean =
      first + Eigen::Map<const Eigen::VectorXd>(shifts.data(), own.dimension) / count;
  const std::vector<double> products = in_turn(
      ranks, std::vector<double>(dimension * dimension, 0.0), [&](std::vector<double>& values) {
        Covariance sum(values, own.dimension, count);
        for (Eigen::Index p = 0; p < points.cols(); ++p) {
          sum.add(points.col(p).template cast<double>() - mean);
        }
        values = sum.values();
      });
  Covariance sum(products, own.dimension, count);
  sum.end_block();
  return {mean, sum.sum()};
}

struct Whitening {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd origin;
};

/// Throws InvalidInput where the covariance is singular.
Whitening whiten(const Spread& spread) {
  const Eigen::MatrixXd& covariance = spread.covariance;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(covariance);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols());
  // Scaled, so that units do not decide what is singular.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd pivots = Eigen::MatrixXd(cholesky.matrixL()).diagonal();
  if (cholesky.info() != Eigen::Success || !covariance.allFinite() ||
      !(pivots.array() > 1e-6 * scale.array()).all()) {
    throw InvalidInput(
        "points: their covariance is singular or nearly so: they must be more than their "
        "dimensions, and not lie in a plane of fewer");
  }
  return {cholesky.matrixL().solve(identity), spread.mean};
}

}  // namespace

template <class Scalar>
LinearMap LinearMap::whitening_of(PointsView<Scalar> points) {
  auto [matrix, origin] = whiten(spread_of(nullptr, points));
  return {std::move(matrix), std::move(origin)};
}

template <class Scalar>
LinearMap LinearMap::whitening_of(Ranks& ranks, PointsView<Scalar> own) {
  auto [matrix, origin] = whiten(spread_of(&ranks, own));
  return {std::move(matrix), std::move(origin)};
}

template CCVT_EXPORT LinearMap LinearMap::whitening_of(PointsView<float>);
template CCVT_EXPORT LinearMap LinearMap::whitening_of(PointsView<double>);
template CCVT_EXPORT LinearMap LinearMap::whitening_of(Ranks&, PointsView<float>);
template CCVT_EXPORT LinearMap LinearMap::whitening_of(Ranks&, PointsView<double>);

}  // namespace ccvt
