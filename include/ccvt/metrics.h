#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/types.h"

/// How good a point set is, in any dimension. Lengths are measured in the mean spacing
/// (|box| / n)^(1/D) and frequencies in its inverse, n^(1/D) in the unit box, so that no figure
/// depends on the size of the box or on n. Figures that do not exist, such as the mean over no
/// frequencies at all, are NaN.
///
/// Everything is computed in double and in a fixed order: no number of threads changes a bit.
/// `threads`: 0 is one per processor; InvalidInput below that, and above 4096.
namespace ccvt {

// Tessellations

/// Sum over points of the squared distance to the owner's site [Balzer et al. 2009, eq. 1], in the
/// domain; where that is periodic, the images in its box are meant. `points`: #dimensions by m,
/// `sites`: #dimensions by n, `owners`: m numbers in 0..n-1; throws InvalidInput where they do not
/// agree.
template <class Scalar>
CCVT_EXPORT double energy(PointsView<Scalar> points, PointsView<Scalar> sites,
                          std::span<const Index> owners, const Domain& domain = {});
template <class A, class B>
double energy(const Eigen::DenseBase<A>& points, const Eigen::DenseBase<B>& sites,
              std::span<const Index> owners, const Domain& domain = {}) {
  return energy(view_points(points), view_points(sites), owners, domain);
}
template <class Scalar>
double energy(const Columns<Scalar>& points, const Columns<Scalar>& sites,
              std::span<const Index> owners, const Domain& domain = {}) {
  return energy(view_points(points), view_points(sites), owners, domain);
}
template <class Scalar, class B>
double energy(const Columns<Scalar>& points, const Eigen::DenseBase<B>& sites,
              std::span<const Index> owners, const Domain& domain = {}) {
  return energy(view_points(points), view_points(sites), owners, domain);
}

/// energy * n^(2/D) / (m * |box|^(2/D)) for n sites and m points: does not depend on the size of
/// the box, and hardly on n and m. Throws InvalidInput unless n, m and all extents are positive,
/// and `energy` is at least 0.
CCVT_EXPORT double normalized_energy(double energy, std::int64_t points, Index sites,
                                     const Box& box);

/// n * sum of c_i^2 / m^2 for cells of c_i points: 1 when all are equal; how much longer than that
/// the search in an inverted file takes [Jégou, Douze, Schmid 2011]. It is 1 + capacity_error().
/// Throws InvalidInput as capacity_error() does.
CCVT_EXPORT double imbalance_factor(std::span<const Index> owners, Index sites);

// Point sets

namespace detail {
/// Points, but for those outside the box by no more than what its corners are rounded by to the
/// Scalar that they come from: these are on its faces.
template <class Scalar>
Columns<double> on_faces(Columns<double> points, const Box& box) {
  if constexpr (sizeof(Scalar) >= sizeof(double)) return points;
  if (box.lower.size() != points.rows() || box.upper.size() != points.rows()) return points;
  for (std::ptrdiff_t p = 0; p < points.cols(); ++p) {
    for (std::ptrdiff_t d = 0; d < points.rows(); ++d) {
      double& x = points(d, p);
      if (x < box.lower[d] && x >= static_cast<Scalar>(box.lower[d])) x = box.lower[d];
      if (x > box.upper[d] && x <= static_cast<Scalar>(box.upper[d])) x = box.upper[d];
    }
  }
  return points;
}
}  // namespace detail

/// A point set and the box that it fills, checked once; the coordinates are copied, in double.
///
///     const ccvt::PointSet set(sites, ccvt::Domain::periodic(ccvt::Box::unit(2)));
class CCVT_EXPORT PointSet {
 public:
  /// `points`: #dimensions by n >= 2, finite, inside the domain's box (its faces included, of
  /// floats as rounded), not all equal. Throws InvalidInput otherwise, and when the domain has no
  /// box, one of which some dimensions are periodic and others are not, or one with corners above
  /// 1e140 in magnitude (less beyond 8192 dimensions) or less than 1e-140 apart.
  template <class Derived>
  PointSet(const Eigen::DenseBase<Derived>& points, Domain domain)
      : PointSet(detail::on_faces<typename Derived::Scalar>(Columns<double>(points), domain.box()),
                 domain) {}
  PointSet(Columns<double> points, Domain domain);

  [[nodiscard]] int dimension() const { return static_cast<int>(points_.rows()); }
  [[nodiscard]] Index count() const { return static_cast<Index>(points_.cols()); }
  [[nodiscard]] Eigen::Map<const Points<double>> points() const& { return points_.eigen(); }
  [[nodiscard]] Points<double> points() const&& { return points_.eigen(); }
  [[nodiscard]] const Domain& domain() const { return domain_; }
  /// (|box| / n)^(1/D).
  [[nodiscard]] double mean_spacing() const { return mean_spacing_; }

 private:
  Columns<double> points_;
  Domain domain_;
  double mean_spacing_ = 0;
};

/// The smallest distance between points of the densest packing known, in mean spacings:
/// 2 delta^(1/D), with the centre densities delta of the best lattices in 1 to 8 dimensions (Z, the
/// hexagonal one, FCC, D4, D5, E6, E7, E8 [Conway, Sloane 1999, table 1.2]). Beyond, by convention,
/// that of E8, sqrt(2): denser lattices are known from 10 dimensions on.
/// Throws InvalidInput unless dimension >= 1.
CCVT_EXPORT double packing_distance(int dimension);

/// Distances to the nearest neighbour, as shares of packing_distance(): the smallest is the
/// relative Poisson-disk radius [Lagae, Dutré 2008], 1 for the densest lattice.
struct NearestDistances {
  double smallest = 0;
  double mean = 0;
};
/// O(n log n) in few dimensions, O(D n^2) where trees do not help. On a torus a point's own images
/// do not count.
CCVT_EXPORT NearestDistances nearest_distances(const PointSet& set, int threads = 0);

/// The pair-correlation function g(r): the density of pairs at distance r over that of independent
/// points, in bins of 1/16 mean spacing up to 4, or to half the smallest extent of the box, which
/// may be less; the last bin ends at or before it.
///
/// On a torus every pair counts 1. In a box a pair whose difference is d counts
/// |box| / prod(extent - |d|), which makes independent points flat at 1 there too [Ohser, Stoyan
/// 1981].
struct PairCorrelation {
  double bin_width = 0;       ///< in mean spacings; bin k covers [k, k + 1) of them
  std::vector<double> value;  ///< mean over the sets
};
/// The sets agree in dimension, count and domain; else, or when there are none, InvalidInput.
CCVT_EXPORT PairCorrelation pair_correlation(std::span<const PointSet> sets, int threads = 0);

/// Order of a 2D point set, told by its Voronoi cells. Points are neighbours where their cells
/// share an edge longer than 10^-4 mean spacings, so that four cells that meet in a corner, as in
/// the square lattice, make no neighbours across it. Coincident points share a cell. In a box cells
/// that touch its border do not count; on a torus all do.
struct BondOrder {
  /// psi(i) is the mean over the neighbours of exp(6 i theta), with theta the direction to them
  /// [Halperin, Nelson 1978]. psi6_local: the mean of |psi|; psi6_global: |mean of psi|. Both are 1
  /// for the hexagonal lattice, and psi6_global near 0 for one with grains of all directions.
  double psi6_local = 0;
  double psi6_global = 0;
  double six_sided = 0;  ///< share of the cells with six neighbours
};
/// O(n log n). Throws InvalidInput unless the set is two-dimensional.
CCVT_EXPORT BondOrder bond_order(const PointSet& set, int threads = 0);

// Spectra

/// How finely, and how far, a spectrum is measured.
struct SpectrumOptions {
  /// Up to which frequency, in 1 / mean spacing. Above 0.
  double max_frequency = 2;
  /// Width of the rings of the radial average, in 1 / mean spacing; 0: one step of the integer
  /// frequencies, but not less than 1/32.
  double ring_width = 0;
  /// Draws frequencies where they are not all visited.
  std::uint64_t seed = 0;
  int threads = 0;
  /// Asked several times a second, from the thread that called; true makes power_spectrum() and
  /// analyze() throw Cancelled.
  std::function<bool()> cancelled = {};
};

/// A ring (in 3D a shell) of frequencies.
struct SpectrumRing {
  double lower = 0;  ///< frequencies f with lower <= |f| < upper, in 1 / mean spacing
  double upper = 0;
  double frequencies = 0;  ///< how many there are, f and -f counted once
  double power = 0;        ///< their mean power: the radially averaged power
  /// Variance of their power over the square of its mean, in dB: -10 log10(#sets) for unstructured
  /// noise [Lagae, Dutré 2008]. -infinity when the power is the same everywhere in the ring, NaN
  /// when there is none or one frequency.
  double anisotropy_db = 0;

  [[nodiscard]] double middle() const { return (lower + upper) / 2; }
};

/// Frequencies below 1/4 that differ by less than 2 %. In a cube those nearest to 0, up to 5 steps
/// of the integer frequencies, are of one length each.
struct LowShell {
  double frequency = 0;    ///< their geometric mean, in 1 / mean spacing
  double frequencies = 0;  ///< how many there are, f and -f counted once
  double power = 0;        ///< their mean power
};

/// The power spectrum of point sets, averaged over the sets:
///
///     P(f) = |sum over points p of exp(-2 pi i f.p)|^2 / n
///
/// at the frequencies f = (k_1 / extent_1, ..., k_D / extent_D), k whole numbers, not all 0. White
/// noise has power 1. In a box that is no torus these are the same frequencies: there white noise
/// is 1 too, but what the border does to other sets lies on the axes of the spectrum.
struct Spectrum {
  int dimension = 0;
  Index points = 0;
  int sets = 0;
  double max_frequency = 0;  ///< in 1 / mean spacing
  /// Rings without a frequency are left out. The last one may be cut by max_frequency.
  std::vector<SpectrumRing> rings;

  /// In up to 3 dimensions, P(f) at every frequency of the box |k_d| <= half[d], the first
  /// dimension fastest, prod(2 half[d] + 1) values with 0 for f = 0 in the middle. Empty when
  /// frequencies were drawn.
  std::vector<int> half;
  std::vector<double> power;

  /// Mean power for 0 < |f| < 1/4, or up to max_frequency where that is less: NaN when there is no
  /// such frequency.
  double low_frequency_power = 0;
  /// The same range in shells, without the frequencies that have no power, less than 1e-9 of that
  /// mean, as lattices and repeated tiles have; of frequencies that were drawn, each once.
  std::vector<LowShell> low_shells;
  /// The slope of log power over log frequency there, and its standard error: 0 for white noise, 4
  /// for the centroids of cells that hold exactly the same mass, when the points under them add no
  /// noise [Liao 2018]. A quarter is a range that any set with 3 steps of the integer frequencies
  /// in it shares, and ends well before the power bends up to the peak.
  ///
  /// Weighted least squares over the shells. Power is taken for an exponential variable at each
  /// frequency of each set, as of any set without long order, so that the log of the mean of c of
  /// them has the mean digamma(c) - log c, which is taken off, and the variance trigamma(c), the
  /// inverse of the weight. Where shells scatter more than that about the line, the error is
  /// as much larger, by the root of chi squared a degree of freedom [Particle Data Group, 5.2.2].
  /// NaN when there are less than two shells.
  double low_frequency_slope = 0;
  double low_frequency_slope_error = 0;
  /// The fitted power is this times frequency^low_frequency_slope.
  double low_frequency_scale = 0;
  /// The highest power of a ring, and the middle of that ring.
  double peak = 0;
  double peak_frequency = 0;
  /// The largest frequency below which the mean power is at most 0.1, told from the rings, which
  /// are taken as even inside; 0 when there is none [Heck, Schlömer, Deussen 2013, 4.2].
  double effective_nyquist = 0;
  /// 10 sqrt(mean of (P - 1)^2) over the frequencies from the first ring with P >= 0.98 on, with P
  /// the radial average [Heck, Schlömer, Deussen 2013, 4.2]; theirs goes to a fixed frequency, ours
  /// to max_frequency. The noise of few sets adds to it. NaN when P stays below 0.98.
  double oscillation = 0;
};

/// The exact periodogram in up to 3 dimensions: all frequencies up to max_frequency, as a product
/// of two matrices, 2 n multiplications a frequency; there are about pi/2 F^2 n of them in 2D.
///
/// In more dimensions, and where that would need more than 2^37 multiplications a set or 1 GiB of
/// memory, as in a very thin box, 128 frequencies are drawn, with replacement and all equally
/// likely, for each ring, and 512 for low_frequency_power: unbiased estimates of the same means. In
/// a box that is no cube, or when max_frequency is more than 256 steps, the frequencies of a ring
/// are told from |f|^2 with each term rounded to a 65536th part of max_frequency^2.
///
/// Throws InvalidInput unless there is a set, all agree in dimension, count and domain, and the
/// options are in range; also when max_frequency makes more than a million rings or is more than
/// 2^30 steps k_d of some dimension, or the drawn frequencies would take more than 1 GiB. It never
/// needs more than twice that. Each drawn frequency takes a sine and a cosine a point, and there
/// may be 128 of them in each of 65537 rings.
CCVT_EXPORT Spectrum power_spectrum(std::span<const PointSet> sets,
                                    const SpectrumOptions& options = {});

// Integration

/// The L2 star discrepancy, with the box as the unit cube: the root mean square, over all boxes
/// from the lower corner, of the share of points inside minus the volume. By the formula of
/// Warnock [1972], whose sum over pairs of points is divided along one axis after the other
/// [Heinrich 1996] where that takes less time: the lesser of O(n log^D n) and O(D n^2). Its terms
/// cancel: not below 10^-8 or so.
CCVT_EXPORT double star_discrepancy(const PointSet& set, int threads = 0);

/// The mean squared error of the mean over the points as an estimate of the integral of f, times n
/// over the variance of f: 1 for white noise [Pilleboue et al. 2015]. Over 256 seeded places of
/// each function, with the box as the unit cube; on a torus the functions wrap around.
struct IntegrationVariance {
  double gaussian = 0;  ///< exp(-|x - c|^2 / (2 s^2)), s = 1/8
  double disk = 0;      ///< |x - c| < 1/4; in a box that is no torus with the disk inside
  double step = 0;      ///< x_d < a; on a torus the half of the box behind it
};
/// Of the places that `seed` draws. O(n) for each function and place; any number of threads gives
/// identical bits.
CCVT_EXPORT IntegrationVariance integration_variance(const PointSet& set, std::uint64_t seed = 0,
                                                     int threads = 0);

// All of it

/// All figures of point sets of one kind, averaged over the sets.
struct Analysis {
  int dimension = 0;
  Index points = 0;
  int sets = 0;
  NearestDistances distances;
  Spectrum spectrum;
  PairCorrelation pairs;
  BondOrder order;  ///< NaN except in 2D
  double star_discrepancy = 0;
  IntegrationVariance integration;
};

/// Throws InvalidInput as power_spectrum() does.
CCVT_EXPORT Analysis analyze(std::span<const PointSet> sets, const SpectrumOptions& options = {});

}  // namespace ccvt
