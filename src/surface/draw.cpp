#include "surface/draw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "numbers.h"
#include "sampling/hilbert_key.h"
#include "sampling/mass.h"

namespace ccvt {

namespace {

/// Where the middle of a triangle is along the curve through the box.
std::uint64_t key_of(const Triangles& triangles, Index triangle) {
  constexpr double kCells = 1 << 20;
  const Eigen::Vector3d middle = triangles.corners(triangle).rowwise().mean();
  const double side = triangles.extent().maxCoeff();
  std::array<std::uint32_t, 3> position{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double share = middle.data()[d] / side + 0.5;
    position[d] = static_cast<std::uint32_t>(std::clamp(share * kCells, 0.0, kCells - 1));
  }
  return hilbert_key(position);
}

/// The group of each sheet.
std::vector<Index> groups_of(const Sheets& sheets, const std::vector<double>& masses,
                             double least_mass) {
  std::vector<double> mass(static_cast<std::size_t>(sheets.count));
  for (std::size_t t = 0; t < masses.size(); ++t) {
    if (sheets.sheet[t] >= 0) mass[static_cast<std::size_t>(sheets.sheet[t])] += masses[t];
  }
  std::vector<Index> group(mass.size(), -1);
  Index groups = 0;
  for (std::size_t s = 0; s < mass.size(); ++s) {
    if (mass[s] >= least_mass) group[s] = groups++;
  }
  std::replace(group.begin(), group.end(), Index{-1}, groups);
  return group;
}

/// A part of a triangle. The points of parts of parts are found along a curve that enters at one
/// corner and leaves at another.
struct Part {
  Eigen::Matrix3d corners;
  Eigen::Matrix3d shares = Eigen::Matrix3d::Identity();  ///< of the corners, one a column
  Eigen::Vector3d densities;
  Eigen::Index entry = 0;
  Eigen::Index exit = 1;

  /// Becomes one of its halves, that which holds the share `at` of its mass along the curve, and
  /// makes it the share in there. The cut goes through the middle of the longest edge.
  void halve(double& at) {
    Eigen::Index a = 0;
    double longest = -1;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double squared = (corners.col(i) - corners.col((i + 1) % 3)).squaredNorm();
      if (!(squared > longest)) continue;
      longest = squared;
      a = i;
    }
    Eigen::Index b = (a + 1) % 3;
    const Eigen::Index apex = (a + 2) % 3;
    // The first half, towards a, holds the entry, the second one the exit.
    if (b == entry || (entry == apex && a == exit)) std::swap(a, b);
    const double middle = (densities[a] + densities[b]) / 2;
    const double first = densities[a] + middle + densities[apex];
    const double second = densities[b] + middle + densities[apex];
    const double share = first / (first + second);
    const bool in_first = at < share || !(second > 0);
    const Eigen::Index replaced = in_first ? b : a;
    at = std::clamp(in_first ? at / share : (at - share) / (1 - share), 0.0, 1.0);
    // The curve goes from one half to the other through the middle of the edge.
    if (in_first) {
      exit = replaced;
    } else {
      entry = replaced;
    }
    corners.col(replaced) = (corners.col(a) + corners.col(b)) / 2;
    shares.col(replaced) = (shares.col(a) + shares.col(b)) / 2;
    densities[replaced] = middle;
  }

  /// A point by density, as shares of the corners of the whole triangle. A linear density is a
  /// mixture of three that are 1 at one corner and 0 at the others; by one of these, shares are
  /// two, one and one of the four gaps between three uniform numbers in order from 0 to 1.
  [[nodiscard]] Eigen::Vector3d draw(Random& random) const {
    double at = random.uniform() * densities.sum();
    Eigen::Index corner = 0;
    while (corner < 2 && at >= densities[corner]) at -= densities[corner++];
    while (!(densities[corner] > 0)) corner = (corner + 1) % 3;  // rounding
    std::array<double, 3> cut = {random.uniform(), random.uniform(), random.uniform()};
    std::sort(cut.begin(), cut.end());
    Eigen::Vector3d own;
    own[corner] = cut[1];
    own[(corner + 1) % 3] = cut[2] - cut[1];
    own[(corner + 2) % 3] = 1 - cut[2];
    return shares * own;
  }
};

}  // namespace

TriangleLine line_up(const Triangles& triangles, const Sheets& sheets,
                     const std::vector<double>& masses, double least_mass) {
  struct Entry {
    Index group;
    Index triangle;
    std::uint64_t key;
  };
  const std::vector<Index> group = groups_of(sheets, masses, least_mass);
  std::vector<Entry> entries;
  for (std::size_t t = 0; t < masses.size(); ++t) {
    if (!(masses[t] > 0)) continue;
    const auto triangle = static_cast<Index>(t);
    entries.push_back(
        {group[static_cast<std::size_t>(sheets.sheet[t])], triangle, key_of(triangles, triangle)});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.group, a.key, a.triangle) < std::tie(b.group, b.key, b.triangle);
  });
  TriangleLine line;
  GroupedSum sum;
  for (const Entry& entry : entries) {
    line.triangle.push_back(entry.triangle);
    line.group.push_back(entry.group);
    sum.add(masses[static_cast<std::size_t>(entry.triangle)]);
    line.end.push_back(sum.value());
  }
  return line;
}

SurfacePoint SurfaceDraws::draw(std::size_t number, Random& random) const {
  const double part = line_.mass() / count_;
  const double target = (static_cast<double>(number) + random.uniform()) * part;
  auto found = std::upper_bound(line_.end.begin(), line_.end.end(), target);
  if (found == line_.end.end()) --found;  // rounding
  const auto k = static_cast<std::size_t>(found - line_.end.begin());
  const double begin = k > 0 ? line_.end[k - 1] : 0;
  double mass = line_.end[k] - begin;
  double at = std::clamp((target - begin) / mass, 0.0, 1.0);

  SurfacePoint point{line_.group[k], line_.triangle[k], {}};
  Part half;
  half.corners = triangles_.corners(point.triangle);
  half.densities = triangles_.densities(point.triangle);
  half.densities /= half.densities.maxCoeff();
  while (mass > part) {
    const double before = half.densities.sum();
    half.halve(at);
    mass *= half.densities.sum() / before / 2;
  }
  point.shares = half.draw(random);
  point.shares[0] = std::max(1 - point.shares[1] - point.shares[2], 0.0);
  return point;
}

}  // namespace ccvt
