#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "numbers.h"

namespace ccvt {

/// Nearest-site queries through a FLANN k-d tree; in the domain's own metric, so also on a torus,
/// where the images of a query that can matter are asked one by one. Exact. Of several nearest
/// sites any may be returned, but always the same one.
///
/// Beyond kTreeDimensions (kTorusTreeDimensions on a torus), where trees visit every leaf, sites
/// are scanned instead.
///
/// Const queries may run concurrently; remove() may not.
class SiteTree {
 public:
  static constexpr int kTreeDimensions = 12;
  static constexpr int kTorusTreeDimensions = 5;

  /// `positions`: #dimensions by n, one site after the other; copied. The metric is not.
  SiteTree(const Metric& metric, std::span<const double> positions);
  SiteTree(Metric&&, std::span<const double>) = delete;
  ~SiteTree();
  SiteTree(SiteTree&&) noexcept;
  SiteTree& operator=(SiteTree&&) = delete;

  /// The nearest site that has not been removed; -1 when none is left.
  [[nodiscard]] Index nearest(const double* query) const;

  /// The k nearest sites that have not been removed, nearest first, appended to `found`.
  void nearest(const double* query, int k, std::vector<Index>& found) const;

  /// All sites not removed within `radius` of `query`, in no particular but always the same order,
  /// appended to `found`. On a torus a site is found once however many of its images are near.
  void within(const double* query, double radius, std::vector<Index>& found) const;

  /// Takes a site out of later queries. The tree is built again each time a fifth of its sites
  /// have gone, which keeps queries O(log n) at a total cost of O(n log n).
  void remove(Index site);

  [[nodiscard]] Index available() const { return available_; }

 private:
  struct Tree;
  void build();

  const Metric& metric_;
  std::size_t dimension_ = 0;
  std::vector<double> positions_;      ///< of the sites in the tree, one after the other
  std::vector<SiteNumber> site_;       ///< which they are
  std::vector<std::size_t> slot_;      ///< where each site is in them
  std::vector<std::uint8_t> present_;  ///< by site
  Index available_ = 0;
  Index built_ = 0;  ///< how many there were when the tree was built
  bool scan_ = false;
  std::unique_ptr<Tree> tree_;
};

}  // namespace ccvt
