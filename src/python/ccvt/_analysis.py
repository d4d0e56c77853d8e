"""How good tessellations and point sets are."""

from __future__ import annotations

from typing import Any, List, Optional, Sequence, SupportsIndex, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _ccvt, _checks
from ._records import Analysis, Array, Spectrum
from ._tessellate import Periodic


def analyze(
    points: Union[ArrayLike, Sequence[ArrayLike]],
    *,
    box: Optional[ArrayLike] = None,
    periodic: Periodic = False,
    max_frequency: float = 2.0,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
) -> Analysis:
    """Spectra, distances, order and errors of integration of point sets.

    Parameters
    ----------
    points : array_like of shape (N, D), or a list of such arrays
        Several sets are runs of one kind, and averaged.
    box : array_like of shape (2, D), optional
        That the points fill; the unit box by default.
    periodic : bool or sequence of D bools, default False
        Whether opposite faces of the box are one.
    max_frequency : float, default 2
        Up to which frequency, in 1 / mean spacing.
    seed : int, default 0
        Draws frequencies where they are not all visited, and the places of test functions.
    threads : int, default 0
        0: one per processor. Any number gives identical bits.

    Returns
    -------
    Analysis

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> white = np.random.default_rng(1).random((1000, 2))
    >>> found = ccvt.analyze(white, periodic=True)
    >>> 0.8 < found.spectrum.low_frequency_power < 1.2
    True
    """
    if isinstance(points, (list, tuple)) and len(points) > 0 and np.ndim(points[0]) == 2:
        sets: List[Any] = list(points)
    else:
        sets = [points]
    checked = [_checks.table("points", one) for one in sets]
    dimension = checked[0].shape[1]
    for one in checked:
        if one.shape[1] != dimension:
            raise ValueError(
                f"points: sets have {dimension} and {one.shape[1]} dimensions, but must agree"
            )
    if box is None:
        box = np.array([np.zeros(dimension), np.ones(dimension)])
    corners, along = _checks.domain_of(box, periodic, dimension)
    found = _ccvt.analyze(
        checked,
        corners,
        along,
        _checks.real("max_frequency", max_frequency),
        _checks.seed_of(seed),
        _checks.threads_of(threads),
    )
    found["spectrum"] = Spectrum(**found["spectrum"])
    width = found.pop("pair_bin_width")
    found["pair_distance"] = width * (np.arange(len(found["pair_correlation"])) + 0.5)
    return Analysis(**found)


def energy(
    points: ArrayLike,
    sites: ArrayLike,
    owners: ArrayLike,
    *,
    box: Optional[ArrayLike] = None,
    periodic: Periodic = False,
) -> float:
    """Sum over the points of the squared distance to the owner's site.

    Parameters
    ----------
    points : array_like of shape (m, D)
    sites : array_like of shape (n, D)
    owners : array_like of int, shape (m,)
    box, periodic
        As for :func:`tessellate`.

    Returns
    -------
    float

    Examples
    --------
    >>> import ccvt
    >>> ccvt.energy([[0.0], [1.0], [4.0]], [[0.5], [4.0]], [0, 0, 1])
    0.5
    """
    checked = _checks.table("points", points)
    corners, along = _checks.domain_of(box, periodic, checked.shape[1])
    return _ccvt.energy(
        checked,
        _checks.table("sites", sites, checked.dtype),
        _checks.indices("owners", owners),
        corners,
        along,
    )
