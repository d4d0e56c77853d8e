#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "parallel/alike.h"
#include "parallel/arena.h"
#include "parallel/bytes.h"

namespace ccvt {

/// Sums over the points of all ranks, of their numbers and of what there is of each.
struct PointDigests {
  std::uint64_t points = 0;
  std::uint64_t owners = 0;  ///< initial ones
};
/// On all ranks.
template <class Scalar>
PointDigests digests_of_points(const Problem<Scalar>& problem, const Arena& arena);

/// What the bits of a run follow from, to tell whether two runs are one: a few words on each part.
class RunIdentity {
 public:
  /// `options`: as they are used.
  template <class Scalar>
  RunIdentity(const Problem<Scalar>& problem, const Options& options, const PointDigests& digests);
  explicit RunIdentity(ByteReader& in);
  void save(ByteWriter& out) const;

  /// Empty, or what is wrong with continuing `kept` as this run.
  [[nodiscard]] std::string objection_to(const RunIdentity& kept) const;

  [[nodiscard]] const std::vector<Given>& parts() const { return parts_; }

 private:
  void add(std::string name, std::string value) {
    parts_.push_back({std::move(name), std::move(value)});
  }
  void add_digest(std::string name, std::uint64_t digest);
  void add_options(const Options& options);
  void add_domain(const Domain& domain);

  std::string version_;
  std::vector<Given> parts_;
};

}  // namespace ccvt
