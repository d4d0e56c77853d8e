#include "codebook/codeword_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccvt {
namespace {

/// A step is no longer than so many times the one to the centroids.
constexpr double kLongest = 30;
/// When so many steps were taken back, without so many in a row that were not, cells are too coarse
/// for more.
constexpr int kMostFailures = 3;
constexpr int kSuccesses = 6;
/// A spread that rises by less than this share may be rounding.
constexpr double kRounding = 1e-13;

std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) result[k] = a[k] - b[k];
  return result;
}

}  // namespace

CodewordSteps::CodewordSteps(const std::vector<double>& sites, std::size_t dimension,
                             std::span<const Index> capacities, bool smooth, const Arena& arena)
    : dimension_(dimension),
      capacities_(capacities.begin(), capacities.end()),
      directions_(capacities_, dimension, arena),
      origin_(dimension, 0.0),
      sites_(sites),
      smooth_(smooth) {
  for (std::size_t k = 0; k < sites.size(); ++k) {
    origin_[k % dimension] += sites[k] / static_cast<double>(capacities.size());
  }
}

double CodewordSteps::excess() const {
  if (at_centroids_) return 0;
  double sum = 0;
  for (std::size_t k = 0; k < sites_.size(); ++k) {
    const double apart = sites_[k] - kept_.centroids[k];
    sum += kept_.sizes[k / dimension_] * (apart * apart);
  }
  return sum;
}

double CodewordSteps::spread(const Vector& centroids, const std::vector<Index>& sizes) const {
  double sum = 0;
  for (std::size_t k = 0; k < centroids.size(); ++k) {
    const double apart = centroids[k] - origin_[k % dimension_];
    sum += sizes[k / dimension_] * (apart * apart);
  }
  return sum;
}

/// To the centroids of the cells before.
bool CodewordSteps::take_back(Vector& centroids) {
  sites_ = centroids = kept_.centroids;
  at_centroids_ = true;
  directions_.forget();
  kept_.sites.clear();
  successes_ = 0;
  smooth_ = ++failures_ < kMostFailures;
  return false;
}

bool CodewordSteps::advance(Vector& centroids, std::vector<Index> sizes, bool rests) {
  if (smooth_) {
    const double now = spread(centroids, sizes);
    if (!at_centroids_) {
      if (!(now > kept_.spread * (1 + kRounding))) return take_back(centroids);
      if (++successes_ == kSuccesses) failures_ = successes_ = 0;
    }
    Vector gradient = differences(sites_, centroids);
    if (!kept_.sites.empty()) {
      directions_.add(differences(sites_, kept_.sites), differences(gradient, kept_.gradient));
    }
    kept_ = {centroids, std::move(sizes), now, sites_, std::move(gradient)};
  }
  at_centroids_ = true;
  if (smooth_ && !rests && !directions_.empty()) step_beyond();
  if (at_centroids_) sites_ = centroids;
  return true;
}

/// Where that leads down.
void CodewordSteps::step_beyond() {
  const Vector& gradient = kept_.gradient;
  const Vector direction = directions_.direction(gradient);
  if (!(directions_.dot(direction, gradient) < 0)) return directions_.forget();
  const double to_centroids = directions_.dot(gradient, gradient);
  const double length = directions_.dot(direction, direction);
  const double share = std::min(1.0, kLongest * std::sqrt(to_centroids / length));
  for (std::size_t k = 0; k < sites_.size(); ++k) sites_[k] += share * direction[k];
  at_centroids_ = false;
}

}  // namespace ccvt
