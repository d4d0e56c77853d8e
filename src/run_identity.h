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

/// Of points, their numbers, from `first` on, and their bits: a sum over points, so that it can be
/// made of parts.
template <class Scalar>
std::uint64_t digest_of_points(const PointsView<Scalar>& points, Index first, const Arena& arena);

/// What the bits of a run follow from, to tell whether two runs are one: a few words on each part.
class RunIdentity {
 public:
  /// `options`: as they are used. `points`: their digest.
  template <class Scalar>
  RunIdentity(const Problem<Scalar>& problem, const Options& options, std::uint64_t points);
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
