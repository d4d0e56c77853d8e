// Prints how even samples are in spaces that are not a box with one unit, and around sites that
// stay, and draws them: spaces_benchmark FILE.svg

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/linear_map.h"
#include "ccvt/region.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/version.h"

namespace {

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Problem;
using Sites = Eigen::Matrix2Xd;

constexpr Index kSites = 600;
constexpr Index kPointsPerSite = 256;

struct Panel {
  std::string title;
  Sites sites;           ///< in the unit square
  Index fixed = 0;       ///< the first of them
  double smallest = 0;   ///< distance, where distances are measured
  double hexagonal = 0;  ///< that of the hexagonal lattice of as many sites
  Index put_back = 0;
};

/// The smallest distance of two sites, along each dimension round the box or not.
double smallest_distance(const Sites& sites, const std::vector<bool>& round) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index a = 0; a < sites.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      Eigen::Array2d u = (sites.col(a) - sites.col(b)).array().abs();
      for (int d = 0; d < 2; ++d) {
        if (round[static_cast<std::size_t>(d)]) u[d] = std::min(u[d], 1 - u[d]);
      }
      smallest = std::min(smallest, u.matrix().norm());
    }
  }
  return smallest;
}

double hexagonal(double area) { return std::sqrt(2 * area / (std::sqrt(3.0) * kSites)); }

Sites points() { return ccvt::sample_uniform<double, 2>(Box::unit(2), kSites * kPointsPerSite, 1); }

/// Samples added to a grid of 5 x 5 that stay.
Panel around_fixed() {
  const Sites all = points();
  Sites fixed(2, 25);
  for (int k = 0; k < 25; ++k) fixed.col(k) << 0.1 + 0.2 * (k % 5), 0.1 + 0.2 * (k / 5);
  Problem problem(all, kSites);
  problem.set_domain(Domain::periodic(Box::unit(2))).set_fixed_sites(fixed);
  const Sites sites = ccvt::tessellate(problem, Options::samples()).sites;
  return {"25 fixed sites, 575 added", sites, 25, smallest_distance(sites, {true, true}),
          hexagonal(1)};
}

Panel tube() {
  const Sites all = points();
  Problem problem(all, kSites);
  problem.set_domain(Domain::periodic(Box::unit(2), {true, false}));
  const Sites sites = ccvt::tessellate(problem, Options::samples()).sites;
  return {"periodic from left to right only", sites, 0, smallest_distance(sites, {true, false}),
          hexagonal(1)};
}

Panel units() {
  const auto map = ccvt::LinearMap::units({1, 3});
  const Sites all = map(points());
  const Sites sites = ccvt::tessellate(all, kSites, Options::samples()).sites;
  return {"upward, a unit counts thrice", map.inverse(sites), 0,
          smallest_distance(sites, {false, false}), hexagonal(3)};
}

Panel region() {
  constexpr double kOuter = 0.49;
  constexpr double kHole = 0.11;
  const auto inside = [](std::span<const double> x) {
    const auto from = [&x](double a, double b) { return std::hypot(x[0] - a, x[1] - b); };
    return from(0.5, 0.5) < kOuter && from(0.33, 0.6) > kHole && from(0.67, 0.6) > kHole &&
           from(0.5, 0.28) > kHole;
  };
  const Sites all =
      ccvt::sample_region<double, 2>(inside, Box::unit(2), kSites * kPointsPerSite, 1);
  auto result = ccvt::tessellate(all, kSites, Options::samples());
  Sites sites = result.sites;
  const Index moved = ccvt::put_back(all, result.owners, sites, inside).sites;
  const double area = std::numbers::pi * (kOuter * kOuter - 3 * kHole * kHole);
  return {"a region with three holes",
          sites,
          0,
          smallest_distance(sites, {false, false}),
          hexagonal(area),
          moved};
}

std::string picture(const std::vector<Panel>& panels) {
  constexpr int kSide = 250;
  constexpr int kStep = kSide + 14;
  std::string svg = "<svg xmlns='http://www.w3.org/2000/svg' width='" +
                    std::to_string(kStep * static_cast<int>(panels.size()) + 14) + "' height='" +
                    std::to_string(kSide + 44) +
                    "' font-family='sans-serif' font-size='13'>"
                    "<rect width='100%' height='100%' fill='white'/>\n";
  int left = 14;
  char text[160];
  for (const Panel& panel : panels) {
    svg += "<g transform='translate(" + std::to_string(left) + " 30)'><text y='-9'>" + panel.title +
           "</text><rect width='250' height='250' fill='none' stroke='#bbb'/>\n";
    for (Eigen::Index s = 0; s < panel.sites.cols(); ++s) {
      const bool fixed = s < panel.fixed;
      std::snprintf(text, sizeof text, "<circle cx='%.2f' cy='%.2f' r='%s' fill='%s'/>\n",
                    kSide * panel.sites(0, s), kSide * (1 - panel.sites(1, s)),
                    fixed ? "3.2" : "2.1", fixed ? "#c0392b" : "#222");
      svg += text;
    }
    svg += "</g>\n";
    left += kStep;
  }
  return svg + "</svg>\n";
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc > 2) {
    std::fprintf(stderr, "usage: spaces_benchmark [FILE.svg]\n");
    return 2;
  }
  std::printf("ccvt %s, %s\n\n", CCVT_VERSION, __VERSION__);
  const std::vector<Panel> panels = {around_fixed(), tube(), units(), region()};
  std::printf(
      "%d sites of %d points. Smallest distance, where distances are measured, as a share of the\n"
      "hexagonal lattice's:\n\n| | smallest distance | sites put back |\n|---|---|---|\n",
      kSites, kPointsPerSite);
  for (const Panel& panel : panels) {
    std::printf("| %s | %.3f | %d |\n", panel.title.c_str(), panel.smallest / panel.hexagonal,
                panel.put_back);
  }
  if (argc == 2) ccvt::write_text(argv[1], picture(panels));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "spaces_benchmark: %s\n", error.what());
  return 1;
}
