#include "descent/descent.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "relax/balance.h"
#include "relax/take_back.h"
#include "relax/update.h"
#include "schedule/own_pairs.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 1024;
/// Steps between two updates of the cells, tries of a step, and corrections of the weights.
constexpr int kMostSteps = 16;
constexpr int kMostTries = 6;
constexpr int kMostCorrections = 8;
constexpr int kMostHalvings = 5;
/// Of the radius of a cell: how far a step may take its site.
constexpr double kLongestStep = 0.25;
/// Of the squared radius of a cell: how near to a border points are looked at. About as many times
/// what one step uses up.
constexpr double kLargestShare = 0.3;
constexpr double kSmallestShare = 1e-4;
constexpr double kStepsAhead = 4;
/// A descent ends after so many small steps one after the other.
constexpr int kSmallGains = 3;
/// Cells are full when the surplus is, in the mean, this share of how far sites are from their
/// centroids, of the radius; or a point.
constexpr double kFullness = 0.3;
constexpr double kLargestFullness = 0.01;
/// What a diagram must be to say anything: its energy is a lower bound, and the worse the less full
/// the cells are.
constexpr double kNearlyFull = 0.05;
/// Neighbours a site beyond which all this does not pay.
constexpr std::size_t kMostNeighbours = 64;  // in the mean
constexpr std::size_t kMostNeighboursOfOne = 512;
/// Of the mean radius: how small a cell is taken to be, at the least; that of one point has none.
constexpr double kLeastRadius = 0.01;

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

double squared(const double* x, std::size_t dimension) {
  double sum = 0;
  for (std::size_t d = 0; d < dimension; ++d) sum += x[d] * x[d];
  return sum;
}

}  // namespace

template <class Scalar>
Descent<Scalar>::Descent(const Metric& metric, const Arena& arena, Stop& stop,
                         const OwnPoints<Scalar>& points, const LevelState<Scalar>& state,
                         Depth depth, double least_gain, std::vector<double>& weights)
    : metric_(metric),
      arena_(arena),
      stop_(stop),
      points_(points),
      weights_(weights),
      depth_(depth),
      least_gain_(least_gain),
      share_(kLargestShare),
      borders_(metric, arena, state.tiling),
      capacity_(state.cells.site_count()),
      radius_(state.sites.radius),
      position_(state.sites.position),
      fixed_(state.sites.fixed),
      directions_(capacity_, state.sites.dimension, arena) {
  for (const SiteNumber s : state.cells.sites()) capacity_[s] = state.cells.size(s);
}

/// The pairs of sites whose cells can meet. False when these are too many, of all or of one, or
/// cells too large for their torus.
template <class Scalar>
bool Descent<Scalar>::find_neighbours(const LevelState<Scalar>& state) {
  const std::size_t sites = capacity_.size();
  const std::size_t dimension = metric_.coordinate_count();
  // The tessellation has its sites at the centroids; here they are where the last step led.
  for (const SiteNumber s : state.sites.all()) {
    double off = 0;
    for (std::size_t d = 0; d < dimension; ++d) {
      const double u = metric_.wrap(position_[s * dimension + d] - state.sites.at(s)[d], d);
      off += u * u;
    }
    radius_[s] = state.sites.radius[s] + std::sqrt(off);
  }
  const double mean =
      std::accumulate(radius_.begin(), radius_.end(), 0.0) / static_cast<double>(sites);
  for (double& radius : radius_) radius = std::max(radius, kLeastRadius * mean);
  // A site must be near a cell by one of its images only, wherever steps lead.
  constexpr double kImagesApart = 4.5;
  const double widest = *std::max_element(radius_.begin(), radius_.end());
  for (int d = 0; metric_.periodic() && d < metric_.dimension(); ++d) {
    if (kImagesApart * widest > metric_.extent()[d]) return false;
  }
  const std::size_t most = kMostNeighbours * sites / 2;
  const Tiling& tiling = state.tiling;
  const auto refreshed = meeting_.refresh(metric_, state.sites, tiling, arena_, most);
  if (refreshed == MeetingPairs::Refreshed::too_many) return false;
  if (refreshed != MeetingPairs::Refreshed::unchanged || near_.empty()) {
    // All ranks need all of them: of large cells, which are few.
    const Buffer<Pair> first = pairs_of_all(tiling, meeting_.pairs());
    const Buffer<Pair> added = pairs_of_all(tiling, meeting_.added());
    near_.reset(first.size() + added.size());
    std::copy(added.begin(), added.end(), std::copy(first.begin(), first.end(), near_.begin()));
  }
  std::vector<std::size_t> neighbours(sites, 0);
  for (const Pair& pair : near_) {
    ++neighbours[pair.first];
    ++neighbours[pair.second];
  }
  return *std::max_element(neighbours.begin(), neighbours.end()) <= kMostNeighboursOfOne;
}

/// Finds the points near borders, and the diagram to descend from. False when there is none with
/// full cells.
template <class Scalar>
bool Descent<Scalar>::start(const LevelState<Scalar>& state) {
  borders_.find(state.cells, position_, radius_, weights_, near_.span(), share_);
  at_ = {std::vector<double>(position_.size(), 0.0), weights_};
  if (gradient_.empty()) {
    if (!fill(at_, kLargestFullness)) return false;
    look();
  }
  // As full as it will be after a step: else its energy, which is a lower bound, cannot be
  // compared.
  const bool full = fill(at_, kFullness * farthest_centroid());
  look();
  return full;
}

/// Takes the energy and its gradient from the diagram last counted.
template <class Scalar>
void Descent<Scalar>::look() {
  energy_ = borders_.energy();
  gradient_ = gradient_here();
}

/// By how much the energy of the diagram last counted grows where sites move, a point and half a
/// step; nothing where they are fixed.
template <class Scalar>
std::vector<double> Descent<Scalar>::gradient_here() const {
  const std::size_t dimension = metric_.coordinate_count();
  std::vector<double> gradient = borders_.to_centroid();
  for (double& g : gradient) g = -g;
  for (std::size_t s = 0; s < fixed_.size(); ++s) {
    if (fixed_[s] != 0)
      std::fill_n(gradient.begin() + std::ptrdiff_t(s * dimension), dimension, 0.0);
  }
  return gradient;
}

/// How far sites are from the centroids of what they own, at most, of the radius.
template <class Scalar>
double Descent<Scalar>::farthest_centroid() const {
  const std::size_t dimension = metric_.coordinate_count();
  return std::sqrt(largest(arena_, capacity_.size(), [&](std::size_t s) {
    return squared(&gradient_[s * dimension], dimension) / (radius_[s] * radius_[s]);
  }));
}

/// Changes the weights until the cells are full, but for this share of their capacity and for
/// single points; or as full as they become. Whether that is nearly full.
template <class Scalar>
bool Descent<Scalar>::fill(PowerDiagram& diagram, double fullness) {
  const std::size_t sites = capacity_.size();
  const double share = std::min(fullness, kLargestFullness);
  const auto imbalance_beyond = [&](double tolerated) {
    const double sum = sum_of(arena_, sites, kSitesPerGrain, [&](std::size_t s) {
      const double part = borders_.surplus()[s] / std::max(1.0, tolerated * capacity_[s]);
      return part * part;
    });
    return std::sqrt(sum / static_cast<double>(sites));
  };
  const auto imbalance = [&] { return imbalance_beyond(share); };
  borders_.count(diagram);
  double now = imbalance();
  for (int k = 0; k < kMostCorrections && now > 1; ++k) {
    const std::vector<double> correction = borders_.correction();
    const std::vector<double> before = diagram.weight;
    const auto correct = [&](double part) {
      for (std::size_t s = 0; s < sites; ++s) diagram.weight[s] = before[s] + part * correction[s];
      borders_.count(diagram);
      return imbalance();
    };
    double part = 1;
    double then = correct(part);
    for (int halved = 0; then > (1 - part / 4) * now && halved < kMostHalvings; ++halved) {
      then = correct(part /= 2);
    }
    if (then > (1 - part / 4) * now) {
      correct(0);
      break;
    }
    now = then;
  }
  return imbalance_beyond(kNearlyFull) <= 1;
}

/// One step of the sites, to where the energy is lower; false when there is none.
template <class Scalar>
bool Descent<Scalar>::descend() {
  constexpr double kSufficient = 1e-4;  // of what the slope promises [Armijo 1966]
  constexpr double kShorter = 0.4;
  const std::size_t dimension = metric_.coordinate_count();
  std::vector<double> direction = directions_.direction(gradient_);
  double slope = directions_.dot(direction, gradient_);
  if (!(slope < 0)) {
    directions_.forget();
    direction = directions_.direction(gradient_);
    slope = directions_.dot(direction, gradient_);
  }
  const double longest = std::sqrt(largest(arena_, capacity_.size(), [&](std::size_t s) {
    return squared(&direction[s * dimension], dimension) / (radius_[s] * radius_[s]);
  }));
  const double fullness = kFullness * farthest_centroid();
  const std::vector<double> correction = borders_.correction(direction);
  double part = std::min(1.0, kLongestStep / longest);
  for (int tries = 0; tries < kMostTries; ++tries, part *= kShorter) {
    PowerDiagram next = at_;
    for (double& u : direction) u *= tries == 0 ? part : kShorter;
    for (std::size_t k = 0; k < direction.size(); ++k) next.step[k] += direction[k];
    for (std::size_t s = 0; s < capacity_.size(); ++s) {
      next.weight[s] += part * correction[s] + squared(&direction[s * dimension], dimension);
    }
    if (!fill(next, fullness) || borders_.energy() > energy_ + kSufficient * 2 * part * slope)
      continue;
    std::vector<double> change = gradient_here();
    for (std::size_t k = 0; k < change.size(); ++k) {
      change[k] -= gradient_[k];
      gradient_[k] += change[k];
    }
    directions_.add(std::move(direction), std::move(change));
    at_ = std::move(next);
    energy_ = borders_.energy();
    return true;
  }
  return false;
}

template <class Scalar>
double Descent<Scalar>::progress() const {
  if (unsuited_) return 0;
  if (ended_) return 1;
  if (!(first_gain_ > least_gain_)) return 0;
  return std::log(first_gain_ / std::clamp(last_gain_, least_gain_, first_gain_)) /
         std::log(first_gain_ / least_gain_);
}

template <class Scalar>
PassCount Descent<Scalar>::step(LevelState<Scalar>& state) try {
  const auto charge = arena_.phase(Phase::descent);
  PassCount result;
  if (ended_) return result;
  if (!find_neighbours(state)) {
    ended_ = unsuited_ = true;
    return result;
  }
  ended_ = depth_ == Depth::even;
  if (!start(state) && depth_ != Depth::even) {
    ended_ = unsuited_ = true;
    return result;
  }
  int steps = 0;
  double used = 0;
  while (!ended_ && steps < kMostSteps && used <= 1) {
    const double before = energy_;
    if (descend()) {
      ++steps;
      used = borders_.used();
      last_gain_ = (before - energy_) / before;
      if (first_gain_ == 0) first_gain_ = last_gain_;
      small_gains_ = last_gain_ < least_gain_ ? small_gains_ + 1 : 0;
      ended_ = depth_ == Depth::brief || small_gains_ == kSmallGains;
    } else if (directions_.empty()) {
      borders_.count(at_);
      ended_ = true;
    } else {
      directions_.forget();
    }
  }
  if (steps > 0) {
    share_ = std::clamp(share_ * kStepsAhead * used / steps, kSmallestShare, kLargestShare);
  }
  const Stop::Pause pause(stop_);  // points must not be left between cells
  commit(state, result);
  return result;
} catch (const Stopped&) {
  stop_.off();
  PassCount result;
  result.stopped = true;
  return result;
}

/// Points change to the owners that the last diagram gives them, those that are too many flow on,
/// and sites move to their centroids. All is taken back when that does not lower the energy: single
/// points are not as fine as the diagram would have them.
template <class Scalar>
void Descent<Scalar>::commit(LevelState<Scalar>& state, PassCount& result) {
  const SiteState before = state.sites;
  const double energy_before = total_energy(before, arena_);
  for (const SiteNumber s : state.sites.all()) {
    for (std::size_t d = 0; d < metric_.coordinate_count(); ++d) {
      const std::size_t k = s * metric_.coordinate_count() + d;
      position_[k] = metric_.into_box(position_[k] + at_.step[k], d);
    }
  }
  state.sites.position = position_;
  Filling<Scalar> filling(state.cells, points_, state.tiling);
  filling.filled = state.cells.sizes();
  filling.begin_journal();
  result.exchanged = borders_.change_owners(filling);
  balance(metric_, state.sites, near_.span(), arena_, filling);
  update_all(metric_, state, arena_);
  result.active_sites = static_cast<Index>(capacity_.size());
  const double energy = total_energy(state.sites, arena_);
  ended_ = ended_ || !(energy_before - energy > least_gain_ * energy_before);
  if (energy <= energy_before) {
    weights_ = at_.weight;
    return;
  }
  take_back(filling, arena_);
  state.sites = before;
  result = {};
}

template <class Scalar>
void Descent<Scalar>::save(ByteWriter& out, std::span<const Pair> added) const {
  out.put(ended_);
  out.put(unsuited_);
  out.put(first_gain_);
  out.put(last_gain_);
  out.put(share_);
  out.put(small_gains_);
  out.put(position_);
  out.put(gradient_);
  directions_.save(out);
  meeting_.save(out, added);
}

template <class Scalar>
void Descent<Scalar>::load(ByteReader& in, const Tiling& tiling) {
  ended_ = in.get<bool>();
  unsuited_ = in.get<bool>();
  first_gain_ = in.get<double>();
  last_gain_ = in.get<double>();
  share_ = in.get<double>();
  small_gains_ = in.get<int>();
  position_ = in.get_all<double>(position_.size());
  gradient_ = in.get_all<double>();
  if (!gradient_.empty() && gradient_.size() != position_.size()) throw Damaged();
  directions_.load(in);
  meeting_.load(in, metric_, tiling, arena_);
}

template class Descent<float>;
template class Descent<double>;

}  // namespace ccvt
