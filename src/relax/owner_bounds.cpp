#include "relax/owner_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kernels/nearest.h"
#include "rounding.h"
#include "schedule/tiling.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = 4096;
constexpr std::size_t kSitesPerGrain = 64;
constexpr std::size_t kPacksPerGrain = 256;
/// Beyond so many dimensions, or with so few sites, distances of sites tell little.
constexpr int kMostListDimensions = 6;
constexpr std::size_t kFewSites = 16;
/// Of smaller cells nearly all points are near a border: a grid or tree tells all of them faster.
constexpr Index kFewPointsASite = 40;
/// And so does a tree where all sites are listed, and are more than these for each dimension.
constexpr Index kMostSitesListed = 64;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Distances are rounded, in double and then in float: of their size.
constexpr double kRounding = 0x1p-20;
constexpr float kShrink = 1 - 0x1p-22F;  // more than a difference is rounded
/// Of twice the radius of a cell: how far its site knows the others.
constexpr double kReach = 1.25;

/// Of finite numbers.
float rounded_down(double x) {
  const auto rounded = static_cast<float>(x);
  return rounded - std::abs(rounded) * 0x1p-23F - std::numeric_limits<float>::denorm_min();
}

float rounded_up(double x) { return -rounded_down(-x); }

}  // namespace

template <class Scalar>
bool OwnerBounds<Scalar>::pays(Index points, Index sites, int dimension) {
  return points / sites >= kFewPointsASite &&
         (dimension <= kMostListDimensions || sites / dimension <= kMostSitesListed);
}

/// Where nearly all sites can be nearest to some point of every other.
template <class Scalar>
void OwnerBounds<Scalar>::list_all_sites(const SiteState& sites) {
  constexpr std::size_t kPack = kernels::kPack;
  near_.reset((sites.count() + kPack - 1) / kPack * kPack);
  std::fill(near_.begin(), near_.end(), Near{0, SiteNumber::none()});
  for (const SiteNumber s : sites.all()) near_[s] = {0, s};
  first_ = {0, near_.size() / kPack};
  reach_.assign(sites.count(), kInfinity);
}

/// The sites around each that can be nearest to its points, by their distance.
template <class Scalar>
void OwnerBounds<Scalar>::list_near_sites(const SiteState& sites) {
  const SiteTree tree(metric_, sites.position);
  reach_.resize(sites.count());
  PerWorker<std::vector<Index>> scratch(arena_);
  std::vector<std::size_t> counts(sites.count());
  near_ = collect<Near>(
      arena_, sites.count(), kSitesPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<Near>& out, int w) {
        for (std::size_t k = begin; k < end; ++k) {
          const SiteNumber s(k);
          const std::size_t before = out.size();
          reach_[s] = 2 * kReach * sites.radius[s];
          scratch[w].clear();
          tree.within(sites.at(s), reach_[s], scratch[w]);
          for (const Index found : scratch[w]) {
            const SiteNumber other(found);
            if (other == s) continue;
            out.push_back(
                {std::sqrt(metric_.squared_distance(sites.at(s), sites.at(other))), other});
          }
          std::sort(out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
                    [](const Near& a, const Near& b) {
                      return a.distance != b.distance ? a.distance < b.distance : a.site < b.site;
                    });
          while ((out.size() - before) % kernels::kPack != 0) {
            out.push_back({kInfinity, SiteNumber::none()});
          }
          counts[k] = (out.size() - before) / kernels::kPack;
        }
      });
  first_.assign(1, 0);
  for (const std::size_t count : counts) first_.push_back(first_.back() + count);
}

/// Whether all sites that can be nearest to a point of another's cell are still in its list.
template <class Scalar>
bool OwnerBounds<Scalar>::lists_hold(const SiteState& sites) const {
  if (first_.empty()) return false;
  double room = kInfinity;
  for (const SiteNumber s : sites.all()) room = std::min(room, reach_[s] - 2 * sites.radius[s]);
  return room >= 2 * drift_;
}

template <class Scalar>
void OwnerBounds<Scalar>::pack(const SiteState& sites) {
  constexpr std::size_t kPack = kernels::kPack;
  packs_.reset(near_.size() * sites.dimension);
  arena_.for_each(near_.size() / kPack, kPacksPerGrain, [&](std::size_t pack) {
    double* const out = packs_.data() + pack * kPack * sites.dimension;
    for (std::size_t k = 0; k < kPack; ++k) {
      const SiteNumber s = near_[pack * kPack + k].site;
      for (std::size_t d = 0; d < sites.dimension; ++d) {
        out[d * kPack + k] = s == SiteNumber::none() ? 0 : sites.at(s)[d];
      }
    }
  });
}

/// A lead falls by how far the own site has moved, and the farthest of those listed.
template <class Scalar>
void OwnerBounds<Scalar>::note_moves(const SiteState& sites) {
  moved_.resize(sites.count());
  double most = 0;
  double next = 0;
  SiteNumber farthest = SiteNumber::none();
  for (const SiteNumber s : sites.all()) {
    moved_[s] = std::sqrt(metric_.squared_distance(&position_[s * sites.dimension], sites.at(s)));
    if (moved_[s] > most) {
      next = most;
      most = moved_[s];
      farthest = s;
    } else {
      next = std::max(next, moved_[s]);
    }
  }
  drift_ += most * (1 + kRounding);
  for_each_site(arena_, sites.count(), kSitesPerGrain, [&](SiteNumber s) {
    double others = s == farthest ? next : most;
    if (!all_listed_) {
      others = 0;
      for (std::size_t k = first_[s] * kernels::kPack; k < first_[s + 1] * kernels::kPack; ++k) {
        if (near_[k].site != SiteNumber::none()) others = std::max(others, moved_[near_[k].site]);
      }
    }
    used_[s] = rounded_up((moved_[s] + others) * (1 + kRounding));
  });
}

/// Of a site that is new in a list, points know only that it was not near enough to be in the last.
template <class Scalar>
void OwnerBounds<Scalar>::renew_lists(const SiteState& sites) {
  for (std::size_t s = 0; s < reach_.size(); ++s) {
    const double sure = reach_[s] - 2 * drift_ - 2 * sites.radius[s];
    most_[s] = rounded_down(sure - kRounding * reach_[s]);
  }
  all_listed_ = metric_.dimension() > kMostListDimensions || sites.count() <= kFewSites;
  if (all_listed_) {
    list_all_sites(sites);
  } else {
    list_near_sites(sites);
  }
  drift_ = 0;
}

template <class Scalar>
SiteNumber OwnerBounds<Scalar>::look_at(PointNumber point, SiteNumber owner, const SiteState& sites,
                                        double margin, double* x, float& lead) const {
  constexpr std::size_t kPack = kernels::kPack;
  const std::size_t dimension = sites.dimension;
  std::copy_n(points_[point.index()], dimension, x);
  const double own_squared = metric_.squared_distance(x, sites.at(owner));
  const double own = std::sqrt(own_squared);
  double nearest = kInfinity;  // of the others, squared
  double second = kInfinity;
  SiteNumber best = SiteNumber::none();
  const double apart = 2 * drift_ + own;
  const std::size_t list = all_listed_ ? 0 : static_cast<std::size_t>(owner.index());
  std::array<double, kPack> squared;
  for (std::size_t pack = first_[list]; pack < first_[list + 1]; ++pack) {
    const Near* const near = near_.data() + pack * kPack;
    const double least = near->distance - apart;
    if (least > 0 && least * least >= second) break;
    kernels::squared_distances(x, packs_.data() + pack * kPack * dimension, 1, metric_.dimension(),
                               metric_.periodic() ? metric_.extent() : nullptr, squared.data());
    for (std::size_t k = 0; k < kPack; ++k) {
      if (!(squared[k] < second) || near[k].site == owner || near[k].site == SiteNumber::none()) {
        continue;
      }
      if (squared[k] < nearest) {
        second = nearest;
        nearest = squared[k];
        best = near[k].site;
      } else {
        second = squared[k];
      }
    }
  }
  const bool changes = own_squared - nearest > rounding_of_difference(metric_, own) + margin;
  const double mine = changes ? std::sqrt(nearest) : own;
  const double others = std::sqrt(changes ? std::min(own_squared, second) : nearest);
  lead = others == kInfinity ? std::numeric_limits<float>::infinity()  // there is one site
                             : rounded_down(others - mine - kRounding * (others + mine));
  return changes ? best : owner;
}

template <class Scalar>
Buffer<OwnerChange> OwnerBounds<Scalar>::changes(const SiteState& sites,
                                                 const std::vector<Index>& owners, double margin) {
  if (position_.empty()) {
    used_.assign(sites.count(), 0);
    lead_.assign(owners.size(), 0);
  } else {
    note_moves(sites);
  }
  position_ = sites.position;
  most_.assign(sites.count(), std::numeric_limits<float>::infinity());
  if (!lists_hold(sites)) renew_lists(sites);
  pack(sites);
  PerWorker<std::vector<double>> scratch(arena_, std::vector<double>(sites.dimension));
  return collect<OwnerChange>(
      arena_, owners.size(), kPointsPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<OwnerChange>& out, int w) {
        for (std::size_t p = begin; p < end; ++p) {
          const SiteNumber owner(owners[p]);
          const float left = std::min((lead_[p] - used_[owner]) * kShrink, most_[owner]);
          lead_[p] = left;
          if (left > 0) continue;
          const SiteNumber to =
              look_at(PointNumber(p), owner, sites, margin, scratch[w].data(), lead_[p]);
          if (to != owner) out.push_back({PointNumber(p), to});
        }
      });
}

double rounding_of_difference(const Metric& metric, double distance) {
  return 4 * (metric.dimension() + 4) *
         (kHalfUlp * distance * (distance + metric.largest_extent()) +
          std::numeric_limits<double>::denorm_min());
}

template class OwnerBounds<float>;
template class OwnerBounds<double>;

}  // namespace ccvt
