#include "cli/analysis_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/chart.h"
#include "cli/values.h"

namespace ccvt::cli {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kLowFrequency = 0.25;  ///< up to here the power is fitted
constexpr double kLeastDrawn = 1e-12;   ///< on a logarithmic axis; less is what rounding leaves

/// The least number of the form {1, 2, 5} 10^k / 2 that is not below `value`.
double rounded_up(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (step * power >= value) return step * power;
  }
  return 10 * power;
}

Curve radial_curve(const AnalyzedSet& set, double SpectrumRing::*value) {
  Curve curve;
  curve.name = set.name;
  for (const SpectrumRing& ring : set.analysis.spectrum.rings) {
    curve.x.push_back(ring.middle());
    curve.y.push_back(ring.*value);
  }
  return curve;
}

/// Of what does not exist, a field of CSV is empty.
std::string field(double value) { return std::isfinite(value) ? concat(value) : ""; }

/// The fitted power at low frequency.
double fitted(const Spectrum& spectrum, double frequency) {
  return spectrum.low_frequency_scale * std::pow(frequency, spectrum.low_frequency_slope);
}

/// Shells at low frequency, and rings from there on.
Curve power_law_curve(const AnalyzedSet& set) {
  Curve curve;
  curve.name = set.name;
  const auto add = [&](double x, double y) {
    curve.x.push_back(x);
    curve.y.push_back(y >= kLeastDrawn ? y : NAN);
  };
  for (const LowShell& shell : set.analysis.spectrum.low_shells) add(shell.frequency, shell.power);
  for (const SpectrumRing& ring : set.analysis.spectrum.rings) {
    if (ring.lower >= kLowFrequency * (1 - 1e-12)) add(ring.middle(), ring.power);
  }
  return curve;
}

/// The extremes of all finite values.
std::pair<double, double> extremes(const std::vector<Curve>& curves, double least, double most) {
  for (const Curve& curve : curves) {
    for (const double y : curve.y) {
      if (!std::isfinite(y)) continue;
      least = std::min(least, y);
      most = std::max(most, y);
    }
  }
  return {least, most};
}

}  // namespace

std::vector<Figure> figures_of(const Analysis& analysis) {
  const Spectrum& spectrum = analysis.spectrum;
  std::vector<Figure> figures = {
      {"min_distance", "smallest distance",
       "Smallest distance to a nearest neighbour, as a share of that in the densest packing",
       analysis.distances.smallest},
      {"mean_distance", "mean distance",
       "Mean distance to the nearest neighbour, as a share of that in the densest packing",
       analysis.distances.mean},
      {"low_frequency_power", "low-frequency power",
       "Mean power for 0 < |f| < 0.25 n^(1/D); 1 for white noise", spectrum.low_frequency_power},
      {"low_frequency_slope", "low-frequency slope",
       "Slope of log power over log frequency in that range; 0 for white noise, 4 at best for "
       "cells "
       "of exactly equal mass",
       spectrum.low_frequency_slope},
      {"low_frequency_slope_error", "error of the slope", "Its standard error",
       spectrum.low_frequency_slope_error},
      {"spectral_peak", "spectral peak", "Highest radially averaged power", spectrum.peak},
      {"spectral_peak_frequency", "peak frequency", "Where the peak is, in units of n^(1/D)",
       spectrum.peak_frequency},
      {"effective_nyquist", "effective Nyquist",
       "Largest frequency below which the mean power is at most 0.1, in units of n^(1/D)",
       spectrum.effective_nyquist},
      {"oscillation", "oscillation",
       "10 times the root mean square of the radial power less 1, from where it first reaches 1",
       spectrum.oscillation}};
  if (analysis.dimension == 2) {
    figures.push_back({"psi6_local", "local \xCF\x88\xE2\x82\x86",
                       "Mean over points of the bond-orientational order; 1 for hexagons",
                       analysis.order.psi6_local});
    figures.push_back({"psi6_global", "global \xCF\x88\xE2\x82\x86",
                       "Bond-orientational order of the whole set; 1 for one hexagonal grain",
                       analysis.order.psi6_global});
    figures.push_back({"six_sided", "six-sided cells",
                       "Share of the Voronoi cells with six neighbours", analysis.order.six_sided});
  }
  figures.push_back({"star_discrepancy", "L2 star discrepancy",
                     "L2 star discrepancy in the box, by Warnock's formula",
                     analysis.star_discrepancy});
  const char* const what =
      "Mean squared error of the integral of a test function, as a share of that of white noise";
  figures.push_back(
      {"variance_gaussian", "variance, Gaussian", what, analysis.integration.gaussian});
  figures.push_back({"variance_disk", "variance, disk", what, analysis.integration.disk});
  figures.push_back({"variance_step", "variance, step", what, analysis.integration.step});
  return figures;
}

Json metrics_of(const AnalyzedSet& set) {
  const Analysis& analysis = set.analysis;
  const Domain& domain = set.runs.front().domain();
  Json json;
  json["name"] = set.name;
  json["files"] = set.files;
  json["points"] = analysis.points;
  json["dimension"] = analysis.dimension;
  json["runs"] = analysis.sets;
  json["periodic"] = domain.is_periodic();
  json["box"] = {{"lower", std::vector<double>(domain.box().lower.begin(),  //
                                               domain.box().lower.end())},
                 {"upper", std::vector<double>(domain.box().upper.begin(),  //
                                               domain.box().upper.end())}};
  // JSON has no infinity and no NaN; the library writes null for them.
  for (const Figure& figure : figures_of(analysis)) json[figure.key] = figure.value;
  json["max_frequency"] = analysis.spectrum.max_frequency;
  Json radial = {
      {"frequency", Json::array()}, {"power", Json::array()}, {"anisotropy_db", Json::array()}};
  for (const SpectrumRing& ring : analysis.spectrum.rings) {
    radial["frequency"].push_back(ring.middle());
    radial["power"].push_back(ring.power);
    radial["anisotropy_db"].push_back(ring.anisotropy_db);
  }
  json["radial"] = radial;
  Json low = {
      {"frequency", Json::array()}, {"frequencies", Json::array()}, {"power", Json::array()}};
  for (const LowShell& shell : analysis.spectrum.low_shells) {
    low["frequency"].push_back(shell.frequency);
    low["frequencies"].push_back(shell.frequencies);
    low["power"].push_back(shell.power);
  }
  json["low_frequency_shells"] = low;
  Json pairs = {{"distance", Json::array()}, {"value", analysis.pairs.value}};
  for (std::size_t k = 0; k < analysis.pairs.value.size(); ++k) {
    pairs["distance"].push_back((static_cast<double>(k) + 0.5) * analysis.pairs.bin_width);
  }
  json["pair_correlation"] = pairs;
  return json;
}

std::string radial_csv(const Analysis& analysis) {
  std::string csv = "frequency,power,anisotropy_db\n";
  for (const SpectrumRing& ring : analysis.spectrum.rings) {
    csv += field(ring.middle()) + "," + field(ring.power) + "," + field(ring.anisotropy_db) + "\n";
  }
  return csv;
}

std::string low_frequency_csv(const Analysis& analysis) {
  std::string csv = "frequency,frequencies,power,fit\n";
  for (const LowShell& shell : analysis.spectrum.low_shells) {
    csv += field(shell.frequency) + "," + field(shell.frequencies) + "," + field(shell.power) +
           "," + field(fitted(analysis.spectrum, shell.frequency)) + "\n";
  }
  return csv;
}

std::string power_law_svg(const std::vector<AnalyzedSet>& sets) {
  Chart chart;
  chart.logarithmic = true;
  chart.title = "Power on logarithmic axes";
  chart.x_label = "frequency / n^(1/D)";
  chart.y_label = "power";
  chart.x_least = chart.x_most = sets.front().analysis.spectrum.max_frequency;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const Spectrum& spectrum = sets[s].analysis.spectrum;
    chart.curves.push_back(power_law_curve(sets[s]));
    chart.curves.back().colour = static_cast<int>(s);
    for (const double x : chart.curves.back().x) chart.x_least = std::min(chart.x_least, x);
    if (!std::isfinite(spectrum.low_frequency_slope)) continue;
    Curve line;
    line.name = sets[s].name + ": slope " + decimal_text(spectrum.low_frequency_slope, 2) +
                " \xC2\xB1 " + decimal_text(spectrum.low_frequency_slope_error, 2);
    line.x = {spectrum.low_shells.front().frequency, kLowFrequency};
    for (const double x : line.x) line.y.push_back(fitted(spectrum, x));
    line.colour = static_cast<int>(s);
    line.dashed = true;
    chart.curves.push_back(std::move(line));
  }
  if (!(chart.x_least < chart.x_most)) chart.x_least = chart.x_most / 2;
  chart.guides.push_back({1, "white noise"});
  double least = 0.1;
  double most = 2;
  for (const Curve& curve : chart.curves) {
    for (const double y : curve.y) {
      if (!std::isfinite(y) || y < kLeastDrawn) continue;
      least = std::min(least, y);
      most = std::max(most, y);
    }
  }
  chart.y_least = std::pow(10, std::floor(std::log10(least)));
  chart.y_most = std::pow(10, std::ceil(std::log10(most)));
  return draw(chart);
}

std::string radial_svg(const std::vector<AnalyzedSet>& sets) {
  Chart chart;
  chart.title = "Radially averaged power";
  chart.x_label = "frequency / n^(1/D)";
  chart.y_label = "power";
  for (const AnalyzedSet& set : sets) {
    chart.curves.push_back(radial_curve(set, &SpectrumRing::power));
    chart.x_most = std::max(chart.x_most, set.analysis.spectrum.max_frequency);
  }
  if (sets.front().analysis.spectrum.max_frequency < 1) {
    chart.x_most = sets.front().analysis.spectrum.max_frequency;
  }
  chart.guides.push_back({1, "white noise"});
  chart.y_most = rounded_up(extremes(chart.curves, 0, 1.9).second * 1.05);
  return draw(chart);
}

std::string anisotropy_svg(const std::vector<AnalyzedSet>& sets) {
  Chart chart;
  chart.title = "Anisotropy";
  chart.x_label = "frequency / n^(1/D)";
  chart.y_label = "anisotropy, dB";
  chart.x_most = sets.front().analysis.spectrum.max_frequency;
  std::vector<int> runs;
  for (const AnalyzedSet& set : sets) {
    chart.curves.push_back(radial_curve(set, &SpectrumRing::anisotropy_db));
    const int count = set.analysis.sets;
    if (std::find(runs.begin(), runs.end(), count) != runs.end()) continue;
    runs.push_back(count);
    chart.guides.push_back(
        {-10 * std::log10(count),
         "unstructured noise, " + std::to_string(count) + (count == 1 ? " run" : " runs")});
  }
  auto [least, most] = extremes(chart.curves, -10, 0);
  for (const Guide& guide : chart.guides) least = std::min(least, guide.y);
  chart.y_least = std::max(-60.0, std::floor(least / 10 - 0.2) * 10);
  chart.y_most = std::ceil(most / 10 + 0.2) * 10;
  return draw(chart);
}

std::string pair_correlation_svg(const std::vector<AnalyzedSet>& sets) {
  Chart chart;
  chart.title = "Pair correlation";
  chart.x_label = "distance / mean spacing";
  chart.y_label = "g(r)";
  chart.x_most = 0;
  for (const AnalyzedSet& set : sets) {
    Curve curve;
    curve.name = set.name;
    const PairCorrelation& pairs = set.analysis.pairs;
    for (std::size_t k = 0; k < pairs.value.size(); ++k) {
      curve.x.push_back((static_cast<double>(k) + 0.5) * pairs.bin_width);
      curve.y.push_back(pairs.value[k]);
    }
    chart.x_most =
        std::max(chart.x_most, static_cast<double>(pairs.value.size()) * pairs.bin_width);
    chart.curves.push_back(std::move(curve));
  }
  if (chart.x_most == 0) chart.x_most = 1;
  chart.guides.push_back({1, "white noise"});
  chart.y_most = rounded_up(extremes(chart.curves, 0, 1.9).second * 1.05);
  return draw(chart);
}

}  // namespace ccvt::cli
