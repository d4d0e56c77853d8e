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
      centroids_(sites),
      smooth_(smooth) {
  for (std::size_t k = 0; k < sites.size(); ++k) {
    origin_[k % dimension] += sites[k] / static_cast<double>(capacities.size());
  }
}

double CodewordSteps::excess(const std::vector<double>& sites) const {
  if (at_centroids_) return 0;
  double sum = 0;
  for (std::size_t k = 0; k < sites.size(); ++k) {
    const double apart = sites[k] - centroids_[k];
    sum += sizes_[k / dimension_] * (apart * apart);
  }
  return sum;
}

double CodewordSteps::spread() const {
  double sum = 0;
  for (std::size_t k = 0; k < centroids_.size(); ++k) {
    const double apart = centroids_[k] - origin_[k % dimension_];
    sum += sizes_[k / dimension_] * (apart * apart);
  }
  return sum;
}

/// To the centroids of the cells before.
bool CodewordSteps::take_back(Vector& sites) {
  centroids_ = sites = kept_centroids_;
  sizes_ = kept_sizes_;
  at_centroids_ = true;
  directions_.forget();
  sites_.clear();
  successes_ = 0;
  smooth_ = ++failures_ < kMostFailures;
  return false;
}

bool CodewordSteps::advance(Vector& sites, std::vector<Index> sizes, bool rests) {
  sizes_ = std::move(sizes);
  if (smooth_) {
    const double now = spread();
    if (!at_centroids_) {
      if (!(now > spread_ * (1 + kRounding))) return take_back(sites);
      if (++successes_ == kSuccesses) failures_ = successes_ = 0;
    }
    spread_ = now;
    kept_centroids_ = centroids_;
    kept_sizes_ = sizes_;
    Vector gradient = differences(sites, centroids_);
    if (!sites_.empty()) {
      directions_.add(differences(sites, sites_), differences(gradient, gradient_));
    }
    sites_ = sites;
    gradient_ = std::move(gradient);
  }
  at_centroids_ = true;
  if (smooth_ && !rests && !directions_.empty()) {
    step_beyond(sites);
  } else {
    sites = centroids_;
  }
  return true;
}

void CodewordSteps::step_beyond(Vector& sites) {
  const Vector direction = directions_.direction(gradient_);
  if (!(directions_.dot(direction, gradient_) < 0)) {
    directions_.forget();
    sites = centroids_;
    return;
  }
  const double to_centroids = directions_.dot(gradient_, gradient_);
  const double length = directions_.dot(direction, direction);
  const double share = std::min(1.0, kLongest * std::sqrt(to_centroids / length));
  for (std::size_t k = 0; k < sites.size(); ++k) sites[k] += share * direction[k];
  at_centroids_ = false;
}

}  // namespace ccvt
