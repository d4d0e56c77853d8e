// Prints the tables of results/thin/report.md, and draws README's picture of a thinned scan.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/thin.h"
#include "geometry/metric.h"
#include "random.h"
#include "spatial/site_tree.h"
#include "support/baselines.h"
#include "support/machine.h"

namespace {

using ccvt::Index;
using Cloud = Eigen::Matrix3Xf;
using ccvt::bench::Chosen;

constexpr double kPi = 3.14159265358979323846;

/// A cloud on a surface, and how far apart `n` points of its density are in a hexagonal lattice.
struct Scan {
  Cloud points;
  Cloud normals;
  std::function<double(Index point, double n)> spacing;
};

Eigen::Vector3d on_sphere(ccvt::Random& random) {
  const double z = 2 * random.uniform() - 1;
  const double turn = 2 * kPi * random.uniform();
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

/// The unit sphere, evenly dense, with noise of a thousandth along the normal.
Scan sphere(Index count, std::uint64_t seed) {
  ccvt::Random random(seed);
  Scan scan{Cloud(3, count), Cloud(3, count), {}};
  for (Index p = 0; p < count; ++p) {
    const Eigen::Vector3d n = on_sphere(random);
    scan.points.col(p) = (n * (1 + 0.002 * (random.uniform() - 0.5))).cast<float>();
    scan.normals.col(p) = n.cast<float>();
  }
  scan.spacing = [](Index, double n) { return std::sqrt(2 * 4 * kPi / (std::sqrt(3.0) * n)); };
  return scan;
}

/// The same sphere, nine times as dense at one pole as at the other.
Scan uneven(Index count, std::uint64_t seed) {
  ccvt::Random random(seed);
  Scan scan{Cloud(3, count), Cloud(3, count), {}};
  for (Index p = 0; p < count;) {
    const Eigen::Vector3d n = on_sphere(random);
    if (random.uniform() > (5 + 4 * n.z()) / 9) continue;
    scan.points.col(p) = (n * (1 + 0.002 * (random.uniform() - 0.5))).cast<float>();
    scan.normals.col(p++) = n.cast<float>();
  }
  const Cloud directions = scan.normals;
  scan.spacing = [directions](Index p, double n) {
    const double density = n / (4 * kPi) * (5 + 4 * static_cast<double>(directions(2, p))) / 5;
    return std::sqrt(2 / (std::sqrt(3.0) * density));
  };
  return scan;
}

struct Figures {
  double smallest = 1e9;
  double mean = 0;
  double energy = 0;  ///< mean squared distance of a point to its nearest chosen one
};

/// In spacings of the lattice.
Figures measure(const Scan& scan, const Chosen& chosen) {
  const ccvt::Metric metric(3, ccvt::Domain());
  std::vector<double> at;
  for (const Index c : chosen) {
    for (int d = 0; d < 3; ++d) at.push_back(static_cast<double>(scan.points(d, c)));
  }
  const ccvt::SiteTree tree(metric, at);
  const auto position = [&](Index k) { return at.data() + 3 * static_cast<std::size_t>(k); };
  const auto n = static_cast<double>(chosen.size());
  Figures figures;
  std::vector<Index> two;
  for (Index k = 0; k < static_cast<Index>(chosen.size()); ++k) {
    two.clear();
    tree.nearest(position(k), 2, two);
    double squared = 0;
    for (const Index other : two) {
      squared = std::max(squared, metric.squared_distance(position(k), position(other)));
    }
    const double distance =
        std::sqrt(squared) / scan.spacing(chosen[static_cast<std::size_t>(k)], n);
    figures.smallest = std::min(figures.smallest, distance);
    figures.mean += distance / n;
  }
  const auto count = static_cast<double>(scan.points.cols());
  for (Index p = 0; p < scan.points.cols(); ++p) {
    const Eigen::Vector3d query = scan.points.col(p).cast<double>();
    const double squared =
        metric.squared_distance(query.data(), position(tree.nearest(query.data())));
    const double spacing = scan.spacing(p, n);
    figures.energy += squared / (spacing * spacing) / count;
  }
  return figures;
}

void print_row(const Scan& scan, double ratio, const char* name, const Chosen& chosen,
               double seconds) {
  const Figures figures = measure(scan, chosen);
  std::printf("| %g:1 | %s | %zu | %.3f | %.3f | %.4f | %.2f |\n", ratio, name, chosen.size(),
              figures.smallest, figures.mean, figures.energy, seconds);
  std::fflush(stdout);
}

template <class Choose>
void row(const Scan& scan, double ratio, const char* name, const Choose& choose) {
  // Of the processor, as all run on one thread: other programs do not count.
  const std::clock_t start = std::clock();
  const Chosen chosen = choose();
  const auto ticks = static_cast<double>(std::clock() - start);
  print_row(scan, ratio, name, chosen, ticks / CLOCKS_PER_SEC);
}

ccvt::ThinOptions one_thread(bool spread) {
  ccvt::ThinOptions options;
  options.spread = spread;
  options.equal_counts = true;
  options.tessellation.threads = 1;
  return options;
}

/// All methods at each ratio.
void table(const char* title, const Scan& scan, const std::vector<double>& ratios) {
  std::printf("## %s, %d points\n\n", title, static_cast<int>(scan.points.cols()));
  std::printf(
      "| ratio | method | chosen | smallest distance | mean distance | energy | CPU seconds |\n"
      "|---|---|---|---|---|---|---|\n");
  for (const double ratio : ratios) {
    const auto n = static_cast<Index>(std::lround(static_cast<double>(scan.points.cols()) / ratio));
    double own_energy = 0;
    row(scan, ratio, "random", [&] { return ccvt::bench::random_choice(scan.points, n, 1); });
    row(scan, ratio, "voxel grid", [&] { return ccvt::bench::voxel_choice(scan.points, n); });
    if (static_cast<double>(n) * static_cast<double>(scan.points.cols()) <= 4e9) {
      row(scan, ratio, "farthest point", [&] { return ccvt::bench::farthest(scan.points, n); });
    }
    row(scan, ratio, "sample elimination",
        [&] { return ccvt::bench::sample_elimination(scan.points, n, 4 * kPi); });
    row(scan, ratio, "nearest to centroids",
        [&] { return ccvt::thin(scan.points, n, one_thread(false)).chosen; });
    row(scan, ratio, "**thin**", [&] {
      const ccvt::Thinning result = ccvt::thin(scan.points, n, one_thread(true));
      own_energy = result.energy;
      return result.chosen;
    });
    const double spacing = scan.spacing(0, n);
    if (std::string(title).find("even") == std::string::npos) continue;
    std::printf("| %g:1 | thin, to the chosen point of its own cell | | | | %.4f | |\n", ratio,
                own_energy / static_cast<double>(scan.points.cols()) / (spacing * spacing));
  }
  std::printf("\n");
}

/// Where points are seen: to the right, up, and towards whoever looks.
Eigen::Vector3f seen(const Eigen::Vector3f& point) {
  return Eigen::AngleAxisf(-0.9F, Eigen::Vector3f::UnitX()) * point;
}

/// Calls visit(u, v) for the pixels of a disk around a point, of those there are.
template <class Visit>
void for_each_pixel(const Eigen::Vector3f& at, int radius, int width, int height,
                    const Visit& visit) {
  const auto x = static_cast<int>((at.x() / 1.55F + 1) * static_cast<float>(width) / 2);
  const auto y = static_cast<int>(static_cast<float>(height) / 2 -
                                  at.y() / 1.55F * static_cast<float>(width) / 2);
  for (int v = std::max(0, y - radius); v <= std::min(height - 1, y + radius); ++v) {
    for (int u = std::max(0, x - radius); u <= std::min(width - 1, x + radius); ++u) {
      if ((u - x) * (u - x) + (v - y) * (v - y) <= radius * radius) visit(u, v);
    }
  }
}

/// Draws chosen points as disks, but for those behind the surface that all points make.
void draw(const Cloud& points, const std::vector<Index>& which, int left, int width, int radius,
          ccvt::ColourImage& image) {
  std::vector<float> depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(image.height),
                           -9);
  const auto depth_at = [&](int u, int v) -> float& {
    return depth[static_cast<std::size_t>(v * width + u)];
  };
  for (Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3f at = seen(points.col(p));
    for_each_pixel(at, 5, width, image.height,
                   [&](int u, int v) { depth_at(u, v) = std::max(depth_at(u, v), at.z()); });
  }
  for (const Index p : which) {
    const Eigen::Vector3f at = seen(points.col(p));
    const float turn = std::atan2(points(1, p), points(0, p));
    const float shade = std::clamp(0.75F + 0.35F * at.z(), 0.35F, 1.0F);
    for_each_pixel(at, radius, width, image.height, [&](int u, int v) {
      if (at.z() < depth_at(u, v) - 0.12F) return;
      for (int c = 0; c < 3; ++c) {
        const float hue = 0.5F + 0.4F * std::cos(turn + 2.1F * static_cast<float>(c));
        image.rgb[static_cast<std::size_t>(3 * (v * image.width + left + u) + c)] =
            static_cast<std::uint8_t>(255 * hue * shade);
      }
    });
  }
}

/// A torus with bumps, evenly sampled but for chance.
Cloud bumpy_torus(Index count) {
  ccvt::Random random(3);
  Cloud points(3, count);
  for (Index p = 0; p < count;) {
    const double u = 2 * kPi * random.uniform();
    const double v = 2 * kPi * random.uniform();
    if (random.uniform() > (1 + 0.4 * std::cos(v)) / 1.4) continue;
    const double r = 0.4 + 0.03 * std::sin(7 * u) * std::sin(5 * v);
    points.col(p++) = Eigen::Vector3d((1 + r * std::cos(v)) * std::cos(u),
                                      (1 + r * std::cos(v)) * std::sin(u), r * std::sin(v))
                          .cast<float>();
  }
  return points;
}

/// The scan, a random choice from it, and a thinned one.
void picture(const char* path) {
  constexpr int kWidth = 420;
  constexpr int kHeight = 300;
  constexpr Index kPoints = 60'000;
  constexpr Index kChosen = 6'000;
  const Cloud points = bumpy_torus(kPoints);
  std::vector<Index> all(static_cast<std::size_t>(kPoints));
  std::iota(all.begin(), all.end(), 0);
  ccvt::ColourImage image{3 * kWidth, kHeight, {}};
  image.rgb.assign(static_cast<std::size_t>(3 * kWidth * kHeight * 3), 255);
  draw(points, all, 0, kWidth, 0, image);
  draw(points, ccvt::bench::random_choice(points, kChosen, 1), kWidth, kWidth, 1, image);
  draw(points, ccvt::thin(points, kChosen).chosen, 2 * kWidth, kWidth, 1, image);
  ccvt::write_png(path, image);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "all";
  if (what == "picture" && argc > 2) {
    picture(argv[2]);
    return 0;
  }
  const Index count = argc > 2 ? std::atoi(argv[2]) : 200'000;
  if ((what != "all" && what != "even" && what != "uneven") || count < 4000) {
    std::fprintf(stderr, "usage: thin_benchmark [all|even|uneven [POINTS]] | picture FILE.png\n");
    return 2;
  }
  std::printf("%s\n\n", ccvt::bench::machine_line(ccvt::bench::machine()).c_str());
  if (what != "uneven") table("An evenly dense sphere", sphere(count, 7), {2, 4, 10, 100, 1000});
  if (what != "even")
    table("A sphere nine times as dense at one pole", uneven(count, 7), {4, 10, 100});
  return 0;
}
