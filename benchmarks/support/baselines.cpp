#include "support/baselines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <unordered_map>
#include <utility>

#include "random.h"

namespace ccvt::bench {
namespace {

using Cloud = Eigen::Matrix3Xf;

/// Points by the cell of a grid that they are in.
class Grid {
 public:
  Grid(const Cloud& points, double width) : points_(points), width_(width) {
    lower_ = points.rowwise().minCoeff().cast<double>();
    for (Index p = 0; p < static_cast<Index>(points.cols()); ++p) cells_[key(p)].push_back(p);
  }
  [[nodiscard]] const auto& cells() const { return cells_; }

  /// Calls visit(q, distance) for each other point nearer than the width.
  template <class Visit>
  void near(Index p, const Visit& visit) const {
    const auto at = coordinates(p);
    for (std::int64_t z = at[2] - 1; z <= at[2] + 1; ++z) {
      for (std::int64_t y = at[1] - 1; y <= at[1] + 1; ++y) {
        for (std::int64_t x = at[0] - 1; x <= at[0] + 1; ++x) {
          const auto cell = cells_.find(key_of({x, y, z}));
          if (cell == cells_.end()) continue;
          for (const Index q : cell->second) {
            if (q == p) continue;
            const auto distance = static_cast<double>((points_.col(p) - points_.col(q)).norm());
            if (distance < width_) visit(q, distance);
          }
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  [[nodiscard]] Cell coordinates(Index p) const {
    Cell cell{};
    for (int d = 0; d < 3; ++d) {
      cell.at(static_cast<std::size_t>(d)) = static_cast<std::int64_t>(
          std::floor((static_cast<double>(points_(d, p)) - lower_[d]) / width_));
    }
    return cell;
  }
  static std::int64_t key_of(const Cell& cell) {
    return (cell[0] + 1) + ((cell[1] + 1) << 20) + ((cell[2] + 1) << 40);
  }
  [[nodiscard]] std::int64_t key(Index p) const { return key_of(coordinates(p)); }

  const Cloud& points_;
  double width_;
  Eigen::Vector3d lower_;
  std::unordered_map<std::int64_t, std::vector<Index>> cells_;
};

}  // namespace

Chosen random_choice(const Cloud& points, Index count, std::uint64_t seed) {
  Chosen all(static_cast<std::size_t>(points.cols()));
  std::iota(all.begin(), all.end(), 0);
  Random(seed).shuffle(std::span(all));
  all.resize(static_cast<std::size_t>(count));
  return all;
}

Chosen voxel_choice(const Cloud& points, Index count) {
  const Eigen::Vector3f extent = points.rowwise().maxCoeff() - points.rowwise().minCoeff();
  double small = static_cast<double>(extent.maxCoeff()) * 1e-4;
  auto large = static_cast<double>(extent.maxCoeff());
  for (int k = 0; k < 24; ++k) {
    const double middle = std::sqrt(small * large);
    const bool many = Grid(points, middle).cells().size() > static_cast<std::size_t>(count);
    (many ? small : large) = middle;
  }
  Chosen chosen;
  const Grid grid(points, large);
  for (const auto& [key, members] : grid.cells()) {
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    for (const Index p : members) centre += points.col(p) / static_cast<float>(members.size());
    chosen.push_back(*std::min_element(members.begin(), members.end(), [&](Index a, Index b) {
      return (points.col(a) - centre).squaredNorm() < (points.col(b) - centre).squaredNorm();
    }));
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

Chosen farthest(const Cloud& points, Index count) {
  Chosen chosen{0};
  Eigen::VectorXf nearest =
      Eigen::VectorXf::Constant(points.cols(), std::numeric_limits<float>::infinity());
  while (static_cast<Index>(chosen.size()) < count) {
    const Eigen::Vector3f last = points.col(chosen.back());
    float most = -1;
    Index next = 0;
    for (Index p = 0; p < static_cast<Index>(points.cols()); ++p) {
      float& own = nearest[p];
      own = std::min(own, (points.col(p) - last).squaredNorm());
      if (own > most) {
        most = own;
        next = p;
      }
    }
    chosen.push_back(next);
  }
  return chosen;
}

Chosen sample_elimination(const Cloud& points, Index count, double area) {
  const auto all = static_cast<double>(points.cols());
  const double n = count;
  // Twice r_max, the largest radius of as many disks on a surface [eq. 3].
  const double reach = 2 * std::sqrt(area / (2 * std::sqrt(3.0) * n));
  const double limit = reach * (1 - std::pow(n / all, 1.5)) * 0.65;
  const auto weight = [&](double distance) {
    const double near = 1 - std::max(distance, limit) / reach;
    const double fourth = near * near * near * near;
    return fourth * fourth;
  };
  const Grid grid(points, reach);
  std::vector<double> sum(static_cast<std::size_t>(points.cols()), 0.0);
  std::priority_queue<std::pair<double, Index>> heap;
  for (Index p = 0; p < static_cast<Index>(points.cols()); ++p) {
    double& own = sum[static_cast<std::size_t>(p)];
    grid.near(p, [&](Index, double distance) { own += weight(distance); });
    heap.emplace(own, p);
  }
  // Sums only fall: what is on top and has not changed is the largest.
  std::vector<bool> gone(sum.size(), false);
  for (auto left = static_cast<Index>(points.cols()); left > count;) {
    const auto [known, p] = heap.top();
    heap.pop();
    const double now = sum[static_cast<std::size_t>(p)];
    if (known > now) {
      heap.emplace(now, p);
      continue;
    }
    gone[static_cast<std::size_t>(p)] = true;
    --left;
    grid.near(p, [&](Index q, double distance) {
      double& other = sum[static_cast<std::size_t>(q)];
      other = std::max(0.0, other - weight(distance));
    });
  }
  Chosen chosen;
  for (Index p = 0; p < static_cast<Index>(points.cols()); ++p) {
    if (!gone[static_cast<std::size_t>(p)]) chosen.push_back(p);
  }
  return chosen;
}

}  // namespace ccvt::bench
