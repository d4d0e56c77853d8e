// Prints the table of benchmarks/README.md about points with masses: whole points, stratified unit
// points, and unit points drawn at random.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/lloyd.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/version.h"
#include "ccvt/weighted.h"
#include "random.h"

namespace {

using ccvt::Index;
using ccvt::Points;

struct Weighted {
  std::string name;
  Points<float> points;
  std::vector<double> masses;
};

/// What whole points cost, whoever made the owners: sites are the centres of mass of the cells.
struct Figures {
  double energy = 0;   ///< normalized by total mass and bounding box
  double largest = 0;  ///< mass error, as a share of the capacity
  double mean = 0;     ///< root mean square of that
  double seconds = 0;
};

Figures figures_of(const Weighted& data, Index sites, const std::vector<Index>& owners) {
  const auto dimension = static_cast<int>(data.points.rows());
  Eigen::MatrixXd centre = Eigen::MatrixXd::Zero(dimension, sites);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(sites);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    const auto x = data.points.col(static_cast<Eigen::Index>(p)).cast<double>();
    centre.col(owners[p]) += data.masses[p] * x;
    mass[owners[p]] += data.masses[p];
  }
  for (Index s = 0; s < sites; ++s) centre.col(s) /= std::max(mass[s], 1e-300);
  double energy = 0;
  for (std::size_t p = 0; p < owners.size(); ++p) {
    const auto x = data.points.col(static_cast<Eigen::Index>(p)).cast<double>();
    energy += data.masses[p] * (x - centre.col(owners[p])).squaredNorm();
  }
  const Eigen::VectorXf extent =
      data.points.rowwise().maxCoeff() - data.points.rowwise().minCoeff();
  Figures figures;
  figures.energy =
      energy / mass.sum() * std::pow(sites / extent.cast<double>().prod(), 2.0 / dimension);
  const Eigen::ArrayXd relative = mass.array() * (sites / mass.sum()) - 1;
  figures.largest = relative.abs().maxCoeff();
  figures.mean = std::sqrt(relative.square().mean());
  return figures;
}

/// Unit points drawn independently, in proportion to the masses, as a program without masses would
/// be used: a point goes to the site of most of its unit points, or else to the nearest one.
std::vector<Index> owners_of_draws(const Weighted& data, Index sites, Index points_per_site,
                                   std::uint64_t seed) {
  std::vector<double> until(data.masses.size());
  double total = 0;
  for (std::size_t p = 0; p < until.size(); ++p) until[p] = total += data.masses[p];
  ccvt::Random random(seed, 77);
  const Index count = sites * points_per_site;
  std::vector<std::size_t> drawn(static_cast<std::size_t>(count));
  for (auto& point : drawn) {
    const double at = random.uniform() * total;
    point = std::min(
        static_cast<std::size_t>(std::upper_bound(until.begin(), until.end(), at) - until.begin()),
        until.size() - 1);
  }
  std::sort(drawn.begin(), drawn.end());
  Points<float> units(data.points.rows(), count);
  for (Index k = 0; k < count; ++k) {
    units.col(k) = data.points.col(static_cast<Eigen::Index>(drawn[static_cast<std::size_t>(k)]));
  }
  const auto result = ccvt::tessellate(units, sites, {.threads = 1, .seed = seed});
  // Nearest sites by a run of plain Lloyd that takes no step.
  std::vector<Index> owners;
  {
    ccvt::Problem<float> problem(data.points, sites);
    problem.set_initial_sites(result.sites);
    owners = ccvt::lloyd(problem, {.threads = 1, .max_iterations = 0}).owners;
  }
  for (std::size_t begin = 0, end = 0; begin < drawn.size(); begin = end) {
    std::vector<Index> own;
    for (; end < drawn.size() && drawn[end] == drawn[begin]; ++end)
      own.push_back(result.owners[end]);
    std::sort(own.begin(), own.end());
    std::size_t most = 0;
    for (std::size_t a = 0, b = 0; a < own.size(); a = b) {
      while (b < own.size() && own[b] == own[a]) ++b;
      if (b - a <= most) continue;
      most = b - a;
      owners[drawn[begin]] = own[a];
    }
  }
  return owners;
}

std::string percent(double share) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
  return text;
}

void print_row(const char* how, const Figures& figures, const std::string& bound) {
  std::printf("| %s | %.4f | %.3g %% | %.3g %% | %s | %.2f |\n", how, figures.energy,
              100 * figures.largest, 100 * figures.mean, bound.c_str(), figures.seconds);
  std::fflush(stdout);
}

Figures timed(const Weighted& data, Index sites, const std::function<std::vector<Index>()>& run) {
  const std::clock_t start = std::clock();  // of this process alone, on whatever machine
  const std::vector<Index> owners = run();
  const double time = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  Figures figures = figures_of(data, sites, owners);
  figures.seconds = time;
  return figures;
}

void compare(const Weighted& data, Index sites) {
  const auto heaviest = *std::max_element(data.masses.begin(), data.masses.end());
  double total = 0;
  for (const double mass : data.masses) total += mass;
  std::printf("## %s: %zu points, %d sites; the heaviest point is %.3g %% of a capacity\n\n",
              data.name.c_str(), data.masses.size(), sites, 100 * heaviest * sites / total);
  std::printf(
      "| method | energy of whole points | largest mass error | root mean square | bound | "
      "seconds |\n|---|---|---|---|---|---|\n");
  for (const Index points_per_site : {64, 256}) {
    const std::string each = std::to_string(points_per_site);
    for (const auto method : {ccvt::MassMethod::whole, ccvt::MassMethod::resampled}) {
      if (method == ccvt::MassMethod::whole && heaviest * sites > total) continue;
      ccvt::MassOptions options;
      options.method = method;
      options.points_per_site = points_per_site;
      options.relaxation.threads = 1;
      options.relaxation.seed = 1;
      std::string bound = "none";
      std::string own;
      const Figures figures = timed(data, sites, [&] {
        auto result = ccvt::tessellate_masses(data.points, data.masses, sites, options);
        if (method == ccvt::MassMethod::whole) {
          bound = percent(result.mass_error_bound * sites / result.total_mass);
        }
        char line[300];
        std::snprintf(line, sizeof line,
                      "%s, %d iterations; own energy %.4f, largest error %.3g %%, "
                      "root mean square %.3g %%; units %.2f s, the rest %.2f s",
                      to_string(result.summary.termination), result.summary.iterations,
                      result.summary.normalized_energy,
                      100 * result.largest_mass_error * sites / result.total_mass,
                      100 * result.relative_mass_error,
                      result.summary.seconds_total - result.summary.phases.back().seconds,
                      result.summary.phases.back().seconds);
        own = line;
        return std::move(result.owners);
      });
      const std::string name = std::string(to_string(method)) + ", " + each + " units a site";
      print_row(name.c_str(), figures, bound);
      std::fprintf(stderr, "%s: %s\n", name.c_str(), own.c_str());
    }
    const std::string name = "drawn at random, " + each + " a site";
    print_row(name.c_str(),
              timed(data, sites, [&] { return owners_of_draws(data, sites, points_per_site, 1); }),
              "none");
  }
  std::printf("\n");
}

/// The pixels of a picture, enlarged bilinearly, weighed by their darkness.
Weighted picture(const std::string& file, int enlarged) {
  const ccvt::Image image = ccvt::read_image(file);
  const int width = image.width * enlarged;
  const int height = image.height * enlarged;
  Weighted data;
  data.name = "A picture of " + std::to_string(width) + " x " + std::to_string(height);
  data.points.resize(2, static_cast<Eigen::Index>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto along = [enlarged](int k, int count, int& low) {
        const double at = std::clamp((k + 0.5) / enlarged - 0.5, 0.0, count - 1.0);
        low = std::min(static_cast<int>(at), count - 2);
        return at - low;
      };
      int left = 0;
      int top = 0;
      const double u = along(x, image.width, left);
      const double v = along(y, image.height, top);
      const double value = (1 - v) * ((1 - u) * static_cast<double>(image(left, top)) +
                                      u * static_cast<double>(image(left + 1, top))) +
                           v * ((1 - u) * static_cast<double>(image(left, top + 1)) +
                                u * static_cast<double>(image(left + 1, top + 1)));
      data.points.col(static_cast<Eigen::Index>(data.masses.size())) << static_cast<float>(x) + .5F,
          static_cast<float>(y) + .5F;
      data.masses.push_back(std::max(0.0, 1 - value));
    }
  }
  return data;
}

/// Points in a cube with masses of a Pareto distribution.
Weighted particles(Index count, double exponent, std::uint64_t seed) {
  Weighted data;
  char name[100];
  std::snprintf(name, sizeof name, "Particles in 3D, Pareto masses of exponent %.2g", exponent);
  data.name = name;
  data.points =
      ccvt::sample_uniform<float>(ccvt::Box::unit(3), count, seed, ccvt::Distribution::white);
  ccvt::Random random(seed, 78);
  for (Index p = 0; p < count; ++p) {
    data.masses.push_back(std::pow(1 - random.uniform(), -1 / exponent));
  }
  return data;
}

/// Clouds of points in the plane with masses of a heavy tail, each a disc as large as its mass, in
/// the colour of its cell; centres of mass are black.
void draw(const std::string& file) {
  constexpr int kWidth = 1200;
  constexpr int kHeight = 600;
  constexpr Index kPoints = 5000;
  constexpr Index kSites = 60;
  ccvt::Random random(4);
  Points<float> points(2, kPoints);
  std::vector<double> masses;
  for (Index p = 0; p < kPoints; ++p) {
    const double cloud = random.uniform() < 0.6 ? 1 : 0;
    const double radius = 260 * std::pow(random.uniform(), 0.5 + cloud);
    const double angle = 6.283185307179586 * random.uniform();
    const double x = (cloud > 0 ? 330 : 860) + radius * (cloud > 0 ? 1.1 : 1.25) * std::cos(angle);
    points.col(p) << static_cast<float>(x), static_cast<float>(300 + radius * std::sin(angle));
    masses.push_back(std::min(150.0, std::pow(1 - random.uniform(), -1 / 1.3)));
  }
  const auto result = ccvt::tessellate_masses(points, masses, kSites);
  std::printf("%s, %s\n", result.summary.brief().c_str(), result.brief_error().c_str());
  constexpr int kFine = 3;  // subpixels
  std::vector<std::array<float, 3>> fine(static_cast<std::size_t>(kWidth) * kHeight * kFine * kFine,
                                         {1, 1, 1});
  const auto disc = [&](double x, double y, double radius, const std::array<float, 3>& colour) {
    const auto range = [&](double at, int most) {
      return std::pair(std::max(0, static_cast<int>((at - radius) * kFine)),
                       std::min(most * kFine - 1, static_cast<int>((at + radius) * kFine)));
    };
    const auto [left, right] = range(x, kWidth);
    const auto [top, bottom] = range(y, kHeight);
    for (int v = top; v <= bottom; ++v) {
      for (int u = left; u <= right; ++u) {
        if (std::hypot((u + 0.5) / kFine - x, (v + 0.5) / kFine - y) > radius) continue;
        fine[static_cast<std::size_t>(v) * kWidth * kFine + static_cast<std::size_t>(u)] = colour;
      }
    }
  };
  std::vector<std::size_t> order(masses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return masses[a] > masses[b]; });
  for (const std::size_t p : order) {
    const auto k = static_cast<Eigen::Index>(p);
    std::array<float, 3> colour{};
    for (std::size_t c = 0; c < 3; ++c) {  // a hue for each cell, by the golden angle
      const double hue = 2.399963 * result.owners[p] - 2.0943951 * static_cast<double>(c);
      const double light = 0.5 + 0.13 * (result.owners[p] % 3);
      colour[c] = static_cast<float>(std::clamp(light + 0.32 * std::cos(hue), 0.0, 1.0));
    }
    disc(static_cast<double>(points(0, k)), static_cast<double>(points(1, k)),
         1.3 * std::sqrt(masses[p]), colour);
  }
  for (Index s = 0; s < kSites; ++s) {
    const double x = static_cast<double>(result.sites(0, s));
    const double y = static_cast<double>(result.sites(1, s));
    disc(x, y, 5.5, {1, 1, 1});
    disc(x, y, 4, {0, 0, 0});
  }
  ccvt::ColourImage image{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        float sum = 0;
        for (int v = y * kFine; v < (y + 1) * kFine; ++v) {
          for (int u = x * kFine; u < (x + 1) * kFine; ++u) {
            sum +=
                fine[static_cast<std::size_t>(v) * kWidth * kFine + static_cast<std::size_t>(u)][c];
          }
        }
        image.rgb.push_back(static_cast<std::uint8_t>(std::lround(255 * sum / (kFine * kFine))));
      }
    }
  }
  ccvt::write_png(file, image);
}

int run(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "all";
  const std::string file = argc > 2 ? argv[2] : "tests/data/camera.png";
  const std::vector<std::string> known{"all", "picture", "particles", "draw"};
  if (std::find(known.begin(), known.end(), what) == known.end()) {
    std::fprintf(stderr,
                 "usage: weighted_benchmark [all|picture|particles] [PICTURE]\n"
                 "       weighted_benchmark draw FIGURE.png\n");
    return 2;
  }
  if (what == "draw") {
    draw(argc > 2 ? argv[2] : "masses.png");
    return 0;
  }
  std::printf("ccvt %s, %s\n\n", CCVT_VERSION, __VERSION__);
  const bool all = what == "all";
  if (all || what == "picture") {
    compare(picture(file, 1), 20000);
    compare(picture(file, 2), 20000);
    compare(picture(file, 2), 2000);
  }
  if (all || what == "particles") {
    for (const double exponent : {4.0, 2.5, 1.5}) compare(particles(500'000, exponent, 1), 2000);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weighted_benchmark: %s\n", error.what());
    return 1;
  }
}
