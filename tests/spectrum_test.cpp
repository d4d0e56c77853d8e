#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <vector>

#include "ccvt/metrics.h"
#include "metrics/shells.h"
#include "support/generate.h"
#include "support/lattices.h"

namespace ccvt::test {
namespace {

using Real = long double;

/// From the definition.
double direct_power(std::span<const PointSet> sets, const std::vector<int>& k) {
  Real power = 0;
  for (const PointSet& set : sets) {
    const Box& box = set.domain().box();
    std::complex<Real> sum = 0;
    for (Eigen::Index p = 0; p < set.points().cols(); ++p) {
      Real phase = 0;
      for (std::size_t d = 0; d < k.size(); ++d) {
        const auto row = static_cast<Eigen::Index>(d);
        phase += Real(k[d]) * (Real(set.points()(row, p)) - Real(box.lower[row])) /
                 Real(box.extent()[row]);
      }
      sum += std::polar(Real(1), -2 * std::numbers::pi_v<Real> * (phase - std::floor(phase)));
    }
    power += std::norm(sum) / set.count();
  }
  return static_cast<double>(power / static_cast<Real>(sets.size()));
}

/// All k of |k_d| <= half[d], in the order of Spectrum::power.
std::vector<std::vector<int>> all_frequencies(const std::vector<int>& half) {
  std::vector<std::vector<int>> all(1);
  for (std::size_t d = half.size(); d-- > 0;) {
    std::vector<std::vector<int>> next;
    for (const auto& rest : all) {
      for (int k = -half[d]; k <= half[d]; ++k) {
        next.push_back({k});
        next.back().insert(next.back().end(), rest.begin(), rest.end());
      }
    }
    all.swap(next);
  }
  return all;
}

double frequency_of(const PointSet& set, const std::vector<int>& k) {
  double squared = 0;
  for (std::size_t d = 0; d < k.size(); ++d) {
    const double f = k[d] / set.domain().box().extent()[static_cast<Eigen::Index>(d)];
    squared += f * f;
  }
  return std::sqrt(squared) * set.mean_spacing();
}

std::vector<PointSet> random_sets(int dimension, Index count, int sets) {
  const Box box = uneven_box(dimension);
  std::vector<PointSet> result;
  for (int s = 0; s < sets; ++s) {
    result.emplace_back(
        make_points<double>(Layout::random, box, count, static_cast<std::uint64_t>(s + 1)),
        Domain::periodic(box));
  }
  return result;
}

std::vector<PointSet> white_sets(int dimension, Index count, int sets) {
  std::vector<PointSet> result;
  for (int s = 0; s < sets; ++s) {
    result.push_back(white(dimension, count, static_cast<std::uint64_t>(s + 1)));
  }
  return result;
}

}  // namespace

TEST_SUITE_BEGIN("spectrum");

TEST_CASE("the periodogram is the sum that defines it, at every frequency") {
  for (const auto& row : {std::tuple{1, 70, 2.0}, {2, 300, 1.2}, {2, 7, 2.0}, {3, 120, 1.1}}) {
    const auto dimension = std::get<0>(row);
    const auto count = std::get<1>(row);
    const auto highest = std::get<2>(row);
    CAPTURE(dimension);
    CAPTURE(count);
    const auto sets = random_sets(dimension, count, 2);
    const Spectrum spectrum = power_spectrum(sets, {.max_frequency = highest});
    REQUIRE(static_cast<int>(spectrum.half.size()) == dimension);
    const auto all = all_frequencies(spectrum.half);
    REQUIRE(spectrum.power.size() == all.size());
    std::map<long, std::vector<double>> rings;
    std::vector<double> low;
    double worst = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool zero = std::all_of(all[i].begin(), all[i].end(), [](int k) { return k == 0; });
      const double power = zero ? 0 : direct_power(sets, all[i]);
      worst = std::max(worst, std::abs(power - spectrum.power[i]) / (1 + power));
      const double f = frequency_of(sets[0], all[i]);
      if (zero || f > highest) continue;
      const double width = spectrum.rings[0].upper - spectrum.rings[0].lower;
      const auto last = static_cast<long>(std::ceil(highest / width)) - 1;  // includes `highest`
      rings[std::min(last, static_cast<long>(f / width * (1 + 1e-12)))].push_back(power);
      if (f < 0.25) low.push_back(power);
    }
    CHECK(worst < 1e-11);
    // Every frequency came twice, as f and -f.
    REQUIRE(rings.size() == spectrum.rings.size());
    std::size_t r = 0;
    for (const auto& [number, powers] : rings) {
      const SpectrumRing& ring = spectrum.rings[r++];
      const auto n = static_cast<double>(powers.size());
      double mean = 0;
      for (const double p : powers) mean += p / n;
      double variance = 0;
      for (const double p : powers) variance += (p - mean) * (p - mean) / (n - 2);
      CHECK(ring.frequencies == n / 2);
      CHECK(ring.power == doctest::Approx(mean).epsilon(1e-9));
      if (n > 4) {
        CHECK(ring.anisotropy_db ==
              doctest::Approx(10 * std::log10(variance / mean / mean)).epsilon(1e-6));
      }
    }
    if (low.empty()) {
      CHECK(std::isnan(spectrum.low_frequency_power));
    } else {
      double mean = 0;
      for (const double p : low) mean += p / static_cast<double>(low.size());
      CHECK(spectrum.low_frequency_power == doctest::Approx(mean).epsilon(1e-9));
    }
  }
}

TEST_CASE("shells count and draw their frequencies evenly") {
  for (const Eigen::VectorXd& steps : {Eigen::VectorXd(Eigen::Vector4d::Constant(0.25)),
                                       Eigen::VectorXd(Eigen::Vector3d(0.2, 0.31, 0.17))}) {
    const FrequencyShells shells(steps, 1);
    std::map<std::vector<int>, int> seen;
    const auto all = all_frequencies(std::vector<int>(static_cast<std::size_t>(steps.size()), 7));
    for (const auto& k : all) {
      double squared = 0;
      for (std::size_t d = 0; d < k.size(); ++d) {
        squared += std::pow(k[d] * steps[static_cast<Eigen::Index>(d)], 2);
      }
      if (squared >= 0.2501 && squared < 0.5624) seen[k] = 0;
    }
    CHECK(shells.count(0.5001, 0.7499) == doctest::Approx(static_cast<double>(seen.size()) / 2));
    Random random(1);
    const int draws = 200 * static_cast<int>(seen.size());
    for (int i = 0; i < draws; ++i) {
      const Eigen::VectorXi k = shells.draw(0.5001, 0.7499, random);
      const auto found = seen.find(std::vector<int>(k.begin(), k.end()));
      if (found == seen.end()) {
        FAIL("drawn outside the shell");
      } else {
        ++found->second;
      }
    }
    double worst = 0;
    for (const auto& [k, times] : seen) {
      worst = std::max(worst, std::abs(times - 200) / std::sqrt(200));
    }
    CHECK(worst < 5.5);
  }
}

TEST_CASE("drawn frequencies estimate the rings") {
  const std::vector<PointSet> sets = {white(4, 256, 5)};
  const Spectrum spectrum = power_spectrum(sets, {.max_frequency = 1.2});
  CHECK(spectrum.power.empty());
  std::vector<std::vector<double>> rings(spectrum.rings.size());
  for (const auto& k : all_frequencies({4, 4, 4, 4})) {
    const double f = frequency_of(sets[0], k);
    if (f == 0) continue;
    for (std::size_t r = 0; r < rings.size(); ++r) {
      if (f < spectrum.rings[r].lower - 1e-9 || f >= spectrum.rings[r].upper - 1e-9) continue;
      rings[r].push_back(direct_power(sets, k));
    }
  }
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {  // the last one is cut
    const auto n = static_cast<double>(rings[r].size());
    double mean = 0;
    double square = 0;
    for (const double p : rings[r]) {
      mean += p / n;
      square += p * p / n;
    }
    CHECK(spectrum.rings[r].frequencies == n / 2);
    CHECK(std::abs(spectrum.rings[r].power - mean) <
          5 * std::sqrt((square - mean * mean) / 128) + 1e-12);
  }
}

TEST_CASE("white noise is flat at 1") {
  for (const auto& row : {std::pair{2, 1024}, {3, 512}, {4, 625}}) {
    const auto dimension = std::get<0>(row);
    const auto count = std::get<1>(row);
    CAPTURE(dimension);
    const auto sets = white_sets(dimension, count, 8);
    const Spectrum spectrum = power_spectrum(sets);
    for (const SpectrumRing& ring : spectrum.rings) {
      const double frequencies =
          dimension < 4 ? ring.frequencies : std::min(ring.frequencies, 128.0);
      CHECK(std::abs(ring.power - 1) < 5 / std::sqrt(frequencies * 8));
      if (frequencies > 100) {
        CHECK(ring.anisotropy_db == doctest::Approx(-10 * std::log10(8)).epsilon(0.35));
      }
    }
    CHECK(spectrum.effective_nyquist < 0.3);
    CHECK(spectrum.oscillation < 1);
  }
  // A box that is no torus.
  std::vector<PointSet> boxed;
  for (const PointSet& set : white_sets(2, 1024, 8)) {
    boxed.emplace_back(set.points(), Domain::euclidean(set.domain().box()));
  }
  for (const SpectrumRing& ring : power_spectrum(boxed).rings) {
    CHECK(std::abs(ring.power - 1) < 5 / std::sqrt(ring.frequencies * 8));
  }
}

TEST_CASE("lattices peak where their reciprocal lattice lies, and nowhere else") {
  const double hexagonal_peak = std::sqrt(2 / std::sqrt(3.0));
  const double fcc_peak = std::sqrt(3.0) / std::cbrt(4.0);
  for (const auto& row : {std::pair{cubic(2, 16), 1.0},
                          {hexagonal(16, 9), hexagonal_peak},
                          {cubic(3, 8), 1.0},
                          {checkerboard(3, 4), fcc_peak}}) {
    const PointSet& set = std::get<0>(row);
    const auto peak = std::get<1>(row);
    const std::vector<PointSet> sets = {set};
    const Spectrum spectrum = power_spectrum(sets);
    CHECK(spectrum.low_frequency_power < 1e-12);
    // All power is n, or nothing, and the nearest n is at the peak.
    double nearest = 10;
    const auto all = all_frequencies(spectrum.half);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double p = spectrum.power[i];
      if (p < 1e-9) continue;
      CHECK(p == doctest::Approx(set.count()).epsilon(1e-9));
      nearest = std::min(nearest, frequency_of(set, all[i]));
    }
    CHECK(nearest == doctest::Approx(peak).epsilon(1e-9));
    // The mean power below f is still 0 there, and above 0.1 right behind.
    const double width = spectrum.rings[0].upper - spectrum.rings[0].lower;
    CHECK(std::abs(spectrum.effective_nyquist - peak) < width);
  }
  const std::vector<PointSet> four = {cubic(4, 5)};
  for (const SpectrumRing& ring : power_spectrum(four).rings) {
    if (ring.upper <= 1) CHECK(ring.power < 1e-9);
  }
}

TEST_CASE("jittered grids have the spectrum that theory gives them") {
  // One uniform point in each of m^D cells: P = 1 - prod sinc^2(k_d / m), for k not in m Z^D.
  for (const auto& row : {std::pair{2, 16}, {3, 7}, {4, 5}}) {
    const auto dimension = std::get<0>(row);
    const auto cells = std::get<1>(row);
    CAPTURE(dimension);
    std::vector<PointSet> sets;
    const PointSet corners = cubic(dimension, cells);
    for (std::uint64_t s = 0; s < 12; ++s) {
      Random random(s + 1);
      Points<double> points = corners.points();
      for (double& x : points.reshaped()) x += random.uniform();
      sets.emplace_back(points, corners.domain());
    }
    const Spectrum spectrum = power_spectrum(sets, {.max_frequency = 0.9});
    std::vector<double> sum(spectrum.rings.size(), 0.0);
    std::vector<double> number(spectrum.rings.size(), 0.0);
    const std::vector<int> half(static_cast<std::size_t>(dimension), cells - 1);
    for (const auto& k : all_frequencies(half)) {
      double product = 1;
      for (const int c : k) {
        const double x = std::numbers::pi * c / cells;
        if (c != 0) product *= std::pow(std::sin(x) / x, 2);
      }
      const double f = frequency_of(corners, k);
      for (std::size_t r = 0; r < sum.size() && f > 0; ++r) {
        const SpectrumRing& ring = spectrum.rings[r];
        if (f < ring.lower - 1e-9 || f >= ring.upper - 1e-9) continue;
        sum[r] += 1 - product;
        ++number[r];
      }
    }
    for (std::size_t r = 0; r + 1 < sum.size(); ++r) {
      const double expected = sum[r] / number[r];
      const double frequencies = dimension < 4 ? number[r] / 2 : std::min(number[r] / 2, 128.0);
      CHECK(std::abs(spectrum.rings[r].power - expected) <
            5 * expected / std::sqrt(12 * frequencies) + (dimension < 4 ? 0 : 0.1 * expected));
    }
  }
}

TEST_CASE("effective Nyquist frequency and oscillation of a known radial power") {
  // Poisson-disk points: nothing at low frequencies, a first peak, then ripples around 1.
  for (const auto& row : {std::tuple{2, 400, 0.037}, {3, 400, 0.105}, {4, 400, 0.17}}) {
    const auto dimension = std::get<0>(row);
    const auto count = std::get<1>(row);
    const auto radius = std::get<2>(row);
    const std::vector<PointSet> sets = {darts(dimension, count, radius, 1),
                                        darts(dimension, count, radius, 2)};
    const Spectrum spectrum = power_spectrum(sets);
    CAPTURE(dimension);
    const auto at = [&](double f) {  // the mean power up to f, straight from the rings
      double power = 0;
      double frequencies = 0;
      for (const SpectrumRing& ring : spectrum.rings) {
        const double share =
            std::clamp((std::pow(f, dimension) - std::pow(ring.lower, dimension)) /
                           (std::pow(ring.upper, dimension) - std::pow(ring.lower, dimension)),
                       0.0, 1.0);
        power += share * ring.power * ring.frequencies;
        frequencies += share * ring.frequencies;
      }
      return power / frequencies;
    };
    if (spectrum.effective_nyquist > 0) {
      CHECK(at(spectrum.effective_nyquist) == doctest::Approx(0.1).epsilon(1e-6));
      CHECK(at(spectrum.effective_nyquist + 0.01) > 0.1);
    }
    CHECK(spectrum.peak > 1.05);
    CHECK(spectrum.peak_frequency > 0.8);
    CHECK(spectrum.oscillation > 0.3);
    for (const SpectrumRing& ring : spectrum.rings) {
      if (ring.upper < 0.5 && ring.frequencies > 20) CHECK(ring.power < 0.7);
    }
  }
}

TEST_CASE("spectra do not change with translation, order, scale and threads") {
  for (const int dimension : {2, 3, 4}) {
    CAPTURE(dimension);
    const std::vector<PointSet> sets = {darts(dimension, 300, 0.03, 3)};
    const Spectrum one = power_spectrum(sets, {.threads = 1});
    const Spectrum many = power_spectrum(sets, {.threads = 5});
    CHECK(one.power == many.power);
    REQUIRE(one.rings.size() == many.rings.size());
    for (std::size_t r = 0; r < one.rings.size(); ++r) {
      CHECK(one.rings[r].power == many.rings[r].power);
      CHECK(one.rings[r].anisotropy_db == many.rings[r].anisotropy_db);
    }
    const Box& box = sets[0].domain().box();
    const Points<double>& points = sets[0].points();
    Points<double> moved = (points.array() + 0.3).matrix();
    moved = moved.array() - moved.array().floor();
    const Points<double> reversed = points.rowwise().reverse();
    const Box doubled{box.lower, 2 * box.upper.eigen()};
    const std::vector<PointSet> others[] = {{PointSet(moved, Domain::periodic(box))},
                                            {PointSet(reversed, Domain::periodic(box))},
                                            {PointSet(2 * points, Domain::periodic(doubled))}};
    for (const auto& other : others) {
      const Spectrum same = power_spectrum(other);
      REQUIRE(same.rings.size() == one.rings.size());
      for (std::size_t r = 0; r < one.rings.size(); ++r) {
        CHECK(same.rings[r].power == doctest::Approx(one.rings[r].power).epsilon(1e-9));
      }
      CHECK(same.effective_nyquist == doctest::Approx(one.effective_nyquist).epsilon(1e-9));
    }
  }
}

TEST_CASE("spectra refuse what they cannot do") {
  const std::vector<PointSet> good = {white(2, 9, 1)};
  CHECK_THROWS_WITH_AS(power_spectrum({}), "sets: there are none", InvalidInput);
  CHECK_THROWS_AS(power_spectrum(good, {.max_frequency = 0}), InvalidInput);
  CHECK_THROWS_AS(power_spectrum(good, {.max_frequency = NAN}), InvalidInput);
  CHECK_THROWS_AS(power_spectrum(good, {.ring_width = -1}), InvalidInput);
  CHECK_THROWS_AS(power_spectrum(good, {.ring_width = 1e-9}), InvalidInput);
  CHECK_THROWS_AS(power_spectrum(good, {.threads = -1}), InvalidInput);
  for (const PointSet& other : {white(3, 9, 1), white(2, 10, 1),
                                PointSet(good[0].points(), Domain::euclidean(Box::unit(2)))}) {
    const std::vector<PointSet> mixed = {good[0], other};
    CHECK_THROWS_AS(power_spectrum(mixed), InvalidInput);
    CHECK_THROWS_AS(pair_correlation(mixed), InvalidInput);
    CHECK_THROWS_AS(analyze(mixed), InvalidInput);
  }
  CHECK_THROWS_AS(power_spectrum(good, {.cancelled = [] { return true; }}), Cancelled);
}

TEST_CASE("a thin box has millions of frequencies, of which some are drawn") {
  for (const double thin : {1e-12, 1e-100}) {
    CAPTURE(thin);
    Box box = Box::unit(2);
    box.upper[1] = thin;
    const PointSet set(make_points<double>(Layout::random, box, 100), Domain::euclidean(box));
    const double highest = thin == 1e-100 ? 1e-42 : 2;
    const Spectrum spectrum = power_spectrum({&set, 1}, {.max_frequency = highest});
    CHECK(spectrum.power.empty());
    REQUIRE(spectrum.rings.size() == 1);
    // As many as lie within the ellipse, here nearly all along one axis.
    const double steps = highest / (set.mean_spacing() / 1);
    CHECK(spectrum.rings[0].frequencies == doctest::Approx(steps).epsilon(1e-3));
    CHECK(spectrum.rings[0].power == doctest::Approx(1).epsilon(0.5));
    if (thin == 1e-12) {
      CHECK_THROWS_AS(power_spectrum({&set, 1}, {.max_frequency = 200}), InvalidInput);
    }
  }
}

TEST_CASE("shells of a thin box count every vector, run by run") {
  for (const double step : {1e-5, 3e-4, 0.01}) {
    CAPTURE(step);
    const FrequencyShells shells(Eigen::Vector2d(step, 0.7), 2);
    for (const double upper : {0.5, 1.3, 1.9}) {
      double count = 0;
      for (int k = 0; 0.7 * k < upper; ++k) {
        const double along = std::sqrt(upper * upper - 0.49 * k * k) / step;
        count += (k == 0 ? 1 : 2) * along;
      }
      CHECK(shells.count(0, upper) == doctest::Approx(count).epsilon(0.02));
    }
    Random random(1);
    double sum = 0;
    double largest = 0;
    for (int i = 0; i < 400; ++i) {
      const Eigen::VectorXi k = shells.draw(0, 0.65, random);
      CHECK(k[1] == 0);
      sum += k[0] * step;
      largest = std::max(largest, std::abs(k[0]) * step);
    }
    CHECK(std::abs(sum / 400) < 0.1);  // uniform in [-0.65, 0.65]
    CHECK(largest < 0.651);
    CHECK(largest > 0.6);
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
