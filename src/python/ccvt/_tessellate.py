"""Tessellations of given points."""

from __future__ import annotations

from typing import (
    Any,
    Callable,
    Dict,
    Iterator,
    Optional,
    Sequence,
    SupportsIndex,
    Tuple,
    Union,
    overload,
)

import numpy as np
from numpy.typing import ArrayLike

from . import _ccvt, _checks
from ._progress import Listener, listener
from ._records import Array, Iteration, MassResult, Result, Summary, summary_of

Progress = Union[bool, None, Callable[[Iteration], Any]]
Periodic = Union[bool, Sequence[bool], Array]


def _sites(sites: Any, points: Array) -> Tuple[int, Optional[Array]]:
    """How many there are, and where they start if that is given."""
    if np.ndim(sites) == 0:
        return _checks.whole("sites", sites, 1), None
    start = _checks.table("sites", sites, points.dtype)
    if start.shape[1] != points.shape[1]:
        raise ValueError(
            f"sites: have {start.shape[1]} dimensions, the points {points.shape[1]}: the two must be "
            "equal"
        )
    return len(start), start


def _given(
    points: Array,
    start: Optional[Array],
    capacities: Any,
    box: Any,
    periodic: Any,
    fixed_sites: Any,
    owners: Any,
) -> Dict[str, Any]:
    corners, along = _checks.domain_of(box, periodic, points.shape[1])
    given: Dict[str, Any] = {"along": along}
    if corners is not None:
        given["box"] = corners
    if start is not None:
        given["initial_sites"] = start
    if capacities is not None:
        given["capacities"] = _checks.indices("capacities", capacities)
    if fixed_sites is not None:
        given["fixed_sites"] = _checks.table("fixed_sites", fixed_sites, points.dtype)
    if owners is not None:
        given["initial_owners"] = _checks.indices("owners", owners)
    return given


class Solver:
    """A tessellation, one iteration at a time: an iterator of :class:`Iteration`.

    Arguments are those of :func:`tessellate`. The points are looked at where they are, and must not
    be changed while the solver is used. While a step is at work in one thread, others may call
    :meth:`cancel`; all else raises RuntimeError there.

    Parameters
    ----------
    points : array_like of shape (m, D)
    sites : int or array_like of shape (n, D)
    capacities, box, periodic, fixed_sites, owners, seed, threads, until, max_iterations, \
energy_tolerance, time_limit, preset
        As for :func:`tessellate`.

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> points = np.random.default_rng(1).random((6400, 2))
    >>> solver = ccvt.Solver(points, 100, seed=1)
    >>> energies = [record.energy for record in solver]
    >>> solver.summary.termination
    'stable'
    >>> len(energies) == solver.summary.iterations
    True
    >>> solver.sites.shape
    (100, 2)
    """

    def __init__(
        self,
        points: ArrayLike,
        sites: Union[SupportsIndex, ArrayLike],
        *,
        capacities: Optional[ArrayLike] = None,
        box: Optional[ArrayLike] = None,
        periodic: Periodic = False,
        fixed_sites: Optional[ArrayLike] = None,
        owners: Optional[ArrayLike] = None,
        seed: SupportsIndex = 0,
        threads: SupportsIndex = 0,
        until: Optional[str] = None,
        max_iterations: Optional[SupportsIndex] = None,
        energy_tolerance: float = 0.0,
        time_limit: float = 0.0,
        preset: Optional[str] = None,
    ) -> None:
        options = _checks.run_options(
            seed=seed,
            threads=threads,
            until=until,
            max_iterations=max_iterations,
            energy_tolerance=energy_tolerance,
            time_limit=time_limit,
            preset=preset,
        )
        checked = _checks.table("points", points)
        count, start = _sites(sites, checked)
        given = _given(checked, start, capacities, box, periodic, fixed_sites, owners)
        self._solver = _ccvt.make_solver(checked, count, given, options, None)

    def __iter__(self) -> Iterator[Iteration]:
        return self

    def __next__(self) -> Iteration:
        """One iteration. Ctrl-C ends the run with the termination ``"cancelled"``."""
        before = self._solver.iterations()
        self._solver.step()
        if self._solver.iterations() == before:
            raise StopIteration
        return Iteration._make(self._solver.last())

    def run(self) -> "Solver":
        """Iterates until the run has ended; returns the solver."""
        self._solver.run()
        return self

    def cancel(self) -> None:
        """Ends the run with the termination ``"cancelled"``, unless it has ended already.

        Other threads and handlers of signals may call it while the solver is at work, which then ends
        within a fraction of a second.
        """
        self._solver.cancel()

    @property
    def sites(self) -> Array:
        """ndarray of shape (n, D): where the sites are now. A copy."""
        return self._solver.sites()

    @property
    def owners(self) -> Array:
        """ndarray of int32, shape (m,): -1 for points that have not joined yet. A copy."""
        return self._solver.owners()

    @property
    def summary(self) -> Summary:
        """What has happened so far."""
        return summary_of(self._solver.summary())


def _result(values: Tuple[Array, Array, Dict[str, Any]]) -> Result:
    return Result(values[0], values[1], summary_of(values[2]))


def _run(
    points: Array, count: int, given: Dict[str, Any], options: Dict[str, Any], heard: Listener
) -> Result:
    solver = _ccvt.make_solver(points, count, given, options, heard)
    solver.run()
    return _result((solver.sites(), solver.owners(), solver.summary()))


# fmt: off
@overload
def tessellate(
    points: ArrayLike, sites: Union[SupportsIndex, ArrayLike], *,
    capacities: Optional[ArrayLike] = ..., box: Optional[ArrayLike] = ..., periodic: Periodic = ...,
    fixed_sites: Optional[ArrayLike] = ..., owners: Optional[ArrayLike] = ..., masses: None = ...,
    method: str = ..., points_per_site: SupportsIndex = ...,
    seed: SupportsIndex = ..., threads: SupportsIndex = ..., progress: Progress = ...,
    until: Optional[str] = ..., max_iterations: Optional[SupportsIndex] = ...,
    energy_tolerance: float = ..., time_limit: float = ..., preset: Optional[str] = ...,
) -> Result: ...
@overload
def tessellate(
    points: ArrayLike, sites: SupportsIndex, *, masses: ArrayLike,
    capacities: Optional[ArrayLike] = ..., box: Optional[ArrayLike] = ..., periodic: Periodic = ...,
    method: str = ..., points_per_site: SupportsIndex = ...,
    seed: SupportsIndex = ..., threads: SupportsIndex = ..., progress: Progress = ...,
    until: Optional[str] = ..., max_iterations: Optional[SupportsIndex] = ...,
    energy_tolerance: float = ..., time_limit: float = ..., preset: Optional[str] = ...,
) -> MassResult: ...
# fmt: on
def tessellate(
    points: ArrayLike,
    sites: Union[SupportsIndex, ArrayLike],
    *,
    capacities: Optional[ArrayLike] = None,
    box: Optional[ArrayLike] = None,
    periodic: Periodic = False,
    fixed_sites: Optional[ArrayLike] = None,
    owners: Optional[ArrayLike] = None,
    masses: Optional[ArrayLike] = None,
    method: str = "whole",
    points_per_site: SupportsIndex = 256,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    until: Optional[str] = None,
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
    preset: Optional[str] = None,
) -> Result:
    """Divides points into cells of given sizes, as compact as exchanges between them can make them.

    Every site owns exactly as many points as its capacity, no exchange of points between any two
    sites lowers the sum of squared distances, and each site is the centroid of its points.

    Parameters
    ----------
    points : array_like of shape (m, D)
        One point a row. Arrays of float32 and float64 whose rows lie in memory without gaps are used
        where they are, and must not be changed meanwhile; others are converted, to float64.
    sites : int or array_like of shape (n, D)
        How many, or where they start.
    capacities : array_like of int, shape (n,), optional
        How many points each site owns, summing to m; equal by default. With `masses`, how much mass.
    box : array_like of shape (2, D), optional
        The lower and the upper corner of the box that holds the points.
    periodic : bool or sequence of D bools, default False
        Whether opposite faces of the box are one, all or along some dimensions.
    fixed_sites : array_like of shape (k, D), optional
        Sites that stay where they are; they count among `sites`, and come first.
    owners : array_like of int, shape (m,), optional
        A warm start: the owner of every point.
    masses : array_like of shape (m,), optional
        Of the points. Cells are then to have equal masses, or those in `capacities`.
    method : {"whole", "resampled"}
        With `masses`: points have one owner each, and cells deviate by less than the heaviest
        point; or points are shared, and masses are exact.
    points_per_site : int, default 256
        With `masses`: unit points for each site that stand for the masses.
    seed : int, default 0
        Fixes every random choice.
    threads : int, default 0
        0: one per processor. Any number gives identical bits.
    progress : callable or bool, optional
        Called after each iteration with an :class:`Iteration`; False stops the run, which then
        returns what has been reached. True draws a bar with tqdm.
    until : {"stable", "blue_noise"}, optional
        Where a run ends; stable by default. See the guide on many points a site.
    max_iterations, energy_tolerance, time_limit : optional
        End the run earlier; the limit in seconds.
    preset : str, optional
        A named set of options, such as ``"fast-ccvt"``, the paper's method.

    Returns
    -------
    Result
        With `sites`, `owners` and `summary`; a :class:`MassResult` when `masses` are given.

    Raises
    ------
    ValueError, TypeError
        For a bad argument; the message names it, the value and the rule.
    KeyboardInterrupt
        On Ctrl-C, within a fraction of a second.

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> points = np.random.default_rng(1).random((10000, 2))
    >>> result = ccvt.tessellate(points, 100, seed=7)
    >>> np.bincount(result.owners).min(), np.bincount(result.owners).max()
    (100, 100)
    >>> bool(np.allclose(result.sites[3], points[result.owners == 3].mean(axis=0)))
    True
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        until=until,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
        preset=preset,
    )
    checked = _checks.table("points", points)
    count, start = _sites(sites, checked)
    if masses is not None:
        for name, value in [("fixed_sites", fixed_sites), ("owners", owners), ("sites", start)]:
            if value is not None:
                raise ValueError(f"{name}: cannot be given with masses")
        return _with_masses(
            checked, count, masses, capacities, box, periodic, method, points_per_site, options, progress
        )
    if method != "whole" or points_per_site != 256:
        raise ValueError("method, points_per_site: are for points with masses")
    given = _given(checked, start, capacities, box, periodic, fixed_sites, owners)
    with listener(progress) as heard:
        return _run(checked, count, given, options, heard)


def _with_masses(
    points: Array,
    count: int,
    masses: Any,
    capacities: Any,
    box: Any,
    periodic: Any,
    method: str,
    points_per_site: SupportsIndex,
    options: Dict[str, Any],
    progress: Progress,
) -> MassResult:
    corners, along = _checks.domain_of(box, periodic, points.shape[1])
    given: Dict[str, Any] = {
        "box": corners,
        "along": along,
        "method": str(method),
        "points_per_site": _checks.whole("points_per_site", points_per_site, 1),
    }
    if capacities is not None:
        given["capacities"] = _checks.vector("capacities", capacities)
    with listener(progress) as heard:
        found = _ccvt.tessellate_masses(
            points, _checks.vector("masses", masses), count, given, options, heard
        )
    return MassResult(
        sites=found["sites"],
        owners=found["owners"],
        summary=summary_of(found["summary"]),
        masses=found["masses"],
        capacities=found["capacities"],
        largest_mass_error=found["largest_mass_error"],
        mass_error_bound=found["mass_error_bound"],
        shares=(found["share_points"], found["share_sites"], found["share_masses"]),
    )


def lloyd(
    points: ArrayLike,
    sites: Union[SupportsIndex, ArrayLike],
    *,
    box: Optional[ArrayLike] = None,
    periodic: Periodic = False,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
) -> Result:
    """Lloyd relaxation: every point is owned by its nearest site. No capacities are kept.

    The baseline that capacities are measured against, also known as k-means. Points that are used
    where they are must not be changed meanwhile.

    Parameters
    ----------
    points, sites, box, periodic, seed, threads, progress, max_iterations, energy_tolerance, \
time_limit
        As for :func:`tessellate`.

    Returns
    -------
    Result

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> points = np.random.default_rng(1).random((1000, 2))
    >>> ccvt.lloyd(points, 10, seed=1).summary.termination
    'stable'
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
    )
    checked = _checks.table("points", points)
    count, start = _sites(sites, checked)
    given = _given(checked, start, None, box, periodic, None, None)
    with listener(progress) as heard:
        return _result(_ccvt.lloyd(checked, count, given, options, heard))
