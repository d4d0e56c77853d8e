#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace ccvt::support {

/// The power spectrum of 2D point sets on the unit torus, averaged over sets of one size, in rings
/// of width sqrt(n) / 8 [Lagae and Dutré 2008]. White noise has power 1. Straight from the
/// definition: |sum over points of exp(-2 pi i f.x)|^2 / n at every integer frequency.
class RadialSpectrum {
 public:
  explicit RadialSpectrum(int points)
      : points_(points), limit_(static_cast<int>(2 * std::sqrt(points))) {
    const auto width = static_cast<std::size_t>(2 * limit_ + 1);
    power_.assign(width * static_cast<std::size_t>(limit_ + 1), 0.0);
  }

  /// `sites`: 2 by n.
  template <class Matrix>
  void add(const Matrix& sites) {
    std::vector<std::complex<double>> sum(power_.size());
    const double turn = 2 * std::acos(-1.0);
    for (Eigen::Index s = 0; s < sites.cols(); ++s) {
      const auto x = static_cast<double>(sites(0, s));
      const auto y = static_cast<double>(sites(1, s));
      std::size_t k = 0;
      const std::complex<double> step = std::polar(1.0, -turn * x);
      for (int fy = 0; fy <= limit_; ++fy) {
        std::complex<double> wave = std::polar(1.0, -turn * (y * fy - x * limit_));
        for (int fx = -limit_; fx <= limit_; ++fx, wave *= step) sum[k++] += wave;
      }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) power_[k] += std::norm(sum[k]) / points_;
    ++sets_;
  }

  struct Ring {
    double frequency = 0;   ///< of its middle, in units of sqrt(n)
    double power = 0;       ///< mean over the ring
    double anisotropy = 0;  ///< variance over squared mean, in dB
  };

  [[nodiscard]] std::vector<Ring> rings() const {
    const double width = std::sqrt(points_) / 8;
    std::vector<std::vector<double>> values(16);
    for_each([&](double radius, double power) {
      const auto ring = static_cast<std::size_t>(radius / width);
      if (ring < values.size()) values[ring].push_back(power);
    });
    std::vector<Ring> rings;
    for (std::size_t r = 0; r < values.size(); ++r) {
      Ring ring;
      ring.frequency = (static_cast<double>(r) + 0.5) / 8;
      for (const double p : values[r]) ring.power += p / static_cast<double>(values[r].size());
      double variance = 0;
      for (const double p : values[r]) variance += (p - ring.power) * (p - ring.power);
      variance /= static_cast<double>(values[r].size() - 1);
      ring.anisotropy = 10 * std::log10(variance / (ring.power * ring.power));
      rings.push_back(ring);
    }
    return rings;
  }

  /// The mean power for 0 < |f| < sqrt(n) / 4.
  [[nodiscard]] double low_frequency_power() const {
    double sum = 0;
    int count = 0;
    for_each([&](double radius, double power) {
      if (radius >= std::sqrt(points_) / 4) return;
      sum += power;
      ++count;
    });
    return sum / count;
  }

 private:
  /// Each frequency but zero and its mirror image once.
  template <class Visit>
  void for_each(Visit visit) const {
    std::size_t k = 0;
    for (int fy = 0; fy <= limit_; ++fy) {
      for (int fx = -limit_; fx <= limit_; ++fx, ++k) {
        if (fy == 0 && fx <= 0) continue;
        visit(std::hypot(fx, fy), power_[k] / sets_);
      }
    }
  }

  int points_;
  int limit_;
  int sets_ = 0;
  std::vector<double> power_;
};

/// The smallest distance between two sites on the unit torus over that of the hexagonal packing,
/// sqrt(2 / (sqrt(3) n)).
template <class Matrix>
double smallest_distance(const Matrix& sites) {
  const Eigen::Index n = sites.cols();
  double smallest = 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i + 1; j < n; ++j) {
      double squared = 0;
      for (int d = 0; d < 2; ++d) {
        const double difference =
            std::abs(static_cast<double>(sites(d, i)) - static_cast<double>(sites(d, j)));
        squared += std::pow(std::min(difference, 1 - difference), 2);
      }
      smallest = std::min(smallest, squared);
    }
  }
  return std::sqrt(smallest / (2 / (std::sqrt(3.0) * static_cast<double>(n))));
}

}  // namespace ccvt::support
