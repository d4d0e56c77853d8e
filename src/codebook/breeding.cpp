#include "codebook/breeding.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "cell_sizes.h"
#include "codebook/sample_source.h"
#include "codebook/seeding.h"
#include "codebook/share.h"
#include "exact/assignment.h"
#include "exact/centroids.h"
#include "geometry/squares.h"
#include "parallel/rank_turns.h"
#include "parallel/together.h"
#include "random.h"
#include "streams.h"

namespace ccvt {
namespace {

/// Points a site of the sample that most children are judged on.
constexpr std::int64_t kFirstSample = 64;
/// Points a site of the sample that the rest are judged on.
constexpr std::int64_t kLastSample = 256;
/// By default so many children by the number of sites, within a limit, up to so many dimensions.
/// Beyond, they take longer than what comes after.
constexpr Index kUsualEffort = 4096;
constexpr Index kMostEffort = 64;
constexpr int kEffortDimensions = 128;
/// One child of so many comes last.
constexpr int kLastChildren = 3;
/// Children that are bred of the same parents' generation.
constexpr std::size_t kBrood = 8;
constexpr std::size_t kPopulation = 8;
/// Balancing ends when an iteration gains less than this share, or after so many.
constexpr double kRough = 3e-4;
constexpr int kRoughIterations = 60;
/// An assignment need not be nearer than this to the cheapest. With 2e-3, and 1e-3 above, balancing
/// ends before it is clear which codebook is the better one: of 22 seeds of seven mixtures, 12 to
/// 22 come within .5 % of the best instead of 21 or 22, in .8 to 1.1 times the time.
constexpr double kRoughGap = 1e-4;
/// An iteration's gain times this is what all those after it may gain together.
constexpr double kHope = 8;
/// Two codebooks whose energies differ by less than this share are the same.
constexpr double kSame = 1e-7;
/// Where all that live are as near each other as this, there is but one place to go.
constexpr double kAlike = 1e-4;

struct Candidate : BredSites {
  double energy = std::numeric_limits<double>::infinity();
};

/// The search on the sample.
class Breeder {
 public:
  /// `shares`: of the capacities, those of the sample.
  Breeder(Sample sample, std::vector<Index> shares, const Breeding& breeding, const Arena& arena)
      : sample_(std::move(sample)),
        points_(view_points(sample_.points)),
        width_(sample_.mean.size()),
        capacities_(std::move(shares)),
        breeding_(breeding),
        arena_(arena),
        metric_(points_.dimension, Domain()) {}

  void add_seedings();
  /// `stream`: of random numbers, the first of so many.
  void add_children(int children, std::uint64_t stream);
  /// Adds what was found on another sample.
  void add(std::vector<BredSites> found);
  /// Whether there is no more time.
  [[nodiscard]] bool over() const {
    return any(breeding_.ranks, std::chrono::steady_clock::now() >= breeding_.until);
  }
  /// The best first, in the units of all points.
  [[nodiscard]] std::vector<BredSites> found() const;

 private:
  [[nodiscard]] std::vector<double> seeding(int number) const;
  [[nodiscard]] Candidate child(std::uint64_t stream) const;
  [[nodiscard]] const Candidate& parent(Random& random) const;
  void join(const Candidate& a, const Candidate& b, Random& random, Candidate& child) const;
  void complete(Candidate& child, Random& random) const;
  void rank(Candidate& child) const;
  void balance(Candidate& candidate, double enough) const;
  template <class Make>
  void add_each(std::size_t count, const Make& make);
  void share(std::vector<Candidate>& brood) const;
  void select(std::vector<Candidate> candidates);
  [[nodiscard]] bool alike() const;

  Sample sample_;
  PointsView<float> points_;
  std::size_t width_;
  std::vector<Index> capacities_;
  const Breeding& breeding_;
  const Arena& arena_;
  Metric metric_;
  std::vector<Candidate> population_;  ///< by energy
};

std::vector<double> Breeder::seeding(int number) const {
  const auto n = static_cast<Index>(capacities_.size());
  const std::uint64_t seed = mix_bits(breeding_.seed) + static_cast<std::uint64_t>(number);
  if (breeding_.random) return draw_sites<float>(points_, n, 1, seed, arena_);
  const std::vector<double> seeds = seed_sites<float>(points_, n, 1, seed, arena_);
  const std::vector<Index> owners = nearest_owners(metric_, points_, seeds, arena_);
  return share_sites(points_, owners, seeds, capacities_, seed, arena_);
}

/// Exact assignments and centroids in turn, to a rough end, or until it is unlikely to get below
/// `enough`.
void Breeder::balance(Candidate& candidate, double enough) const {
  std::vector<Index> owners = nearest_owners(metric_, points_, candidate.sites, arena_);
  ExactAssignment<float> assignment(metric_, points_, static_cast<Index>(capacities_.size()),
                                    capacities_, arena_, kRoughGap);
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRoughIterations; ++i) {
    const bool optimal = assignment.improve(candidate.sites, candidate.weights, owners) ==
                         ExactAssignment<float>::Round::optimal;
    const double energy = assignment.last().energy;
    if (i > 0) {
      candidate.energy = energy;
      const double gain = before - energy;
      if (optimal || gain < kRough * before || energy - kHope * gain > enough) break;
      before = energy;
    }
    move_to_centroids(metric_, points_, Grouping(owners, capacities_.size()), arena_,
                      candidate.sites);
  }
}

/// The better one of two.
const Candidate& Breeder::parent(Random& random) const {
  const std::size_t a = random.below(population_.size());
  const std::size_t b = random.below(population_.size());
  return population_[std::min(a, b)];
}

/// The sites of `a` on one side of a plane through a point across the line of two others, and those
/// of `b` on the other side; no more than there are capacities less one.
void Breeder::join(const Candidate& a, const Candidate& b, Random& random, Candidate& child) const {
  const float* const middle = points_[random.index_below(points_.count)];
  const float* const from = points_[random.index_below(points_.count)];
  const float* const to = points_[random.index_below(points_.count)];
  const auto beyond = [&](const double* site) {
    double along = 0;
    for (std::size_t d = 0; d < width_; ++d) along += (site[d] - middle[d]) * (to[d] - from[d]);
    return along > 0;
  };
  std::vector<std::pair<const Candidate*, std::size_t>> chosen;
  for (std::size_t s = 0; s < capacities_.size(); ++s) {
    if (!beyond(a.sites.data() + s * width_)) chosen.emplace_back(&a, s);
    if (beyond(b.sites.data() + s * width_)) chosen.emplace_back(&b, s);
  }
  random.shuffle(std::span(chosen));
  chosen.resize(std::min(chosen.size(), capacities_.size() - 1));
  for (const auto& [candidate, s] : chosen) {
    const double* const site = candidate->sites.data() + s * width_;
    child.sites.insert(child.sites.end(), site, site + width_);
  }
}

/// Adds sites until there are as many as capacities: points drawn with probability proportional to
/// the squared distance to the nearest site.
void Breeder::complete(Candidate& child, Random& random) const {
  const auto m = static_cast<std::size_t>(points_.count);
  std::vector<double> squared(m, 1.0);
  std::vector<double> sum(m);
  if (!child.sites.empty()) {
    const std::vector<Index> nearest = nearest_owners(metric_, points_, child.sites, arena_);
    for (std::size_t p = 0; p < m; ++p) {
      const auto s = static_cast<std::size_t>(nearest[p]);
      squared[p] = squared_difference(points_[static_cast<Index>(p)],
                                      child.sites.data() + s * width_, points_.dimension);
    }
  }
  while (child.sites.size() < capacities_.size() * width_) {
    arena_.check();
    std::inclusive_scan(squared.begin(), squared.end(), sum.begin());
    const double at = random.uniform() * sum.back();
    const auto found = std::upper_bound(sum.begin(), sum.end() - 1, at) - sum.begin();
    const float* const chosen = points_[static_cast<Index>(found)];
    for (std::size_t p = 0; p < m; ++p) {
      squared[p] = std::min(squared[p], squared_difference(points_[static_cast<Index>(p)], chosen,
                                                           points_.dimension));
    }
    child.sites.insert(child.sites.end(), chosen, chosen + width_);
  }
}

/// Gives larger capacities to the sites that are nearest to more points; parents' sites stand in no
/// order any more.
void Breeder::rank(Candidate& child) const {
  const auto [least, most] = std::minmax_element(capacities_.begin(), capacities_.end());
  if (*most - *least <= 2) return;  // shares of equal ones
  const std::size_t n = capacities_.size();
  const std::vector<Index> sizes =
      cell_sizes(nearest_owners(metric_, points_, child.sites, arena_), n);
  const auto ranked = [n](const std::vector<Index>& counts) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return counts[a] < counts[b]; });
    return order;
  };
  const std::vector<std::size_t> from = ranked(sizes);
  const std::vector<std::size_t> to = ranked(capacities_);
  const std::vector<double> sites = child.sites;
  for (std::size_t k = 0; k < n; ++k) {
    std::copy_n(sites.data() + from[k] * width_, width_, child.sites.data() + to[k] * width_);
  }
}

Candidate Breeder::child(std::uint64_t stream) const {
  Random random(breeding_.seed, stream);
  Candidate result;
  const Candidate& a = parent(random);
  const Candidate& b = parent(random);
  join(a, b, random, result);
  complete(result, random);
  rank(result);
  // Not the parents', which differ by an unknown amount on either side.
  result.weights.assign(capacities_.size(), 0.0);
  balance(result, population_.back().energy);
  return result;
}

/// Takes in those that are new, and keeps the best.
void Breeder::select(std::vector<Candidate> candidates) {
  for (Candidate& candidate : candidates) {
    const auto place = std::lower_bound(
        population_.begin(), population_.end(), candidate,
        [](const Candidate& a, const Candidate& b) { return a.energy < b.energy; });
    const auto same = [&](const Candidate& other) {
      return std::abs(other.energy - candidate.energy) <= kSame * candidate.energy;
    };
    if (std::none_of(population_.begin(), population_.end(), same)) {
      population_.insert(place, std::move(candidate));
    }
  }
  population_.resize(std::min(population_.size(), kPopulation));
}

/// Whether all that live have come to the same place, from several.
bool Breeder::alike() const {
  return breeding_.seedings > 1 &&
         population_.back().energy <= population_.front().energy * (1 + kAlike);
}

/// Makes candidates, kBrood at a time, and keeps the best. Ranks make some of them each. Those that
/// are small side by side; else one after the other, with all threads for each, so that the
/// caller's is never long without work in which it hears of a stop.
template <class Make>
void Breeder::add_each(std::size_t count, const Make& make) {
  const RankTurns turns(breeding_.ranks);
  for (std::size_t begin = 0; begin < count; begin += kBrood) {
    std::vector<Candidate> brood(std::min(kBrood, count - begin));
    const auto add = [&](std::size_t k) {
      if (turns.own(k)) brood[k] = make(begin + k);
    };
    if (brood.size() == 1 || std::cmp_greater(capacities_.size(), kFewSites)) {
      for (std::size_t k = 0; k < brood.size(); ++k) add(k);
    } else {
      arena_.for_each(brood.size(), 1, add);
    }
    if (breeding_.ranks != nullptr) share(brood);
    select(std::move(brood));
  }
}

/// Each rank has made its own; then all have all.
void Breeder::share(std::vector<Candidate>& brood) const {
  const RankTurns turns(breeding_.ranks);
  ByteWriter message;
  for (std::size_t k = 0; k < brood.size(); ++k) {
    if (!turns.own(k)) continue;
    message.put(brood[k].sites);
    message.put(brood[k].weights);
    message.put(brood[k].energy);
  }
  read_in_turns(*breeding_.ranks, message.bytes, brood.size(),
                [&](std::size_t k, ByteReader& reader) {
                  reader.get(brood[k].sites);
                  reader.get(brood[k].weights);
                  brood[k].energy = reader.get<double>();
                });
}

void Breeder::add_seedings() {
  add_each(static_cast<std::size_t>(breeding_.seedings), [&](std::size_t k) {
    Candidate seeded;
    seeded.sites = seeding(static_cast<int>(k));
    seeded.weights.assign(capacities_.size(), 0.0);
    arena_.check();  // seeding may have been cut short
    balance(seeded, std::numeric_limits<double>::infinity());
    return seeded;
  });
}

void Breeder::add_children(int children, std::uint64_t stream) {
  const auto count = static_cast<std::size_t>(children);
  for (std::size_t begin = 0; begin < count && !alike() && !over(); begin += kBrood) {
    add_each(std::min(kBrood, count - begin),
             [&](std::size_t k) { return child(stream + begin + k); });
  }
}

void Breeder::add(std::vector<BredSites> found) {
  add_each(found.size(), [&](std::size_t k) {
    Candidate candidate;
    static_cast<BredSites&>(candidate) = std::move(found[k]);
    sample_.bring_in(candidate.sites);
    // Not by the square of the scale, which may overflow.
    for (double& weight : candidate.weights) weight = weight * sample_.scale * sample_.scale;
    balance(candidate, std::numeric_limits<double>::infinity());
    return candidate;
  });
}

std::vector<BredSites> Breeder::found() const {
  std::vector<BredSites> all(population_.begin(), population_.end());
  for (BredSites& one : all) {
    sample_.take_back(one.sites);
    for (double& weight : one.weights) weight = weight / sample_.scale / sample_.scale;
  }
  return all;
}

}  // namespace

int usual_effort(Index sites, int dimension) {
  if (sites > kFewSites || dimension > kEffortDimensions) return 0;
  return std::min(kUsualEffort / sites, kMostEffort);
}

template <class Scalar>
BredSites breed_sites(const Vectors<Scalar>& points, std::span<const Index> capacities,
                      const Breeding& breeding, const Arena& arena) {
  const auto breeder = [&](Sample sample, std::optional<Breeder>& made) {
    const auto count = static_cast<Index>(sample.points.cols());
    made.emplace(std::move(sample), share_capacities(capacities, points.count(), count), breeding,
                 arena);
  };
  std::optional<Breeder> first;
  std::optional<Breeder> last;
  try {
    const SampleSource<Scalar> source(points, static_cast<Index>(capacities.size()), kFirstSample,
                                      breeding.seed, arena);
    const bool larger = source.size(kFirstSample) < source.size(kLastSample);
    const int children = larger ? breeding.children / kLastChildren : 0;
    constexpr std::uint64_t stream = streams::codebook_breeding + 1;
    breeder(source.sample(kFirstSample), first);
    first->add_seedings();
    first->add_children(breeding.children - children, stream);
    if (larger && !first->over()) {
      breeder(source.sample(kLastSample), last);
      last->add(first->found());
      last->add_children(children, stream + static_cast<std::uint64_t>(breeding.children));
    }
  } catch (const Stopped&) {
    if (!first || first->found().empty()) return {};
  }
  const bool best = last && !last->found().empty();
  return (best ? last : first)->found().front();
}

template BredSites breed_sites(const Vectors<float>&, std::span<const Index>, const Breeding&,
                               const Arena&);
template BredSites breed_sites(const Vectors<double>&, std::span<const Index>, const Breeding&,
                               const Arena&);

}  // namespace ccvt
