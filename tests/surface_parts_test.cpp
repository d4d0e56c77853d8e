// What surfaces are sampled with, each beside a slow obvious version.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "random.h"
#include "sampling/hilbert_key.h"
#include "support/meshes.h"
#include "surface/shares.h"
#include "surface/sheets.h"
#include "surface/triangles.h"

using namespace ccvt;
using namespace ccvt::test;

TEST_SUITE_BEGIN("surface");

TEST_CASE("the nearest point of a triangle is as near as any of a fine grid of them") {
  Random random(7);
  const auto draw = [&](double width) -> Eigen::Vector3d {
    return Eigen::Vector3d(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5) *
           width;
  };
  for (int k = 0; k < 300; ++k) {
    Eigen::Matrix3d corners;
    for (Eigen::Index i = 0; i < 3; ++i) corners.col(i) = draw(2);
    if (k % 10 == 1) corners.col(2) = corners.col(0);
    if (k % 10 == 2) corners.col(2) = (corners.col(0) + corners.col(1)) / 2;
    if (k % 10 == 3) corners.col(1) = corners.col(2) = corners.col(0);
    if (k % 10 == 4) corners.col(2) = corners.col(0) + draw(1e-9);
    const Eigen::Vector3d from = draw(4);
    const Foot foot = nearest_on_triangle(corners, from);
    CHECK(foot.shares.minCoeff() >= 0);
    CHECK(foot.shares.sum() == doctest::Approx(1).epsilon(1e-15));
    CHECK((corners * foot.shares - from).squaredNorm() == doctest::Approx(foot.squared));
    constexpr int kCuts = 60;
    double least = INFINITY;
    for (int i = 0; i <= kCuts; ++i) {
      for (int j = 0; i + j <= kCuts; ++j) {
        const Eigen::Vector3d shares(1.0 - 1.0 * (i + j) / kCuts, 1.0 * i / kCuts, 1.0 * j / kCuts);
        least = std::min(least, (corners * shares - from).norm());
      }
    }
    CHECK(std::sqrt(foot.squared) <= least + 1e-12);
    CHECK(std::sqrt(foot.squared) >= least - 4.0 / kCuts);
  }
}

TEST_CASE("sheets are what can be reached over edges that two triangles share") {
  Random random(5);
  for (int k = 0; k < 30; ++k) {
    TriangleMesh mesh;
    mesh.vertices = Columns<double>(3, 14);
    for (Eigen::Index v = 0; v < 14; ++v) {
      for (Eigen::Index d = 0; d < 3; ++d) mesh.vertices(d, v) = random.uniform();
    }
    mesh.vertices.eigen().col(13) = mesh.vertices.col(0);  // the same place
    mesh.triangles = Columns<Index>(3, 18);
    std::vector<double> areas;
    for (Index t = 0; t < 18; ++t) {
      for (Index i = 0; i < 3; ++i) mesh.triangles(i, t) = random.index_below(14);
      areas.push_back(area_of(mesh, t));
    }
    Stop stop;
    const Sheets sheets = find_sheets(mesh, areas, stop);

    // Which triangles have each edge, by comparing all; then neighbours until nothing changes.
    const auto edges = [&](Index t) {
      std::array<std::pair<Index, Index>, 3> result;
      for (Index i = 0; i < 3; ++i) {
        const Index a = mesh.triangles(i, t) % 13;
        const Index b = mesh.triangles((i + 1) % 3, t) % 13;
        result[static_cast<std::size_t>(i)] = std::minmax(a, b);
      }
      return result;
    };
    std::vector<Index> mark(18);
    std::iota(mark.begin(), mark.end(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      for (Index a = 0; a < 18; ++a) {
        for (const auto& edge : edges(a)) {
          std::vector<std::size_t> holders;
          for (Index t = 0; t < 18; ++t) {
            if (!(areas[static_cast<std::size_t>(t)] > 0)) continue;
            const auto own = edges(t);
            if (std::find(own.begin(), own.end(), edge) != own.end()) {
              holders.push_back(static_cast<std::size_t>(t));
            }
          }
          if (holders.size() != 2 || mark[holders[0]] == mark[holders[1]]) continue;
          mark[holders[0]] = mark[holders[1]] = std::min(mark[holders[0]], mark[holders[1]]);
          changed = true;
        }
      }
    }
    std::set<Index> marks;
    for (std::size_t a = 0; a < 18; ++a) {
      if (!(areas[a] > 0)) {
        CHECK(sheets.sheet[a] == -1);
        continue;
      }
      marks.insert(mark[a]);
      for (std::size_t b = 0; b < a; ++b) {
        if (!(areas[b] > 0)) continue;
        CHECK((sheets.sheet[a] == sheets.sheet[b]) == (mark[a] == mark[b]));
      }
    }
    CHECK(sheets.count == static_cast<Index>(marks.size()));
  }
}

TEST_CASE("sites are shared out by points, and own all of them") {
  Random random(9);
  for (int k = 0; k < 200; ++k) {
    std::vector<Index> groups;
    std::vector<Index> sizes;
    const Index count = 1 + random.index_below(6);
    for (Index g = 0; g < count; ++g) {
      sizes.push_back(1 + random.index_below(random.index_below(2) == 0 ? 4 : 400));
      groups.insert(groups.end(), static_cast<std::size_t>(sizes.back()), g);
    }
    const auto points = static_cast<Index>(groups.size());
    const Index sites = 1 + random.index_below(std::max(points / 4, 1));
    Index next = 0;
    Index given = 0;
    for (const Share& share : share_sites(groups, sites)) {
      CHECK(share.first == next);
      CHECK(share.sites >= 1);
      CHECK(share.sites <= share.points);
      // Of groups that no other has joined.
      const auto group = static_cast<std::size_t>(groups[static_cast<std::size_t>(next)]);
      if (share.points == sizes[group]) {
        CHECK(std::abs(share.sites - 1.0 * share.points * sites / points) < 1);
      }
      next += share.points;
      given += share.sites;
    }
    CHECK(next == points);
    CHECK(given == sites);
  }
  const auto sites_of = [](const std::vector<Index>& groups, Index sites) {
    std::vector<Index> result;
    for (const Share& share : share_sites(groups, sites)) {
      result.insert(result.end(), {share.points, share.sites});
    }
    return result;
  };
  CHECK(sites_of({0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}, 3) == std::vector<Index>{5, 1, 6, 2});
  CHECK(sites_of({0, 1, 1, 1, 1, 1, 1, 2, 2, 2}, 2) == std::vector<Index>{7, 1, 3, 1});
  CHECK(sites_of({0, 0, 0, 0, 0, 0, 0, 1}, 2) == std::vector<Index>{8, 2});
}

TEST_CASE("keys follow a Hilbert curve") {
  // Of 8 x 8 x 8 cells, each shares a face with the one before.
  std::vector<std::pair<std::uint64_t, std::array<int, 3>>> cells;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const auto at = [](int i) { return static_cast<std::uint32_t>(i) << 17U; };
        cells.push_back({hilbert_key({at(x), at(y), at(z)}), {x, y, z}});
      }
    }
  }
  std::sort(cells.begin(), cells.end());
  for (std::size_t k = 1; k < cells.size(); ++k) {
    const auto& a = cells[k - 1].second;
    const auto& b = cells[k].second;
    CHECK(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) == 1);
  }
}

TEST_SUITE_END();
