"""What results say about themselves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Iteration(NamedTuple):
    """One iteration: a pass over pairs of sites, and the update of the sites after it.

    Attributes
    ----------
    iteration : int
        From 1.
    level, levels : int
        The level that is relaxed, 0 being the coarsest, and how many there are.
    points : int
        Points that take part on this level.
    full : bool
        Whether the pass was a full one, and not over cached pairs.
    pairs, swaps, exchanged : int
        Pairs examined, pairs that exchanged points, points that changed owner.
    active_sites : int
        Sites whose cell changed.
    energy : float
        Sum of squared distances; falls within a level.
    seconds : float
        Since the start of the run.
    progress : float
        Of the whole run, from 0 to 1.
    """

    iteration: int
    level: int
    levels: int
    points: int
    full: bool
    pairs: int
    swaps: int
    exchanged: int
    active_sites: int
    energy: float
    seconds: float
    progress: float


class Phase(NamedTuple):
    """How long a part of a run took: on the clock, and of it the work of all threads together."""

    name: str
    seconds: float
    work_seconds: float
    loops: int
    tasks: int


@dataclass(frozen=True)
class Summary:
    """What happened in a run. ``print(summary)`` shows all of it as a table.

    Energies are sums of squared distances in the units of the points.

    Attributes
    ----------
    termination : str
        ``"stable"``, ``"blue_noise"``, ``"energy_tolerance"``, ``"iteration_limit"``,
        ``"time_limit"`` or ``"cancelled"``; ``"running"`` while a solver has not ended.
    normalized_energy : float or None
        energy * n^(2/D) / (m * volume^(2/D)), about 0.17 for good sites in 2D. None where the
        domain has no volume.
    capacity_error : float
        Mean over the sites of (size / mean size - 1)^2: 0 for equal cells.
    phases : list of Phase
    log : list of Iteration
    warnings : list of str
        What makes the result worse than it need be.
    """

    termination: str
    dimension: int
    points: int
    sites: int
    threads_used: int
    seed: int
    initialization_used: str
    levels: int
    iterations: int
    pairs: int
    swaps: int
    exchanged: int
    initial_energy: float
    energy: float
    normalized_energy: Optional[float]
    capacity_error: float
    seconds_total: float
    seconds_initialization: float
    seconds_relaxation: float
    phases: List[Phase] = field(repr=False)
    log: List[Iteration] = field(repr=False)
    warnings: List[str]
    brief: str = field(repr=False)
    full: str = field(repr=False)

    def __str__(self) -> str:
        return self.full


def summary_of(values: Dict[str, Any]) -> Summary:
    values["phases"] = [Phase._make(phase) for phase in values["phases"]]
    values["log"] = [Iteration._make(record) for record in values["log"]]
    return Summary(**values)


@dataclass(frozen=True, eq=False)
class Result:
    """Sites, and who owns the points.

    Attributes
    ----------
    sites : ndarray of shape (n, D)
        The centroid of each cell, in the type that was computed in.
    owners : ndarray of int32, shape (m,)
        The owner of each point, in 0..n-1.
    summary : Summary
    """

    sites: Array = field(repr=False)
    owners: Array = field(repr=False)
    summary: Summary

    def cells(self) -> List[Array]:
        """The numbers of the points of each site, ascending.

        Examples
        --------
        >>> import numpy as np, ccvt
        >>> result = ccvt.tessellate(np.array([[0.0], [5.0], [0.1], [5.1]]), 2, seed=1)
        >>> sorted(cell.tolist() for cell in result.cells())
        [[0, 2], [1, 3]]
        """
        order = np.argsort(self.owners, kind="stable")
        counts = np.bincount(self.owners, minlength=len(self.sites))
        return np.split(order, np.cumsum(counts)[:-1])

    def __repr__(self) -> str:
        n, dimension = self.sites.shape
        return f"<{type(self).__name__}: {n} sites in {dimension}D, {self.summary.brief}>"


@dataclass(frozen=True, eq=False, repr=False)
class PointSample(Result):
    """What :func:`ccvt.sample` returns: with the points under the cells.

    Attributes
    ----------
    points : ndarray of shape (m, D)
    """

    points: Array = field(repr=False)


@dataclass(frozen=True, eq=False, repr=False)
class MassResult(Result):
    """What :func:`ccvt.tessellate` returns for points with masses.

    Attributes
    ----------
    masses, capacities : ndarray of float64, shape (n,)
        The mass of each cell, and what it is to be.
    largest_mass_error : float
        The largest difference of the two.
    mass_error_bound : float
        Every difference is below it, whatever the points; infinite for ``"resampled"``.
    shares : tuple of three ndarrays
        Point, site and mass of each share, by point; empty for ``"whole"``.
    """

    masses: Array
    capacities: Array
    largest_mass_error: float
    mass_error_bound: float
    shares: Any


@dataclass(frozen=True, eq=False)
class _Samples:
    sites: Array
    capacities: Array
    weights: Array
    radii: Array
    points: Array
    owners: Array
    summary: Summary
    dtype: "np.dtype[Any]"

    def __repr__(self) -> str:
        n, dimension = self.sites.shape
        return f"<{type(self).__name__}: {n} sites in {dimension}D, {self.summary.brief}>"


@dataclass(frozen=True, eq=False, repr=False)
class VolumeSamples(_Samples):
    """Samples that spread evenly through a density.

    Attributes
    ----------
    sites : ndarray of float64, shape (n, D)
        In the world, coordinates in the order of the array's axes (or what `affine` makes of them).
    capacities : ndarray of int32
        How many points each site owns.
    weights : ndarray of float64
        The sum over sites of weight * f(site) approximates the integral of density * f.
    radii : ndarray of float64
        The local spacing.
    points, owners : ndarray
        With `keep_points` only, else empty.
    put_back : int
        Sites whose cells bent around places of density 0, and that were put on the nearest of
        their own points, up to `farthest_put_back` away.
    summary : Summary
    dtype : numpy.dtype
        What was computed in.
    """

    put_back: int
    farthest_put_back: float


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceSamples(_Samples):
    """Samples that spread evenly over a surface.

    Attributes
    ----------
    sites : ndarray of float64, shape (n, 3)
        On the surface.
    normals : ndarray of float64, shape (n, 3)
    triangles : ndarray of int32
        The triangle that each lies on.
    barycentric : ndarray of float64, shape (n, 3)
    capacities, weights, radii, points, owners, summary, dtype
        As in :class:`VolumeSamples`.
    area : float
        Of all triangles.
    """

    normals: Array
    triangles: Array
    barycentric: Array
    area: float


@dataclass(frozen=True, eq=False)
class Stippling:
    """A picture made of equal black dots on white, in pixels: x to the right, y down.

    Attributes
    ----------
    sites : ndarray of shape (n, 2)
        The centres (x, y) of the dots.
    width, height : int
        Of the picture.
    dot_radius : float
        At which the dots cover as much as the picture's ink would.
    put_back : int
        Dots on pixels that are not dark at all, as between two letters, that were put on the nearest
        of their own points, up to `farthest_put_back` pixels away.
    summary : Summary
    """

    sites: Array
    width: int
    height: int
    dot_radius: float
    summary: Summary
    put_back: int = 0
    farthest_put_back: float = 0.0

    def __repr__(self) -> str:
        return f"<Stippling: {len(self.sites)} dots of radius {self.dot_radius:.3g}>"


@dataclass(frozen=True, eq=False)
class Thinning:
    """Some of the points, and what each stands for.

    Attributes
    ----------
    chosen : ndarray of int32, shape (n,)
        The numbers of the chosen points, ascending.
    owners : ndarray of int32, shape (m,)
        Of each point, for which of the chosen ones it counts, in 0..n-1.
    counts : ndarray of int32, shape (n,)
        How many points count for each.
    energy : float
        Sum of squared distances of all points to the chosen ones that they count for.
    spacing : float
    moves, jumps, turned : int
    summary : Summary
    """

    chosen: Array
    owners: Array
    counts: Array
    energy: float
    spacing: float
    moves: int
    jumps: int
    turned: int
    summary: Summary

    def __repr__(self) -> str:
        return f"<Thinning: {len(self.chosen)} of {len(self.owners)} points>"


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The power spectrum of point sets. Frequencies are in 1 / mean spacing; white noise has power 1.

    Attributes
    ----------
    frequency, lower, upper : ndarray
        The middle and the bounds of the rings of the radial average.
    frequencies, power, anisotropy_db : ndarray
        Of each ring.
    periodogram : ndarray or None
        The power at every frequency, 0 in the middle; the last axis is the first dimension. None
        where frequencies were drawn, as in more than 3 dimensions.
    low_frequency_power, low_frequency_slope, low_frequency_slope_error : float
        Mean power below a quarter, and the slope of its logarithm.
    peak, peak_frequency, effective_nyquist, oscillation : float
    """

    frequency: Array
    lower: Array
    upper: Array
    frequencies: Array
    power: Array
    anisotropy_db: Array
    periodogram: Optional[Array]
    low_frequency_power: float
    low_frequency_slope: float
    low_frequency_slope_error: float
    peak: float
    peak_frequency: float
    effective_nyquist: float
    oscillation: float

    def __repr__(self) -> str:
        return f"<Spectrum: {len(self.power)} rings, peak {self.peak:.3g} at {self.peak_frequency:.3g}>"


@dataclass(frozen=True, eq=False)
class Analysis:
    """How good point sets are. Figures that do not exist are NaN.

    Attributes
    ----------
    dimension, points, sets : int
    smallest_distance, mean_distance : float
        To the nearest neighbour, as shares of the densest packing's.
    spectrum : Spectrum
    pair_distance, pair_correlation : ndarray
        g(r), and r, the middle of each bin, in mean spacings.
    psi6_local, psi6_global, six_sided : float
        Bond order; in 2D only.
    star_discrepancy : float
        In the L2 norm.
    integration_gaussian, integration_disk, integration_step : float
        Variance of integrals of such functions, over that of white noise.
    """

    dimension: int
    points: int
    sets: int
    smallest_distance: float
    mean_distance: float
    spectrum: Spectrum
    pair_distance: Array = field(repr=False)
    pair_correlation: Array = field(repr=False)
    psi6_local: float
    psi6_global: float
    six_sided: float
    star_discrepancy: float
    integration_gaussian: float
    integration_disk: float
    integration_step: float
