"""Sites as dense as volumes and pictures say."""

from __future__ import annotations

import os
from typing import Any, Dict, Optional, SupportsIndex, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from . import _ccvt, _checks
from ._files import read_image
from ._progress import listener
from ._records import Array, Stippling, VolumeSamples, summary_of
from ._tessellate import Progress

_VALUES = "i1 u1 i2 u2 i4 u4 i8 u8 f4 f8".split()


def _values(array: Any) -> Array:
    """Contiguous values, in C or Fortran order, of a type that the library takes."""
    values = _checks.plain("array", array)
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    elif values.dtype.kind == "f" and values.dtype.itemsize not in (4, 8):
        values = values.astype(np.float32 if values.dtype.itemsize < 4 else np.float64)
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    if values.dtype.str[1:] not in _VALUES:
        raise ValueError(f"array: is of {values.dtype}, but must be of real numbers")
    if values.ndim == 0 or values.size == 0:
        raise ValueError(f"array: has the shape {values.shape}, but needs a value and a dimension")
    if values.flags.f_contiguous and not values.flags.c_contiguous:
        return np.require(values, requirements=["F", "A"])
    return _checks.contiguous(values)


def _placement(affine: Any, dimension: int) -> Tuple[Array, Array]:
    """The world's directions along each axis of the array, as columns, and where it starts."""
    if affine is None:
        return np.eye(dimension), np.zeros(dimension)
    matrix = _checks.as_float("affine", affine, np.float64)
    if matrix.shape not in [(dimension + 1, dimension + 1), (dimension, dimension + 1)]:
        raise ValueError(
            f"affine: has the shape {matrix.shape}, but an array of {dimension} dimensions needs "
            f"({dimension + 1}, {dimension + 1}) or ({dimension}, {dimension + 1})"
        )
    if len(matrix) > dimension and not np.array_equal(matrix[-1], np.eye(dimension + 1)[-1]):
        raise ValueError(f"affine: its last row is {matrix[-1]}, but must be 0 .. 0 1")
    return matrix[:dimension, :dimension], _checks.contiguous(matrix[:dimension, dimension])


def _map(
    values: Array,
    mask: Optional[Array],
    window: Any,
    threshold: Any,
    gamma: Any,
    invert: bool,
) -> Dict[str, Any]:
    chosen = [name for name, value in [("window", window), ("threshold", threshold), ("gamma", gamma)]
              if value is not None]  # fmt: skip
    if len(chosen) > 1:
        raise ValueError(f"{chosen[1]}: cannot be given with {chosen[0]}")
    given: Dict[str, Any] = {
        "map": chosen[0] if chosen else "linear",
        "low": 0.0,
        "high": 1.0,
        "gamma": 1.0,
        "invert": _checks.flag("invert", invert),
        "greatest": 0.0,
    }
    if window is not None:
        if np.shape(window) != (2,):
            raise ValueError(f"window: is {window!r}, but must be (low, high)")
        low, high = window
        given.update(low=_checks.finite("window", low), high=_checks.finite("window", high))
    elif threshold is not None:
        given.update(low=_checks.finite("threshold", threshold))
    else:
        if gamma is not None:
            given.update(gamma=_checks.real("gamma", gamma))
        if gamma is not None or invert:
            inside = values if mask is None else values[mask != 0]
            finite = inside[np.isfinite(inside)]
            greatest = float(finite.max()) if finite.size else 0.0
            if finite.size < inside.size:
                greatest = max(greatest, 1.0)  # any that lets the library come to what is not finite
            if gamma is not None and greatest <= 0:
                raise ValueError(f"gamma: the greatest value is {greatest}, but must be positive")
            given.update(greatest=greatest)
    return given


def sample_volume(
    array: ArrayLike,
    sites: SupportsIndex,
    affine: Optional[ArrayLike] = None,
    mask: Optional[ArrayLike] = None,
    *,
    window: Optional[Tuple[float, float]] = None,
    threshold: Optional[float] = None,
    gamma: Optional[float] = None,
    invert: bool = False,
    interpolation: str = "linear",
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
) -> VolumeSamples:
    """Puts sites into a field of values, as dense as it says.

    Parameters
    ----------
    array : array_like of any number of dimensions D
        The values, of any real type, none negative. Contiguous arrays, in C or Fortran order, are
        used where they are, and must not be changed meanwhile; the same values in the other order
        give other samples, as good.
    sites : int
        How many.
    affine : array_like of shape (D + 1, D + 1), optional
        Takes indices of the array to the world, as nibabel's do: value [i, j, k] has its centre at
        ``affine @ (i, j, k, 1)``. By default the world is that of the indices.
    mask : array_like of the shape of `array`, optional
        Values count where it is not 0.
    window : (low, high), optional
        The density is 0 at low and below, 1 at high and above, linear in between.
    threshold : float, optional
        The density is 1 at that value and above, and 0 below.
    gamma : float, optional
        The density is (value / greatest value)^gamma.
    invert : bool, default False
        Dense where values are low.
    interpolation : {"linear", "constant"}
        What the density is between the centres of cells.
    points_per_site : int, default 256
        Points drawn for each site.
    keep_points : bool, default False
        Whether the result holds these points and their owners.
    dtype : float32 or float64
        What is computed in, relative to the middle of the array.
    seed, threads, progress, until, max_iterations, energy_tolerance, time_limit
        As for :func:`tessellate`.

    Returns
    -------
    VolumeSamples

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> density = np.zeros((8, 8, 8))
    >>> density[:4] = 1
    >>> samples = ccvt.sample_volume(density, 50, seed=1)
    >>> bool(samples.sites[:, 0].max() < 3.5), round(samples.weights.sum())
    (True, 256)
    """
    options = _checks.run_options(
        seed=seed,
        threads=threads,
        until=until,
        max_iterations=max_iterations,
        energy_tolerance=energy_tolerance,
        time_limit=time_limit,
    )
    values = _values(array)
    directions, origin = _placement(affine, values.ndim)
    first_fastest = values.flags.f_contiguous
    # The library's first axis is the one that varies fastest in memory.
    shape = list(values.shape if first_fastest else values.shape[::-1])
    axes = directions.T if first_fastest else directions.T[::-1]
    bytes_of_mask: Optional[Array] = None
    if mask is not None:
        counts = _checks.plain("mask", mask)
        if counts.dtype.kind not in "fiub":
            raise ValueError(f"mask: is an array of {counts.dtype}, but must be of real numbers")
        if counts.shape != values.shape:
            raise ValueError(f"mask: has the shape {counts.shape}, but the array has {values.shape}")
        inside = (counts != 0) & (counts == counts)  # NaN is outside
        bytes_of_mask = np.asarray(inside, np.uint8, order="F" if first_fastest else "C")
    if interpolation not in ("linear", "constant"):
        raise ValueError(f"interpolation: is {interpolation!r}, but must be linear or constant")
    given: Dict[str, Any] = {
        "values": values,
        "shape": shape,
        "axes": _checks.contiguous(axes),
        "origin": origin,
        "interpolation": interpolation,
        "points_per_site": _checks.whole("points_per_site", points_per_site, 1),
        "keep_points": _checks.flag("keep_points", keep_points),
        **_map(values, bytes_of_mask, window, threshold, gamma, invert),
    }
    if bytes_of_mask is not None:
        given["mask"] = bytes_of_mask
    scalar = _checks.dtype_of(dtype)
    with listener(progress) as heard:
        found = _ccvt.sample_volume(
            given, _checks.whole("sites", sites, 1), options, heard, scalar == np.float64
        )
    found["summary"] = summary_of(found["summary"])
    return VolumeSamples(dtype=scalar, **found)


def _grey(image: Any) -> Array:
    """A grey picture of float32 in [0, 1], as :func:`read_image` gives it."""
    if isinstance(image, (str, os.PathLike)):
        return read_image(image)
    pixels = _checks.plain("image", image)
    pixels = pixels.astype(pixels.dtype.newbyteorder("="), copy=False)
    if pixels.dtype in (np.uint8, np.uint16):
        values = pixels.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    elif pixels.dtype.kind == "f":
        values = pixels.astype(np.float32, copy=False)
    elif pixels.dtype.kind == "b":
        values = pixels.astype(np.float32)
    else:
        raise ValueError(
            f"image: is of {pixels.dtype}, but must be of uint8, uint16, bool or floats from 0 to 1"
        )
    if values.ndim == 3 and values.shape[2] == 4:
        values = values[..., :3] * values[..., 3:] + (1 - values[..., 3:])
    if values.ndim == 3 and values.shape[2] == 3:
        values = (values @ np.array([0.2126, 0.7152, 0.0722])).astype(np.float32)
    if values.ndim != 2 or values.size == 0:
        raise ValueError(
            f"image: has the shape {pixels.shape}, but must be (height, width), or with 3 or 4 "
            "channels of colour"
        )
    return _checks.shades("image", values)


def stipple(
    image: Union[str, os.PathLike[str], ArrayLike],
    dots: SupportsIndex,
    *,
    invert: bool = False,
    gamma: float = 1.0,
    dot_radius: float = 0.0,
    points_per_site: SupportsIndex = 256,
    dtype: DTypeLike = np.float32,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
    progress: Progress = None,
    until: Optional[str] = "blue_noise",
    max_iterations: Optional[SupportsIndex] = None,
    energy_tolerance: float = 0.0,
    time_limit: float = 0.0,
) -> Stippling:
    """Makes a picture of equal dots.

    Parameters
    ----------
    image : path or array_like
        A PNG or JPEG file, or an array of shape (height, width), grey, or (height, width, 3 or 4),
        colours: of uint8, uint16, or floats from 0, black, to 1, white.
    dots : int
        How many.
    invert : bool, default False
        Dots where the picture is light.
    gamma : float, default 1
        Exponent on the darkness; above 1 there are fewer dots in the light parts.
    dot_radius : float, default 0
        In pixels; 0: that at which dots cover as much as the picture's ink would.
    points_per_site : int, default 256
        Points drawn for each dot.
    dtype, seed, threads, progress, until, max_iterations, energy_tolerance, time_limit
        As for :func:`sample`.

    Returns
    -------
    Stippling
        With `sites`, the centres of the dots. :func:`render` draws it, :func:`write_svg` prints it.

    Examples
    --------
    >>> import numpy as np, ccvt
    >>> ramp = np.tile(np.linspace(0, 1, 64), (64, 1))
    >>> picture = ccvt.stipple(ramp, 200, seed=1)
    >>> picture.sites.shape
    (200, 2)
    >>> bool(np.mean(picture.sites[:, 0] < 32) > 0.7)
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
    given = {
        "invert": _checks.flag("invert", invert),
        "gamma": _checks.real("gamma", gamma),
        "dot_radius": _checks.real("dot_radius", dot_radius),
        "points_per_site": _checks.whole("points_per_site", points_per_site, 1),
    }
    count = _checks.whole("dots", dots, 1)
    scalar = _checks.dtype_of(dtype)
    with listener(progress) as heard:
        found = _ccvt.stipple(_grey(image), count, given, options, heard, scalar == np.float64)
    found["summary"] = summary_of(found["summary"])
    return Stippling(**found)


def render(stippling: Stippling, scale: float = 0.0) -> Array:
    """Draws the dots of a stippling, black on white.

    Parameters
    ----------
    stippling : Stippling
    scale : float, default 0
        Times the size of the picture; 0: as large as it takes for dots of radius 3.

    Returns
    -------
    ndarray of float32, shape (height, width)
        From 0, black, to 1, white.
    """
    return _ccvt.render(
        _checks.table("sites", stippling.sites),
        stippling.width,
        stippling.height,
        stippling.dot_radius,
        _checks.real("scale", scale),
    )
