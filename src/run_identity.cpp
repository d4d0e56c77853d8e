#include "run_identity.h"

#include <cstddef>
#include <numeric>
#include <span>
#include <utility>

#include "ccvt/version.h"
#include "checkpoint/digest.h"
#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;

template <class Enum>
std::string number_of(Enum value) {
  return std::to_string(static_cast<int>(value));
}

template <class Scalar>
std::uint64_t digest_of_columns(const Columns<Scalar>& columns) {
  const auto rows = static_cast<std::uint64_t>(columns.rows());
  return digest_of(
      std::span<const Scalar>(columns.data(), static_cast<std::size_t>(columns.size())), rows);
}

PointDigests plus(const PointDigests& a, const PointDigests& b) {
  return {a.points + b.points, a.owners + b.owners};
}

}  // namespace

template <class Scalar>
PointDigests digests_of_points(const Problem<Scalar>& problem, const Arena& arena) {
  const PointsView<Scalar>& points = problem.points();
  const std::vector<Index>& owners = problem.initial_owners();
  const auto dimension = static_cast<std::size_t>(points.dimension);
  PointDigests own;
  agree(problem.ranks(), [&] {
    own = reduce(
        arena, static_cast<std::size_t>(points.count), kPointsPerGrain, PointDigests(),
        [&](std::size_t begin, std::size_t end) {
          PointDigests sums;
          for (std::size_t p = begin; p < end; ++p) {
            const auto number = static_cast<std::uint64_t>(problem.first_own_point()) + p;
            sums.points += digest_of(std::span(points[static_cast<Index>(p)], dimension), number);
            if (!owners.empty()) sums.owners += digest_of(std::span(&owners[p], 1), number);
          }
          return sums;
        },
        plus);
  });
  const std::vector<PointDigests> all = of_all(problem.ranks(), own);
  return std::accumulate(all.begin(), all.end(), PointDigests(), plus);
}

template <class Scalar>
RunIdentity::RunIdentity(const Problem<Scalar>& problem, const Options& options,
                         const PointDigests& digests)
    : version_(CCVT_VERSION) {
  add("the type of coordinates", sizeof(Scalar) == sizeof(float) ? "float" : "double");
  add("the number of dimensions", std::to_string(problem.dimension()));
  add("the number of points", std::to_string(problem.point_count()));
  add("the number of sites", std::to_string(problem.site_count()));
  add_options(options);
  add_digest("the points", digests.points);
  add_digest("the capacities", digest_of(std::span<const Index>(problem.capacities())));
  add_domain(problem.domain());
  add_digest("the initial sites", digest_of_columns(problem.initial_sites()));
  add_digest("the fixed sites", digest_of_columns(problem.fixed_sites()));
  add_digest("the initial owners", digests.owners);
}

void RunIdentity::add_digest(std::string name, std::uint64_t digest) {
  parts_.push_back({std::move(name), std::to_string(digest), false});
}

/// Those that bits depend on.
void RunIdentity::add_options(const Options& options) {
  add("the option seed", std::to_string(options.seed));
  add("the option until", options.until == Until::stable ? "stable" : "blue_noise");
  add("the option initialization", number_of(options.initialization));
  add("the option multilevel", number_of(options.multilevel));
  add("the option level_points", std::to_string(options.level_points));
  add("the option level_factor", std::to_string(options.level_factor));
  add("the option descent_points", std::to_string(options.descent_points));
  add("the option swap", number_of(options.swap));
  add("the option point_pruning", number_of(options.point_pruning));
  add("the option median_cut_pruning", number_of(options.median_cut_pruning));
  add("the option pairs", number_of(options.pairs));
  add("the option cached_passes", std::to_string(options.cached_passes));
  add("the option tile_sites", std::to_string(options.tile_sites));
}

void RunIdentity::add_domain(const Domain& domain) {
  ByteWriter box;
  const int dimension = domain.has_box() ? domain.box().dimension() : 0;
  for (int d = 0; d < dimension; ++d) {
    box.put(domain.box().lower[d]);
    box.put(domain.box().upper[d]);
    box.put(domain.is_periodic(d));
  }
  add_digest("the bounds of the domain", digest(box.bytes));
}

RunIdentity::RunIdentity(ByteReader& in) : version_(get_text(in)) {
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
    Given& part = parts_.emplace_back();
    part.name = get_text(in);
    part.value = get_text(in);
    part.said = in.get<bool>();
  }
}

void RunIdentity::save(ByteWriter& out) const {
  put_text(out, version_);
  out.put(std::uint64_t{parts_.size()});
  for (const Given& part : parts_) {
    put_text(out, part.name);
    put_text(out, part.value);
    out.put(part.said);
  }
}

std::string RunIdentity::objection_to(const RunIdentity& kept) const {
  if (kept.version_ != version_) {
    return "was written by version " + kept.version_ + ", and this is " + version_ +
           ": only the same can continue it";
  }
  if (kept.parts_.size() != parts_.size()) throw Damaged();
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Given& there = kept.parts_[k];
    const Given& here = parts_[k];
    if (there.name != here.name) throw Damaged();
    if (there.value == here.value) continue;
    if (!here.said) return "is of another run: " + here.name + " are not the same";
    return "is of another run: " + here.name + " is " + there.value + " there, and here " +
           here.value;
  }
  return {};
}

template PointDigests digests_of_points(const Problem<float>&, const Arena&);
template PointDigests digests_of_points(const Problem<double>&, const Arena&);
template RunIdentity::RunIdentity(const Problem<float>&, const Options&, const PointDigests&);
template RunIdentity::RunIdentity(const Problem<double>&, const Options&, const PointDigests&);

}  // namespace ccvt
