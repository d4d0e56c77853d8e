"""Sites that spread evenly over boxes and surfaces, and points that are chosen from others."""

from __future__ import annotations

import time
from typing import Optional, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from . import _ccvt, _checks
from ._progress import listener
from ._records import PointSample, SurfaceSamples, Thinning, summary_of
from ._tessellate import Periodic, Progress, _given, _run


def sample(
    sites: SupportsIndex,
    dim: SupportsIndex = 2,
    *,
    box: Optional[ArrayLike] = None,
    periodic: Periodic = False,
    points_per_site: SupportsIndex = 256,
    distribution: str = "jittered",
    fixed_sites: Optional[ArrayLike] = None,
    dtype: DTypeLike = np.float32,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    until: Optional[str] = "blue_noise",
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
) -> PointSample:
    """Spreads sites evenly over a box, without a pattern: blue noise.

    Parameters
    ----------
    sites : int
        How many.
    dim : int, default 2
        Dimensions.
    box : array_like of shape (2, dim), optional
        The lower and the upper corner; the unit box by default.
    periodic, fixed_sites, seed, threads, progress, until, max_iterations, energy_tolerance, \
time_limit
        As for :func:`tessellate`.
    points_per_site : int, default 256
        Points under each cell. The more, the more even.
    distribution : {"jittered", "white", "square", "hexagonal"}
        How these points lie.
    dtype : float32 or float64
        What is computed in.

    Returns
    -------
    PointSample
        With `sites`, `owners`, `points` and `summary`.

    Examples
    --------
    >>> import ccvt
    >>> sample = ccvt.sample(256, 2, periodic=True, seed=1)
    >>> sample.sites.shape
    (256, 2)
    >>> ccvt.analyze(sample.sites, periodic=True).smallest_distance > 0.6
    True
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        until=until,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
    )
    count = _checks.whole("sites", sites, 1)
    dimension = _checks.whole("dim", dim, 1)
    per_site = _checks.whole("points_per_site", points_per_site, 1)
    number = _checks.whole("sites * points_per_site", count * per_site, 1)
    scalar = _checks.dtype_of(dtype)
    if box is None:
        box = np.array([np.zeros(dimension), np.ones(dimension)])
    corners, _ = _checks.domain_of(box, False, dimension)
    begin = time.monotonic()
    points = _ccvt.sample_uniform(
        corners, number, options["seed"], str(distribution), options["threads"], scalar == np.float64
    )
    if options["time_limit"] > 0:
        # At once where no time is left: 0 would be no limit.
        left = options["time_limit"] - (time.monotonic() - begin)
        options["time_limit"] = max(left, 1e-9)
    given = _given(points, None, None, corners, periodic, fixed_sites, None)
    with listener(progress) as heard:
        found = _run(points, count, given, options, heard)
    return PointSample(found.sites, found.owners, found.summary, points)


def thin(
    points: ArrayLike,
    sites: SupportsIndex,
    normals: Optional[ArrayLike] = None,
    *,
    normal_weight: float = 0.5,
    spread: bool = True,
    equal_counts: bool = False,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    until: Optional[str] = "blue_noise",
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
) -> Thinning:
    """Chooses points that are far apart, and as dense as all of them.

    Parameters
    ----------
    points : array_like of shape (m, D)
        As for :func:`tessellate`: not to be changed meanwhile.
    sites : int
        How many points to choose.
    normals : array_like of shape (m, D), optional
        Sides that face apart are then kept apart. Not to be changed meanwhile either.
    normal_weight : float, default 0.5
        How much the directions of normals count.
    spread : bool, default True
        Whether chosen points are moved apart; faster without.
    equal_counts : bool, default False
        Whether each chosen point stands for as many points as the next; else points count for the
        nearest chosen one.
    seed, threads, progress, until, max_iterations, energy_tolerance, time_limit
        As for :func:`tessellate`.

    Returns
    -------
    Thinning

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> points = np.random.default_rng(1).random((2000, 3))
    >>> few = ccvt.thin(points, 100, seed=1)
    >>> points[few.chosen].shape, few.counts.sum()
    ((100, 3), 2000)
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        until=until,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
    )
    checked = _checks.table("points", points)
    directions = None
    if normals is not None:
        directions = _checks.table("normals", normals, checked.dtype)
    given = {
        "normal_weight": _checks.real("normal_weight", normal_weight),
        "spread": _checks.flag("spread", spread),
        "equal_counts": _checks.flag("equal_counts", equal_counts),
    }
    with listener(progress) as heard:
        found = _ccvt.thin(
            checked, _checks.whole("sites", sites, 1), directions, given, options, heard
        )
    found["summary"] = summary_of(found["summary"])
    return Thinning(**found)


def sample_surface(
    vertices: ArrayLike,
    triangles: ArrayLike,
    sites: SupportsIndex,
    density: Optional[ArrayLike] = None,
    *,
    normal_weight: float = 0.5,
    points_per_site: SupportsIndex = 256,
    keep_points: bool = False,
    dtype: DTypeLike = np.float32,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    until: Optional[str] = "blue_noise",
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
) -> SurfaceSamples:
    """Spreads sites over a triangle mesh.

    Parameters
    ----------
    vertices : array_like of shape (V, 3)
    triangles : array_like of int, shape (F, 3)
        The numbers of the corners, counter-clockwise seen from outside.
    sites : int
        How many.
    density : array_like of shape (V,), optional
        How dense samples are at each vertex.
    normal_weight : float, default 0.5
        How much normals count, so that sheets near each other that face apart share no cell.
    points_per_site, keep_points, dtype, seed, threads, progress, until, max_iterations, \
energy_tolerance, time_limit
        As for :func:`sample_volume`.

    Returns
    -------
    SurfaceSamples

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> samples = ccvt.sample_surface(vertices, [[0, 1, 2], [0, 2, 3]], 20, seed=1)
    >>> round(samples.weights.sum(), 6), samples.normals[0].tolist()
    (1.0, [0.0, 0.0, 1.0])
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        until=until,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
    )
    corners = _checks.table("vertices", vertices, np.float64)
    faces = _checks.indices("triangles", triangles, 2)
    for name, array in [("vertices", corners), ("triangles", faces)]:
        if array.shape[1] != 3:
            raise ValueError(f"{name}: has the shape {array.shape}, but must be (N, 3)")
    given = {
        "normal_weight": _checks.real("normal_weight", normal_weight),
        "points_per_site": _checks.whole("points_per_site", points_per_site, 1),
        "keep_points": _checks.flag("keep_points", keep_points),
    }
    scalar = _checks.dtype_of(dtype)
    densities = None if density is None else _checks.vector("density", density)
    if densities is not None and len(densities) != len(corners):
        raise ValueError(
            f"density: there are {len(densities)} for {len(corners)} vertices: one each is needed"
        )
    count = _checks.whole("sites", sites, 1)
    with listener(progress) as heard:
        found = _ccvt.sample_surface(
            corners, faces, densities, count, given, options, heard, scalar == np.float64
        )
    found["summary"] = summary_of(found["summary"])
    return SurfaceSamples(dtype=scalar, **found)
