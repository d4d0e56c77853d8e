#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "spatial/site_bins.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// Finds the sites near a position: in bins where they pay, else through a k-d tree.
class SiteSearch {
 public:
  /// `positions`: #dimensions by n, one site after the other; copied.
  SiteSearch(const Metric& metric, std::span<const double> positions,
             const Arena& arena = Arena(1));

  /// Calls visit(site, squared distance) for each site within `radius` of `query`, which lies in
  /// the box when there is one, in no particular but always the same order. `scratch` is for its
  /// own use.
  template <class Visit>
  void within(const double* query, double radius, std::vector<Index>& scratch, Visit visit) const;

 private:
  template <std::size_t Dimension, class Visit>
  void within_bins(const double* query, double radius, Visit visit) const;

  const Metric& metric_;
  std::vector<double> positions_;
  std::optional<SiteBins> bins_;
  std::optional<SiteTree> tree_;
};

template <std::size_t Dimension, class Visit>
void SiteSearch::within_bins(const double* query, double radius, Visit visit) const {
  bins_->for_each_offset<Dimension>(
      query, radius, [&](std::size_t place, const std::array<double, Dimension>& offset) {
        double squared = 0;
        for (const double difference : offset) squared += difference * difference;
        if (squared <= radius * radius) visit(bins_->site(place), squared);
      });
}

template <class Visit>
void SiteSearch::within(const double* query, double radius, std::vector<Index>& scratch,
                        Visit visit) const {
  if (bins_ && metric_.dimension() == 2) return within_bins<2>(query, radius, visit);
  if (bins_) return within_bins<3>(query, radius, visit);
  scratch.clear();
  tree_->within(query, radius, scratch);
  const std::ptrdiff_t width = metric_.dimension();
  for (const Index site : scratch) {
    const double squared = metric_.squared_distance(positions_.data() + site * width, query);
    if (squared <= radius * radius) visit(site, squared);
  }
}

}  // namespace ccvt
