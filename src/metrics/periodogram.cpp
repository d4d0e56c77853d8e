#include "metrics/periodogram.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

namespace ccvt {

namespace {

constexpr Eigen::Index kBlockPoints = 256;  ///< one stretch of the products' inner dimension
constexpr std::size_t kTileRows = 32;       ///< rows a task

/// exp(-2 pi i k u) of a block of points for k = 0..half, one row a point.
using Waves = Eigen::ArrayXXcd;

void fill_waves(const PointSet& set, Eigen::Index first, int d, Waves& waves) {
  const double lower = set.domain().box().lower[d];
  const double extent = set.domain().box().upper[d] - lower;
  const double turn = -2 * std::acos(-1.0);
  for (Eigen::Index p = 0; p < waves.rows(); ++p) {
    const std::complex<double> step =
        std::polar(1.0, turn * ((set.points()(d, first + p) - lower) / extent));
    std::complex<double> wave = 1;
    for (Eigen::Index k = 0; k < waves.cols(); ++k, wave *= step) waves(p, k) = wave;
  }
}

/// The wave of k, which may be negative.
auto wave_of(const Waves& waves, int k) {
  return [&waves, k](Eigen::Index p) { return k >= 0 ? waves(p, k) : std::conj(waves(p, -k)); };
}

/// (k_1, ..., k_{D-1}), one of each pair k, -k: the last of them not 0 is positive. Two at most.
using Prefix = std::array<int, 2>;

std::vector<Prefix> half_of_prefixes(const std::vector<int>& half) {
  std::vector<Prefix> prefixes;
  const int h0 = half.size() > 1 ? half[0] : 0;
  const int h1 = half.size() > 2 ? half[1] : 0;
  for (int k1 = 0; k1 <= h1; ++k1) {
    for (int k0 = k1 == 0 ? 0 : -h0; k0 <= h0; ++k0) prefixes.push_back({k0, k1});
  }
  return prefixes;
}

}  // namespace

double FrequencyGrid::bytes(const Eigen::ArrayXd& half) {
  constexpr double complex = sizeof(std::complex<double>);
  const double frequencies = (2 * half + 1).prod();
  const double waves =
      kBlockPoints * complex * ((half + 1).sum() + 2 * (half[half.size() - 1] + 1));
  // Two complex sums for each pair of a frequency and its mirror image; and what pads the tiles.
  const double tiles = complex * static_cast<double>(2 * kTileRows) * half[half.size() - 1];
  return frequencies * (sizeof(double) + complex) + waves + tiles;
}

/// exp(-2 pi i f.p) = w e, with w the wave of the prefix and e that of the last dimension. Its sum
/// over points, for all prefixes and all last k >= 0, is a matrix product, here of real matrices:
/// with w = a + ib and e = c + is the products of [a; b] and [c; s] give the sums for k (ac - bs,
/// as + bc) and for -k (ac + bs, bc - as). Each tile of rows belongs to one task and sums its
/// blocks of points in their order.
void FrequencyGrid::add_power(const PointSet& set, const Arena& arena,
                              std::vector<double>& power) const {
  const auto dimensions = half_.size();
  const int last = half_.back();
  const Eigen::Index columns = last + 1;
  const std::vector<Prefix> prefixes = half_of_prefixes(half_);
  const std::size_t tiles = (prefixes.size() + kTileRows - 1) / kTileRows;
  const auto rows = static_cast<Eigen::Index>(kTileRows);
  std::vector<Eigen::MatrixXd> sums(tiles, Eigen::MatrixXd::Zero(2 * rows, 2 * columns));

  std::vector<Eigen::MatrixXd> tile_waves(static_cast<std::size_t>(arena.threads()));
  std::vector<Waves> waves(dimensions);
  Eigen::MatrixXd last_waves;
  for (Eigen::Index first = 0; first < set.count(); first += kBlockPoints) {
    arena.check();
    const Eigen::Index count = std::min<Eigen::Index>(kBlockPoints, set.count() - first);
    arena.for_each(dimensions, 1, [&](std::size_t d) {
      waves[d].resize(count, half_[d] + 1);
      fill_waves(set, first, static_cast<int>(d), waves[d]);
    });
    last_waves.resize(count, 2 * columns);
    last_waves.leftCols(columns) = waves.back().real();
    last_waves.rightCols(columns) = waves.back().imag();
    arena.for_ranges(tiles, 1, [&](std::size_t begin, std::size_t end, int worker) {
      Eigen::MatrixXd& tile = tile_waves[static_cast<std::size_t>(worker)];
      tile.setZero(count, 2 * rows);
      for (std::size_t t = begin; t < end; ++t) {
        for (std::size_t r = 0; r < kTileRows && t * kTileRows + r < prefixes.size(); ++r) {
          const Prefix& prefix = prefixes[t * kTileRows + r];
          const auto w0 = wave_of(waves[0], prefix[0]);
          const auto w1 = wave_of(waves[dimensions > 2 ? 1 : 0], prefix[1]);
          const auto row = static_cast<Eigen::Index>(r);
          for (Eigen::Index p = 0; p < count; ++p) {
            const std::complex<double> w = w0(p) * w1(p);
            tile(p, row) = w.real();
            tile(p, row + rows) = w.imag();
          }
        }
        sums[t].noalias() += tile.transpose() * last_waves;
      }
    });
  }

  const auto place = [this, dimensions](const Prefix& prefix, int k) {
    const std::array<int, 3> f = dimensions == 1   ? std::array<int, 3>{k, 0, 0}
                                 : dimensions == 2 ? std::array<int, 3>{prefix[0], k, 0}
                                                   : std::array<int, 3>{prefix[0], prefix[1], k};
    std::size_t at = 0;
    for (std::size_t d = dimensions; d-- > 0;) {
      at = at * static_cast<std::size_t>(width(d)) + static_cast<std::size_t>(f[d] + half_[d]);
    }
    return at;
  };
  for (std::size_t r = 0; r < prefixes.size(); ++r) {
    arena.check();
    const Eigen::MatrixXd& sum = sums[r / kTileRows];
    const auto row = static_cast<Eigen::Index>(r % kTileRows);
    const bool zero = prefixes[r] == Prefix{0, 0};
    for (int k = 0; k <= last; ++k) {
      if (zero && k == 0) continue;
      const double ac = sum(row, k);
      const double bs = sum(row + rows, columns + k);
      const double as = sum(row, columns + k);
      const double bc = sum(row + rows, k);
      const Prefix mirrored = {-prefixes[r][0], -prefixes[r][1]};
      const double here = std::norm(std::complex<double>(ac - bs, as + bc));
      power[place(prefixes[r], k)] += here;
      power[place(mirrored, -k)] += here;
      if (zero || k == 0) continue;
      const double there = std::norm(std::complex<double>(ac + bs, bc - as));
      power[place(prefixes[r], -k)] += there;
      power[place(mirrored, k)] += there;
    }
  }
}

}  // namespace ccvt
