#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "ccvt/export.h"
#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "ccvt/summary.h"
#include "ccvt/tessellation.h"

namespace ccvt {

/// Capacity-constrained Voronoi tessellation, one iteration at a time.
///
///     ccvt::Solver solver(problem, options);
///     while (solver.step()) draw(solver.sites());
///
/// The points behind the problem must outlive the solver. Not thread-safe; several solvers may
/// run at the same time. Options::on_iteration may call any of this. Options::cancelled, which is
/// asked in the middle of an iteration, may call cancel(), which is then as if it returned true,
/// sites() and summary(); step(), run(), owners(), save() and load() throw InvalidInput there, and
/// the solver must stay where and what it is.
template <class Scalar>
class CCVT_EXPORT Solver {
 public:
  /// Validates the options (InvalidInput) and assigns the first owners.
  explicit Solver(Problem<Scalar> problem, Options options = {});
  Solver(Solver&&) noexcept;
  Solver& operator=(Solver&&) noexcept;
  ~Solver();

  /// One iteration: a pass and the centroid update after it. An exception thrown by a callback is
  /// passed on, and leaves a solver that may go on, or, when points were joining, one that has been
  /// cancelled. False when the run has ended, for the reason in summary().termination; further
  /// calls then do nothing.
  bool step();
  /// Steps until the run has ended.
  void run();
  /// Ends the run with termination `cancelled`, unless it has ended already.
  void cancel();

  /// Writes what it takes to continue from here to a file, O(m): 4 bytes a point that has joined, 5
  /// where all ranks have more than 2^32, and up to a twentieth more, beside about 80 a site (in 3D
  /// 110), and with many points a site up to 280 more (420); these are in memory meanwhile. It is
  /// written beside the file of that name, flushed to its disk, and renamed; no Publication holds
  /// it back. Throws IoError, and InvalidInput when the run has ended. Of several ranks, which all
  /// call this, the first writes the file, which any other number of ranks, or a solver without,
  /// can load: what others have comes to it in parts of 16 MB, or of a tile that has more.
  void save(const std::filesystem::path& file) const;
  /// Goes to where a solver was when it was saved: of the same problem, options, limits but for
  /// (that is, threads, max_iterations, energy_tolerance, time_limit and callbacks may be others),
  /// and version of the library. From there on both do the same, to the bit. The time of one read
  /// of the file, and of a look at all points. Throws InvalidInput, which says what differs, or is
  /// damaged, or that this run has ended; the solver is then as it was. Of several ranks, which all
  /// call this and throw the same, the first reads the file.
  void load(const std::filesystem::path& file);

  /// #dimensions by n: where the sites are now, rounded to Scalar. In a periodic domain inside the
  /// box, its lower faces included and its upper ones not.
  [[nodiscard]] Points<Scalar> sites() const { return site_columns(); }
  /// The owner of every point. While a coarse level is being relaxed, points that have not yet
  /// joined have the owner -1.
  [[nodiscard]] std::vector<Index> owners() const;
  [[nodiscard]] const Summary& summary() const;

 private:
  [[nodiscard]] Columns<Scalar> site_columns() const;

  struct CCVT_NO_EXPORT Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// What tessellate() returns.
template <class Scalar, int Dimension = Eigen::Dynamic>
struct Result {
  /// #dimensions by n: the centroid of each cell; but see Options::cancelled.
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sites;
  /// The owner of each point, in 0..n-1.
  std::vector<Index> owners;
  Summary summary;

  /// The points of each site.
  [[nodiscard]] Tessellation tessellation() const {
    return {owners, static_cast<Index>(sites.cols())};
  }
};

/// Runs a problem to its end. Time near-linear in m. Memory, beside the points: a copy of
/// them, and about 13 bytes a point; in the start up to 1 kB (2D float) to 4 kB (3D double) a site.
/// Throws InvalidInput for bad options, and when the points are not of `Dimension`.
template <int Dimension = Eigen::Dynamic, class Scalar>
Result<Scalar, Dimension> tessellate(const Problem<Scalar>& problem, const Options& options = {}) {
  if (Dimension != Eigen::Dynamic && problem.dimension() != Dimension) {
    throw InvalidInput("problem: has points of " + std::to_string(problem.dimension()) +
                       " dimensions, but sites of " + std::to_string(Dimension) + " are asked for");
  }
  Solver<Scalar> solver(problem, options);
  solver.run();
  return {solver.sites(), solver.owners(), solver.summary()};
}

/// Tessellates `points` (#dimensions by m, one a column, float or double) into `sites` cells of
/// equal capacity in Euclidean space.
///
///     auto [sites, owners, summary] = ccvt::tessellate(points, 1000, {.threads = 8, .seed = 7});
template <class Derived>
auto tessellate(const Eigen::DenseBase<Derived>& points, Index sites, const Options& options = {}) {
  using Scalar = typename Derived::Scalar;
  return tessellate<Derived::RowsAtCompileTime>(
      Problem<Scalar>(view_points(points), sites, options.threads), options);
}
template <class Scalar>
Result<Scalar> tessellate(const Columns<Scalar>& points, Index sites, const Options& options = {}) {
  return tessellate(points.eigen(), sites, options);
}

}  // namespace ccvt
