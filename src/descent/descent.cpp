#include "descent/descent.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <utility>

#include "relax/balance.h"
#include "relax/update.h"

namespace ccvt {
double g_find = 0, g_count = 0, g_corr = 0, g_commit = 0, g_dir = 0; double g_points = 0; long g_counts = 0;
namespace {
struct T { double& t; std::chrono::steady_clock::time_point b = std::chrono::steady_clock::now(); ~T() { t += std::chrono::duration<double>(std::chrono::steady_clock::now() - b).count(); } };

constexpr std::size_t kSitesPerGrain = 1024;
/// Steps between two updates of the cells.
constexpr int kMostSteps = 16;
constexpr int kMostTries = 6;
constexpr int kMostCorrections = 8;
/// Of the radius of a cell: how far a step may take its site.
constexpr double kLongestStep = 0.25;
constexpr double kFirstShare = 0.3;
double env(const char* n, double d) { const char* e = std::getenv(n); return e ? std::atof(e) : d; }
const double kLargestShare = env("SHAREMAX", 2);
const double kFactor = env("FACTOR", 16);
const double kGain = env("GAIN", 0);
const double kGainFine = env("GAINFINE", 0);
const double kUsed = env("USED", .5);
constexpr double kSmallestShare = 1e-4;

template <class Term>
double largest(const Arena& arena, std::size_t count, const Term& term) {
  return reduce(
      arena, count, kSitesPerGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double most = 0;
        for (std::size_t k = begin; k < end; ++k) most = std::max(most, term(k));
        return most;
      },
      [](double a, double b) { return std::max(a, b); });
}

double length(const double* x, std::size_t dimension) {
  double sum = 0;
  for (std::size_t d = 0; d < dimension; ++d) sum += x[d] * x[d];
  return std::sqrt(sum);
}

}  // namespace

template <class Scalar>
Descent<Scalar>::Descent(const Metric& metric, const Arena& arena,
                         const PointsView<Scalar>& points, std::vector<double>& weights,
                         const LevelState<Scalar>& state, bool finest)
    : metric_(metric),
      arena_(arena),
      points_(points),
      weights_(weights),
      finest_(finest),
      share_(kFirstShare),
      borders_(metric, arena),
      capacity_([&] {
        std::vector<double> all;
        for (const SiteNumber s : state.cells.sites()) all.push_back(state.cells.size(s));
        return all;
      }()),
      radius_(state.sites.radius),
      position_(state.sites.position),
      directions_(capacity_, state.sites.dimension, arena) {
  weights_.resize(capacity_.size(), 0.0);
}

/// False when cells are too large to be seen as they lie.
template <class Scalar>
bool Descent<Scalar>::find_borders(const LevelState<Scalar>& state) {
  const std::size_t sites = capacity_.size();
  const std::size_t limit = std::max<std::size_t>(32 * sites, 2048);
  // The tessellation's sites are centroids; the descent's are where its last step led.
  for (std::size_t s = 0; s < sites; ++s) {
    double moved = 0;
    for (std::size_t d = 0; d < metric_.coordinate_count(); ++d) {
      const std::size_t k = s * metric_.coordinate_count() + d;
      const double u = metric_.wrap(position_[k] - state.sites.position[k], d);
      moved += u * u;
    }
    radius_[s] = state.sites.radius[s] + std::sqrt(moved);
  }
  const double widest = *std::max_element(radius_.begin(), radius_.end());
  for (int d = 0; metric_.periodic() && d < metric_.dimension(); ++d) {
    if (3 * widest > metric_.extent()[d]) return false;
  }
  if (meeting_.refresh(metric_, state.sites, arena_, limit) == MeetingPairs::Refreshed::too_many) {
    if (sites * (sites - 1) / 2 > limit) return false;
    std::vector<Pair> all;
    for (const SiteNumber a : sites_below(sites)) {
      for (const SiteNumber b : state.sites.all().after(a)) all.emplace_back(a, b);
    }
    all_pairs_ = Buffer<Pair>(all.size());
    std::copy(all.begin(), all.end(), all_pairs_.begin());
    meeting_.forget();
  } else {
    const auto first = meeting_.pairs();
    const auto added = meeting_.added();
    all_pairs_ = Buffer<Pair>(first.size() + added.size());
    std::copy(first.begin(), first.end(), all_pairs_.begin());
    std::copy(added.begin(), added.end(), all_pairs_.begin() + first.size());
  }
  T t{g_find};
  borders_.find(state.cells, position_, radius_, weights_, all_pairs_.span(), share_);
  return true;
}

/// Changes the weights until the cells are full but for single points, or no fuller. False when
/// that would take points that are not near borders.
template <class Scalar>
bool Descent<Scalar>::fill(PowerDiagram& diagram) {
  const std::size_t sites = capacity_.size();
  const auto imbalance = [&] {
    return std::sqrt(sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t s) {
      return borders_.surplus()[s] * borders_.surplus()[s] / capacity_[s];
    }));
  };
  const auto full = [&] {
    return std::sqrt(sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t s) {
      const double part = borders_.surplus()[s] / std::max(1.0, fullness_ * capacity_[s]);
      return part * part;
    }) / double(sites)) <= 1;
  };
  { T t{g_count}; borders_.count(diagram); ++g_counts; g_points += double(borders_.size()); } ++counts_;
  for (int k = 0; k < kMostCorrections && !full(); ++k) {
    const double before = imbalance();
    std::vector<double> correction; { T t{g_corr}; correction = borders_.correction(); }
    const std::vector<double> old = diagram.weight;
    double part = 1;
    for (int halved = 0;; ++halved, part /= 2) {
      for (std::size_t s = 0; s < sites; ++s) diagram.weight[s] = old[s] + part * correction[s];
      { T t{g_count}; borders_.count(diagram); ++g_counts; g_points += double(borders_.size()); } ++counts_;
      if (imbalance() < (1 - part / 4) * before) break;
      if (halved == 5) {
        diagram.weight = old;
        { T t{g_count}; borders_.count(diagram); ++g_counts; g_points += double(borders_.size()); }
        return true;
      }
    }
  }
  return true;
}

/// One step of the sites.
template <class Scalar>
auto Descent<Scalar>::descend() -> Move {
  const std::size_t dimension = metric_.coordinate_count();
  std::vector<double> direction; { T t{g_dir}; direction = directions_.direction(gradient_); }
  double slope = directions_.dot(direction, gradient_);
  if (!(slope < 0)) {
    directions_.forget();
    direction = directions_.direction(gradient_);
    slope = directions_.dot(direction, gradient_);
  }
  const double longest = largest(arena_, capacity_.size(), [&](std::size_t s) {
    return length(&direction[s * dimension], dimension) / radius_[s];
  });
  double part = std::min(1.0, kLongestStep / longest);
  for (int tries = 0; tries < kMostTries; ++tries, part *= 0.4) {
    PowerDiagram next = at_;
    for (std::size_t k = 0; k < direction.size(); ++k) next.step[k] += part * direction[k];
    if (!fill(next)) return Move::beyond;
    const double energy = borders_.energy();
    if (std::getenv("TRACE")) std::fprintf(stderr, "    try %g E %.12g (%.12g) used %g\n", part, energy, energy_, borders_.used());
    if (energy > energy_ + 1e-4 * part * 2 * slope) continue;
    std::vector<double> step(direction.size());
    std::vector<double> change(direction.size());
    for (std::size_t k = 0; k < direction.size(); ++k) {
      step[k] = part * direction[k];
      const double gradient = -borders_.to_centroid()[k];
      change[k] = gradient - gradient_[k];
      gradient_[k] = gradient;
    }
    directions_.add(std::move(step), std::move(change));
    at_ = std::move(next);
    energy_ = energy;
    return Move::made;
  }
  return Move::failed;
}

template <class Scalar>
PassCount Descent<Scalar>::step(LevelState<Scalar>& state) {
  PassCount result;
  const std::size_t dimension = metric_.coordinate_count();
  const auto charge = arena_.phase(Phase::update);
  const auto start = [&] {
    if (!find_borders(state)) return false;
    at_ = {std::vector<double>(position_.size(), 0.0), weights_};
    if (!fill(at_)) return false;
    energy_ = borders_.energy();
    gradient_ = borders_.to_centroid();
    for (double& g : gradient_) g = -g;
    return true;
  };
  while (!start()) {
    if (share_ >= kLargestShare) {
      ended_ = true;
      return result;
    }
    share_ = std::min(2 * share_, kLargestShare);
  }
  int steps = 0;
  double used = 0;
  bool made_fine = true;
  for (; steps < kMostSteps;) {
    const double shift = largest(arena_, capacity_.size(), [&](std::size_t s) {
      return length(&gradient_[s * dimension], dimension) / radius_[s] * (finest_ ? capacity_[s] : 4*std::sqrt(capacity_[s]));
    });
    if (std::getenv("TRACE")) std::fprintf(stderr, "  step %d E %.12g shift %g share %g size %zu used %g counts %d\n", steps, energy_, shift, share_, borders_.size(), used, counts_);
    fullness_ = std::clamp(0.1 * largest(arena_, capacity_.size(), [&](std::size_t s) {
      return length(&gradient_[s * dimension], dimension) / radius_[s];
    }), 1e-7, 1e-2);
    if (shift < 1) {
      ended_ = true;
      break;
    }
    before_ = energy_;
    const Move move = descend();
    if (move == Move::made) {
      ++steps;
      used = borders_.used();
      if (used > kUsed) break;
      if (before_ - energy_ < (finest_ ? kGainFine : kGain) * energy_) { if (++small_ > 2) { ended_ = true; break; } } else small_ = 0;

      continue;
    }
    made_fine = false;
    if (move == Move::failed) {
      if (directions_.empty()) {
        ended_ = true;
        break;
      }
      directions_.forget();
      continue;
    }
    break;
  }
  if (steps == 0 && !ended_) {
    if (share_ >= kLargestShare) ended_ = true;
    share_ = std::min(2 * share_, kLargestShare);
  } else if (steps > 0) {
    share_ = std::clamp(share_ * used / steps * kFactor, kSmallestShare, kLargestShare);
  }
  if (!made_fine) borders_.count(at_);
  result.exchanged = commit(state);
  result.active_sites = static_cast<Index>(capacity_.size());
  return result;
}

template <class Scalar>
Index Descent<Scalar>::commit(LevelState<Scalar>& state) {
  for (const SiteNumber s : state.sites.all()) {
    for (int d = 0; d < metric_.dimension(); ++d) {
      const std::size_t k = s * metric_.coordinate_count() + static_cast<std::size_t>(d);
      position_[k] = metric_.into_box(position_[k] + at_.step[k], d);
    }
  }
  T t{g_commit};
  weights_ = at_.weight;
  state.sites.position = position_;
  Filling<Scalar> filling(state.cells, points_, state.tiling);
  for (const SiteNumber s : state.cells.sites()) filling.filled[s] = state.cells.size(s);
  const Index moved = borders_.change_owners(filling);
  balance(metric_, state.sites, all_pairs_.span(), arena_, filling);
  update_all(metric_, state, arena_);
  return moved;
}

template class Descent<float>;
template class Descent<double>;

}  // namespace ccvt
