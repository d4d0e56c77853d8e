#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "codebook/vectors.h"
#include "parallel/arena.h"

namespace ccvt {

/// Sites, one after the other, with weights under which their cells are about balanced.
struct BredSites {
  std::vector<double> sites;
  std::vector<double> weights;
};

struct Breeding {
  int seedings = 0;  ///< parents to begin with, at least one
  int children = 0;
  std::uint64_t seed = 0;
  bool random = false;     ///< parents are drawn at random, and not by k-means++
  Ranks* ranks = nullptr;  ///< that share the work, each breeding some of a generation
  /// Then it ends with what there is, whichever of the ranks looks at its clock.
  std::chrono::steady_clock::time_point until = std::chrono::steady_clock::time_point::max();
};

/// How many children pay: none where chance hardly tells one seeding from another.
int usual_effort(Index sites, int dimension);

/// Toward the sites of least energy among those that meet the capacities, wherever seeds are: a
/// genetic search [HG-means: Gribel, Vidal 2019; here with balanced cells]. Every seeding is
/// balanced exactly and moved to its centroids a few times. Then each child takes the sites of one
/// parent on one side of a plane and those of another on the other side, loses or gets some at
/// random to have as many, and is balanced likewise; the best live on.
/// It ends early where all come to the same place.
///
/// It takes place on a sample with each region's share of the points but for rounding, so that what
/// fills a capacity of the sample fills one of all; the last generations live on a larger one.
/// When the arena throws Stopped meanwhile, the best there are so far, or none; then the stop of
/// the arena is still on.
///
/// `capacities` sum to the number of points. O((seedings + children) iterations n^2 D), and for the
/// samples O(n^2 D) too, with a factor of thousands: points times regions. Of several ranks, all
/// call it, with an arena that does not divide loops among them, on points that all get.
template <class Scalar>
BredSites breed_sites(const Vectors<Scalar>& points, std::span<const Index> capacities,
                      const Breeding& breeding, const Arena& arena);

}  // namespace ccvt
