#include "metrics/periodogram.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <span>

#include "parallel/loops.h"

namespace ccvt {

namespace {

constexpr Eigen::Index kBlockPoints = 256;  ///< one stretch of the products' inner dimension
constexpr int kTileRows = 32;               ///< rows a task

/// exp(-2 pi i k u) of a block of points for k = 0..half, one row a point.
using Waves = Eigen::ArrayXXcd;

void fill_waves(const PointSet& set, Eigen::Index first, std::size_t d, Waves& waves) {
  const double lower = set.domain().box().lower.data()[d];
  const double extent = set.domain().box().upper.data()[d] - lower;
  const double turn = -2 * std::acos(-1.0);
  for (Eigen::Index p = 0; p < waves.rows(); ++p) {
    const std::complex<double> step =
        std::polar(1.0, turn * ((set.points().col(first + p).data()[d] - lower) / extent));
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
  const double tiles = complex * (2 * kTileRows) * half[half.size() - 1];
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
  const Eigen::Index rows = Eigen::Index{2} * kTileRows;  // a tile: cosines, then sines
  const std::vector<Prefix> prefixes = half_of_prefixes(half_);
  const std::size_t tiles = (prefixes.size() + kTileRows - 1) / kTileRows;
  const auto prefixes_of = [&prefixes](std::size_t tile) {
    const std::span<const Prefix> rest = std::span(prefixes).subspan(tile * kTileRows);
    return rest.first(std::min<std::size_t>(rest.size(), kTileRows));
  };
  std::vector<Eigen::MatrixXd> sums(tiles, Eigen::MatrixXd::Zero(rows, 2 * columns));

  PerWorker<Eigen::MatrixXd> tile_waves(arena);
  std::vector<Waves> waves(dimensions);
  Eigen::MatrixXd last_waves;
  for (Eigen::Index first = 0; first < set.count(); first += kBlockPoints) {
    arena.check();
    const Eigen::Index count = std::min<Eigen::Index>(kBlockPoints, set.count() - first);
    arena.for_each(dimensions, 1, [&](std::size_t d) {
      waves[d].resize(count, half_[d] + 1);
      fill_waves(set, first, d, waves[d]);
    });
    last_waves.resize(count, 2 * columns);
    last_waves.leftCols(columns) = waves.back().real();
    last_waves.rightCols(columns) = waves.back().imag();
    arena.for_ranges(tiles, 1, [&](std::size_t begin, std::size_t end, int worker) {
      Eigen::MatrixXd& tile = tile_waves[worker];
      tile.setZero(count, rows);
      for (std::size_t t = begin; t < end; ++t) {
        Eigen::Index row = 0;
        for (const Prefix& prefix : prefixes_of(t)) {
          const auto w0 = wave_of(waves[0], prefix[0]);
          const auto w1 = wave_of(waves[dimensions > 2 ? 1 : 0], prefix[1]);
          for (Eigen::Index p = 0; p < count; ++p) {
            const std::complex<double> w = w0(p) * w1(p);
            tile(p, row) = w.real();
            tile(p, row + kTileRows) = w.imag();
          }
          ++row;
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
      at = at * width(d) + static_cast<std::size_t>(f[d] + half_[d]);
    }
    return at;
  };
  const auto add_row = [&](const Prefix& prefix, const Eigen::MatrixXd& sum, Eigen::Index row) {
    const Prefix mirrored = {-prefix[0], -prefix[1]};
    const bool zero = prefix == Prefix{0, 0};
    for (int k = 0; k <= last; ++k) {
      if (zero && k == 0) continue;
      const double ac = sum(row, k);
      const double bs = sum(row + kTileRows, columns + k);
      const double as = sum(row, columns + k);
      const double bc = sum(row + kTileRows, k);
      const double here = std::norm(std::complex<double>(ac - bs, as + bc));
      power[place(prefix, k)] += here;
      power[place(mirrored, -k)] += here;
      if (zero || k == 0) continue;
      const double there = std::norm(std::complex<double>(ac + bs, bc - as));
      power[place(prefix, -k)] += there;
      power[place(mirrored, k)] += there;
    }
  };
  for (std::size_t t = 0; t < tiles; ++t) {
    Eigen::Index row = 0;
    for (const Prefix& prefix : prefixes_of(t)) {
      arena.check();
      add_row(prefix, sums[t], row);
      ++row;
    }
  }
}

}  // namespace ccvt
