#include "thin/quotas.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace ccvt {
namespace {

/// Homes of the smallest blocks: with 4, smallest distances fall where homes have ten points.
constexpr std::size_t kSmallest = 8;
/// Standard deviations. On clouds of even density hardly any block is held back by so much.
constexpr double kTolerance = 3;
constexpr double kToleranceOnSlopes = 0.5;
/// Of the largest reach in a block to the smallest, in blocks on slopes.
constexpr double kSlope = 1.25;

std::int64_t tolerance_of(std::span<const double> reach, double points_each) {
  const auto [least, most] = std::minmax_element(reach.begin(), reach.end());
  const double deviations = *most > kSlope * *least ? kToleranceOnSlopes : kTolerance;
  const double chance = std::sqrt(static_cast<double>(reach.size()) / points_each);
  return static_cast<std::int64_t>(std::max(1.0, deviations * chance));
}

}  // namespace

Quotas::Quotas(std::span<const double> reach, double points_each) {
  for (std::size_t homes = kSmallest; homes < reach.size(); homes *= 2) {
    Level level{homes, {}};
    for (std::size_t first = 0; first < reach.size(); first += homes) {
      const auto own = reach.subspan(first, std::min(homes, reach.size() - first));
      level.blocks.push_back({-std::ssize(own), tolerance_of(own, points_each)});
    }
    levels_.push_back(std::move(level));
  }
}

bool Quotas::allow(SiteNumber from, SiteNumber to) const {
  for (const Level& level : levels_) {
    const std::size_t left = from / level.homes;
    const std::size_t entered = to / level.homes;
    if (left == entered) return true;
    const Block& loses = level.blocks[left];
    const Block& gains = level.blocks[entered];
    if (loses.surplus <= -loses.tolerance || gains.surplus >= gains.tolerance) return false;
  }
  return true;
}

void Quotas::add(SiteNumber home, int chosen) {
  for (Level& level : levels_) level.blocks[home / level.homes].surplus += chosen;
}

std::int64_t Quotas::worst_excess() const {
  std::int64_t worst = 0;
  for (const Level& level : levels_) {
    for (const Block& block : level.blocks) {
      worst = std::max(worst, std::abs(block.surplus) - block.tolerance);
    }
  }
  return worst;
}

}  // namespace ccvt
