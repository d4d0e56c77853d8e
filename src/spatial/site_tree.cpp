#include "spatial/site_tree.h"

// FLANN's headers need this order.
// clang-format off
#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>
// clang-format on

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/nearest.h"

namespace ccvt {
namespace {

using FlannIndex = flann::KDTreeSingleIndex<flann::L2_Simple<double>>;

/// The nearest ones. Once all of them are in the query's own place none is nearer, and FLANN, which
/// looks at all that are as near, must not visit every site in that place.
class NearestSet : public flann::KNNSimpleResultSet<double> {
 public:
  using KNNSimpleResultSet::KNNSimpleResultSet;
  [[nodiscard]] double worstDist() const override {
    const double worst = KNNSimpleResultSet::worstDist();
    return worst > 0 ? worst : -1;
  }
};

/// Calls visit(image) for each image of `query`, itself first, that may lie within `reach()` of a
/// point of the box. The distance from an image to the box is the sum of squares of its offsets.
template <class Reach, class Visit>
void for_each_image(const Metric& metric, const double* query, Reach reach, Visit visit) {
  std::vector<double> image(query, query + metric.dimension());
  const auto recurse = [&](auto& self, std::size_t d, double squared) -> void {
    if (d == image.size()) {
      visit(image.data());
      return;
    }
    self(self, d + 1, squared);
    const double below = query[d] - metric.lower()[d];
    const double above = metric.extent()[d] - below;
    // An image one extent up lies `below` beyond the upper face, and the other way round.
    for (const auto& [gap, shift] :
         {std::pair{below, metric.extent()[d]}, std::pair{above, -metric.extent()[d]}}) {
      const double outside = std::max(0.0, gap);
      if (squared + outside * outside > reach()) continue;
      image[d] = query[d] + shift;
      self(self, d + 1, squared + outside * outside);
      image[d] = query[d];
    }
  };
  recurse(recurse, std::size_t{0}, 0.0);
}

}  // namespace

struct SiteTree::Tree {
  Tree(std::vector<double>& positions, std::size_t count, std::size_t dimension)
      : index(flann::Matrix<double>(positions.data(), count, dimension),
              flann::KDTreeSingleIndexParams(10, true)) {
    index.buildIndex();
  }

  template <class ResultSet>
  void find(ResultSet& result, const double* query) const {
    index.findNeighbors(result, query, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
  }

  FlannIndex index;
};

SiteTree::SiteTree(const Metric& metric, std::span<const double> positions)
    : metric_(metric),
      dimension_(metric.coordinate_count()),
      positions_(positions.begin(), positions.end()) {
  const std::size_t count = positions.size() / dimension_;
  site_.resize(count);
  std::iota(site_.begin(), site_.end(), SiteNumber(0));
  slot_.assign(site_.begin(), site_.end());
  present_.assign(count, 1);
  available_ = static_cast<Index>(count);
  scan_ = metric.dimension() > (metric.periodic() ? kTorusTreeDimensions : kTreeDimensions);
  build();
}

SiteTree::~SiteTree() = default;
SiteTree::SiteTree(SiteTree&&) noexcept = default;

/// Keeps the sites that are present, and builds the tree of them.
void SiteTree::build() {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < site_.size(); ++k) {
    const SiteNumber site = site_[k];
    if (present_[site] == 0) continue;
    std::copy_n(positions_.data() + k * dimension_, dimension_,
                positions_.data() + kept * dimension_);
    slot_[site] = kept;
    site_[kept++] = site;
  }
  site_.resize(kept);
  built_ = available_;
  tree_.reset();
  if (!scan_ && kept > 0) tree_ = std::make_unique<Tree>(positions_, kept, dimension_);
}

void SiteTree::remove(Index site) {
  const SiteNumber number(site);
  present_[number] = 0;
  --available_;
  if (available_ == 0) {
    tree_.reset();
    site_.clear();
    return;
  }
  if (scan_) {  // the last site takes the place of the removed one
    const std::size_t slot = slot_[number];
    const std::size_t last = site_.size() - 1;
    std::copy_n(positions_.data() + last * dimension_, dimension_,
                positions_.data() + slot * dimension_);
    site_[slot] = site_[last];
    slot_[site_[slot]] = slot;
    site_.pop_back();
    return;
  }
  if (available_ < 0.8 * built_) {
    build();
  } else {
    tree_->index.removePoint(slot_[number]);
  }
}

Index SiteTree::nearest(const double* query) const {
  if (available_ == 0) return -1;
  if (scan_) {
    const Index slot =
        kernels::nearest_position(query, positions_.data(), available_, metric_.dimension(),
                                  metric_.periodic() ? metric_.extent() : nullptr);
    return site_.data()[slot].index();
  }
  double best = std::numeric_limits<double>::infinity();
  std::size_t best_slot = 0;
  const auto ask = [&](const double* image) {
    NearestSet result(1);
    tree_->find(result, image);
    std::size_t slot = 0;
    double squared = 0;
    result.copy(&slot, &squared, 1, false);
    if (squared < best) {
      best = squared;
      best_slot = slot;
    }
  };
  if (metric_.periodic()) {
    for_each_image(
        metric_, query, [&] { return best; }, ask);
  } else {
    ask(query);
  }
  return site_[best_slot].index();
}

void SiteTree::nearest(const double* query, int k, std::vector<Index>& found) const {
  const auto wanted = static_cast<std::size_t>(std::min<Index>(k, available_));
  if (wanted == 0) return;
  std::vector<std::pair<double, Index>> best;
  const auto keep_best = [&] {
    std::sort(best.begin(), best.end());
    // Images of one site carry one number: the nearest counts.
    std::vector<std::pair<double, Index>> distinct;
    for (const auto& candidate : best) {
      const bool known = metric_.periodic() &&
                         std::any_of(distinct.begin(), distinct.end(), [&](const auto& other) {
                           return other.second == candidate.second;
                         });
      if (!known && distinct.size() < wanted) distinct.push_back(candidate);
    }
    best.swap(distinct);
  };
  if (scan_) {
    const double* position = positions_.data();
    for (std::size_t s = 0; s < site_.size(); ++s, position += dimension_) {
      best.emplace_back(metric_.squared_distance(query, position), site_[s].index());
    }
    std::partial_sort(best.data(), best.data() + wanted, best.data() + best.size());
    best.resize(wanted);
  } else {
    const auto ask = [&](const double* image) {
      NearestSet result(wanted);
      tree_->find(result, image);
      std::vector<std::size_t> slots(wanted);
      std::vector<double> squared(wanted);
      const std::size_t count = result.size();
      result.copy(slots.data(), squared.data(), count, true);
      for (std::size_t i = 0; i < count; ++i) {
        best.emplace_back(squared[i], site_[slots[i]].index());
      }
      keep_best();
    };
    const auto reach = [&] {
      return best.size() < wanted ? std::numeric_limits<double>::infinity() : best.back().first;
    };
    if (metric_.periodic()) {
      for_each_image(metric_, query, reach, ask);
    } else {
      ask(query);
    }
  }
  for (const auto& [squared, site] : best) found.push_back(site);
}

void SiteTree::within(const double* query, double radius, std::vector<Index>& found) const {
  if (available_ == 0) return;
  if (scan_) {
    const double* position = positions_.data();
    for (std::size_t k = 0; k < site_.size(); ++k, position += dimension_) {
      if (metric_.squared_distance(query, position) <= radius * radius)
        found.push_back(site_[k].index());
    }
    return;
  }
  const auto first = found.size();
  // Rounded up, and more than nothing, as FLANN leaves out what is just as far: distances are
  // compared once more by whoever needs them exact.
  const double squared_radius = radius * radius * (1 + 1e-12) + std::numeric_limits<double>::min();
  std::size_t images = 0;
  const auto ask = [&](const double* image) {
    ++images;
    flann::RadiusResultSet<double> result(squared_radius);
    tree_->find(result, image);
    const std::size_t count = result.size();
    std::vector<std::size_t> slots(count);
    std::vector<double> squared(count);
    result.copy(slots.data(), squared.data(), count, false);
    for (const std::size_t slot : slots) found.push_back(site_[slot].index());
  };
  if (metric_.periodic()) {
    for_each_image(
        metric_, query, [&] { return squared_radius; }, ask);
  } else {
    ask(query);
  }
  if (images > 1) {
    const std::span added = std::span(found).subspan(first);
    std::sort(added.begin(), added.end());
    const auto repeated = std::unique(added.begin(), added.end());
    found.erase(found.end() - (added.end() - repeated), found.end());
  }
}

}  // namespace ccvt
