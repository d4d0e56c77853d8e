#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/metrics.h"
#include "metrics/periodogram.h"
#include "metrics/sets.h"
#include "metrics/shells.h"
#include "metrics/slope.h"
#include "number_text.h"
#include "parallel/arena.h"
#include "random.h"
#include "streams.h"
#include "thread_count.h"

namespace ccvt {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLowFrequency = 0.25;
constexpr double kMostProducts = 0x1p37;  ///< for the whole periodogram of a set
constexpr double kMostBytes = 0x1p30;     ///< for it and what finds it; for frequencies drawn, too
constexpr double kNoPower = 1e-20;        ///< what rounding leaves of none
constexpr double kNoPowerShare =
    1e-9;  ///< of the mean: what rounding of coordinates leaves of none
constexpr int kRingDraws = 128;
constexpr double kMostRings = 1e6;
constexpr Eigen::Index kBetweenChecks = 1 << 12;
constexpr int kLowDraws = 512;

/// Mean and variance of the power of the frequencies in a ring.
struct Sums {
  double count = 0;
  double power = 0;
  double squares = 0;

  void add(double p) {
    ++count;
    power += p;
    squares += p * p;
  }
};

class RingSums {
 public:
  RingSums(double width, double highest)
      : width_(width), sums_(static_cast<std::size_t>(std::ceil(highest / width * (1 - 1e-12)))) {}

  [[nodiscard]] std::size_t size() const { return sums_.size(); }
  [[nodiscard]] double lower(std::size_t ring) const { return static_cast<double>(ring) * width_; }
  /// The ring of a frequency; one on a border belongs to the outer ring, whatever rounding says.
  [[nodiscard]] std::size_t ring_of(double frequency) const {
    const auto ring = static_cast<std::size_t>(frequency / width_ * (1 + 1e-12));
    return std::min(ring, sums_.size() - 1);
  }
  [[nodiscard]] Sums& operator[](std::size_t ring) { return sums_[ring]; }

  /// `frequencies`: how many each ring has; those that were added, if empty.
  [[nodiscard]] std::vector<SpectrumRing> rings(const std::vector<double>& frequencies,
                                                double highest) const {
    std::vector<SpectrumRing> rings;
    for (std::size_t r = 0; r < sums_.size(); ++r) {
      const Sums& s = sums_[r];
      if (s.count == 0) continue;
      SpectrumRing ring;
      ring.lower = lower(r);
      ring.upper = std::min(lower(r + 1), highest);
      ring.frequencies = frequencies.empty() ? s.count : frequencies[r];
      ring.power = s.power / s.count;
      const double variance =
          s.count > 1 ? (s.squares - s.power * ring.power) / (s.count - 1) : kNaN;
      ring.anisotropy_db = ring.power < kNoPower ? kNaN
                           : variance <= 0       ? -std::numeric_limits<double>::infinity()
                                           : 10 * std::log10(variance / (ring.power * ring.power));
      rings.push_back(ring);
    }
    return rings;
  }

 private:
  double width_;
  std::vector<Sums> sums_;
};

/// What one step of the whole numbers k_d is in 1 / mean spacing.
Eigen::VectorXd steps_of(const PointSet& set) {
  return set.mean_spacing() / set.domain().box().extent().array();
}

/// Shells and slope of the frequencies below kLowFrequency.
void fill_slope(std::vector<FrequencyPower> low, Spectrum& spectrum) {
  const double least = std::max(kNoPower, kNoPowerShare * spectrum.low_frequency_power);
  std::erase_if(low, [least](const FrequencyPower& each) { return !(each.power >= least); });
  spectrum.low_shells = low_shells(std::move(low));
  const PowerLaw law = fit_power_law(spectrum.low_shells, spectrum.sets);
  spectrum.low_frequency_slope = law.slope;
  spectrum.low_frequency_slope_error = law.error;
  spectrum.low_frequency_scale = law.scale;
}

/// Throws unless frequencies can be drawn up to max_frequency, in kMostBytes.
void check_draws(const Eigen::ArrayXd& half, int dimension, const SpectrumOptions& options,
                 std::size_t rings) {
  Eigen::Index longest = 0;
  const double steps = half.maxCoeff(&longest);
  if (steps > FrequencyShells::kMostSteps) {
    throw InvalidInput("max_frequency: " + text(options.max_frequency) + " is " + text(steps) +
                       " steps of the frequencies along dimension " + std::to_string(longest) +
                       " of the box, more than " + text(FrequencyShells::kMostSteps) +
                       ": choose at most " +
                       text(options.max_frequency * (FrequencyShells::kMostSteps / steps), 3));
  }
  // No more rings have a frequency than there are lengths told apart.
  const auto drawn = static_cast<double>(std::min<std::size_t>(rings, 65537) * kRingDraws);
  if (drawn * dimension * sizeof(int) <= kMostBytes) return;
  throw InvalidInput("ring_width: makes " + std::to_string(rings) + " rings in " +
                     std::to_string(dimension) +
                     " dimensions, too many to draw frequencies in each: choose a larger one");
}

/// k or -k, the same for both.
std::vector<int> one_of_pair(const int* k, std::size_t dimension) {
  std::vector<int> numbers(k, k + dimension);
  const auto first = std::find_if(numbers.begin(), numbers.end(), [](int n) { return n != 0; });
  if (first != numbers.end() && *first < 0) {
    for (int& n : numbers) n = -n;
  }
  return numbers;
}

/// The power of a drawn frequency, |sum|^2 / n, added up over the sets.
double power_at(std::span<const PointSet> sets, const Eigen::Map<const Eigen::VectorXi>& k,
                const Arena& arena) {
  double power = 0;
  for (const PointSet& set : sets) {
    const Box& box = set.domain().box();
    const Eigen::VectorXd wave = k.cast<double>().array() / box.extent().array();
    double re = 0;
    double im = 0;
    for (Eigen::Index p = 0; p < set.points().cols(); ++p) {
      if (p % kBetweenChecks == 0) arena.check();
      double turns = 0;
      for (Eigen::Index d = 0; d < k.size(); ++d) {
        if (k[d] != 0) turns += wave[d] * (set.points()(d, p) - box.lower[d]);
      }
      const double phase = 2 * std::acos(-1.0) * (turns - std::floor(turns));
      re += std::cos(phase);
      im -= std::sin(phase);
    }
    power += (re * re + im * im) / set.count();
  }
  return power;
}

void fill_from_grid(std::span<const PointSet> sets, const SpectrumOptions& options,
                    const Arena& arena, RingSums& rings, Spectrum& spectrum) {
  const FrequencyGrid grid(spectrum.half);
  spectrum.power.assign(grid.size(), 0.0);
  for (const PointSet& set : sets) grid.add_power(set, arena, spectrum.power);
  const double scale = 1.0 * spectrum.sets * spectrum.points;
  for (double& p : spectrum.power) p /= scale;

  const Eigen::VectorXd steps = steps_of(sets.front());
  Sums low;
  std::vector<FrequencyPower> low_powers;
  // Those behind f = 0 are one of each pair f, -f.
  for (std::size_t at = grid.size() / 2 + 1; at < grid.size(); ++at) {
    if (at % kBetweenChecks == 0) arena.check();
    std::size_t rest = at;
    double squared = 0;
    for (std::size_t d = 0; d < spectrum.half.size(); ++d) {
      const auto k = static_cast<double>(rest % grid.width(d)) - spectrum.half[d];
      const double f = k * steps.data()[d];
      squared += f * f;
      rest /= grid.width(d);
    }
    const double frequency = std::sqrt(squared);
    if (frequency > options.max_frequency * (1 + 1e-12)) continue;
    if (frequency < kLowFrequency * (1 - 1e-12)) {
      low.add(spectrum.power[at]);
      low_powers.push_back({frequency, spectrum.power[at]});
    }
    rings[rings.ring_of(frequency)].add(spectrum.power[at]);
  }
  spectrum.rings = rings.rings({}, options.max_frequency);
  spectrum.low_frequency_power = low.count > 0 ? low.power / low.count : kNaN;
  fill_slope(std::move(low_powers), spectrum);
}

void fill_from_draws(std::span<const PointSet> sets, const SpectrumOptions& options,
                     const Arena& arena, RingSums& rings, Spectrum& spectrum) {
  const FrequencyShells shells(steps_of(sets.front()), options.max_frequency, arena);
  std::vector<double> counts;
  std::vector<std::size_t> ring_of;
  std::vector<int> drawn;  // one frequency after the other
  const auto draw = [&](double lower, double upper, int draws, std::size_t ring) {
    Random random(options.seed, streams::spectrum_frequencies + ring);
    for (int i = 0; i < draws; ++i) {
      arena.check();
      const Eigen::VectorXi k = shells.draw(lower, upper, random);
      drawn.insert(drawn.end(), k.begin(), k.end());
      ring_of.push_back(ring);
    }
  };
  // The last ring includes max_frequency itself.
  const double highest = 2 * options.max_frequency;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const double upper = r + 1 < rings.size() ? rings.lower(r + 1) : highest;
    arena.check();
    counts.push_back(shells.count(rings.lower(r), upper));
    if (counts.back() > 0) draw(rings.lower(r), upper, kRingDraws, r);
  }
  const double below = std::min(kLowFrequency, highest);
  if (shells.count(0, below) > 0) draw(0, below, kLowDraws, rings.size());

  std::vector<double> power(ring_of.size());
  const auto dimension = static_cast<std::size_t>(spectrum.dimension);
  arena.for_each(power.size(), 1, [&](std::size_t i) {
    const Eigen::Map<const Eigen::VectorXi> k(&drawn[i * dimension], spectrum.dimension);
    power[i] = power_at(sets, k, arena) / spectrum.sets;
  });
  Sums low;
  std::map<std::vector<int>, double> low_powers;
  for (std::size_t i = 0; i < power.size(); ++i) {
    const bool is_low = ring_of[i] == rings.size();
    (is_low ? low : rings[ring_of[i]]).add(power[i]);
    if (is_low) low_powers[one_of_pair(&drawn[i * dimension], dimension)] = power[i];
  }
  spectrum.rings = rings.rings(counts, options.max_frequency);
  spectrum.low_frequency_power = low.count > 0 ? low.power / low.count : kNaN;
  const Eigen::VectorXd steps = steps_of(sets.front());
  std::vector<FrequencyPower> once;
  for (const auto& [k, p] : low_powers) {
    const Eigen::Map<const Eigen::VectorXi> numbers(k.data(), spectrum.dimension);
    once.push_back({(numbers.cast<double>().array() * steps.array()).matrix().norm(), p});
  }
  fill_slope(std::move(once), spectrum);
}

/// The mean power below a frequency, as a function of it, last falls through 0.1 here.
double effective_nyquist(const Spectrum& spectrum) {
  constexpr double threshold = 0.1;
  const auto volume = [&](double f) { return std::pow(f, spectrum.dimension); };
  double result = 0;
  double power = 0;
  double count = 0;
  for (const SpectrumRing& ring : spectrum.rings) {
    // Where (power + x * ring.power) / (count + x) crosses the threshold, x frequencies into it.
    const double start = power - threshold * count;
    const double slope = ring.power - threshold;
    const double end = start + slope * ring.frequencies;
    if (end <= 0) {
      result = ring.upper;
    } else if (start < 0) {
      const double share = -start / (end - start);
      result = std::pow(volume(ring.lower) + share * (volume(ring.upper) - volume(ring.lower)),
                        1.0 / spectrum.dimension);
    }
    power += ring.power * ring.frequencies;
    count += ring.frequencies;
  }
  return result;
}

double oscillation(const std::vector<SpectrumRing>& rings) {
  const auto first = std::find_if(rings.begin(), rings.end(),
                                  [](const SpectrumRing& ring) { return ring.power >= 0.98; });
  double sum = 0;
  double count = 0;
  for (auto ring = first; ring != rings.end(); ++ring) {
    sum += ring->frequencies * (ring->power - 1) * (ring->power - 1);
    count += ring->frequencies;
  }
  return count > 0 ? 10 * std::sqrt(sum / count) : kNaN;
}

}  // namespace

void check_options(const SpectrumOptions& options) {
  if (!(options.max_frequency > 0) || !std::isfinite(options.max_frequency)) {
    throw InvalidInput("max_frequency: " + text(options.max_frequency) +
                       " is not positive and finite");
  }
  if (!(options.ring_width >= 0) || !std::isfinite(options.ring_width)) {
    throw InvalidInput("ring_width: " + text(options.ring_width) +
                       " is neither 0 nor positive and finite");
  }
  if (options.ring_width > 0 && options.max_frequency / options.ring_width > kMostRings) {
    throw InvalidInput("ring_width: " + text(options.ring_width) +
                       " makes more than a million rings up to max_frequency " +
                       text(options.max_frequency));
  }
  require_threads(options.threads);
}

Spectrum power_spectrum(std::span<const PointSet> sets, const SpectrumOptions& options) {
  check_options(options);
  Stop stop(options.cancelled);
  try {
    return power_spectrum(sets, options, Arena(options.threads, &stop));
  } catch (const Stopped&) {
    throw Cancelled();
  }
}

Spectrum power_spectrum(std::span<const PointSet> sets, const SpectrumOptions& options,
                        const Arena& arena) {
  check_alike(sets);
  const PointSet& first = sets.front();
  const Eigen::VectorXd steps = steps_of(first);
  Spectrum spectrum;
  spectrum.dimension = first.dimension();
  spectrum.points = first.count();
  spectrum.sets = static_cast<int>(sets.size());
  spectrum.max_frequency = options.max_frequency;

  const double width =
      options.ring_width > 0 ? options.ring_width : std::max(1.0 / 32, steps.maxCoeff());
  if (options.max_frequency / width > kMostRings) {
    throw InvalidInput("max_frequency: " + text(options.max_frequency) +
                       " makes more than a million rings of width " + text(width));
  }
  RingSums rings(width, options.max_frequency);
  const Eigen::ArrayXd half = (options.max_frequency / steps.array() * (1 + 1e-12)).floor();
  const double products = (2 * half + 1).prod() * first.count();
  if (spectrum.dimension <= 3 && products <= kMostProducts &&
      FrequencyGrid::bytes(half) <= kMostBytes) {
    const Eigen::ArrayXi whole = half.cast<int>();
    spectrum.half.assign(whole.begin(), whole.end());
    fill_from_grid(sets, options, arena, rings, spectrum);
  } else {
    check_draws(half, spectrum.dimension, options, rings.size());
    fill_from_draws(sets, options, arena, rings, spectrum);
  }

  const auto peak = std::max_element(
      spectrum.rings.begin(), spectrum.rings.end(),
      [](const SpectrumRing& a, const SpectrumRing& b) { return a.power < b.power; });
  const bool any = peak != spectrum.rings.end();
  spectrum.peak = any ? peak->power : kNaN;
  spectrum.peak_frequency = any ? peak->middle() : kNaN;
  spectrum.effective_nyquist = effective_nyquist(spectrum);
  spectrum.oscillation = oscillation(spectrum.rings);
  return spectrum;
}

}  // namespace ccvt
