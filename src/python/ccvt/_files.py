"""Readers and writers of the library's file formats. They go by the extension of the name.

Writers replace a file as a whole: whoever opens it finds all of the old one or all of the new one.
Readers and writers raise ValueError for what is wrong with a file or an extension, and OSError when
the system refuses.
"""

from __future__ import annotations

import errno
import os
from typing import Any, Dict, NamedTuple, Optional, Sequence, SupportsIndex, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from . import _ccvt, _checks
from ._records import Array, Stippling, SurfaceSamples, VolumeSamples

Path = Union[str, "os.PathLike[str]"]


def _named(path: Path) -> bytes:
    """The name as the system has it, which need be no text."""
    name = os.fsencode(path)
    if b"\0" in name:
        raise ValueError(f"path: {os.fspath(path)!r} has a null character")
    return name


def _existing(path: Path) -> bytes:
    """The library takes a missing file for a wrong name; Python has an error of its own for it."""
    name = _named(path)
    if not os.path.exists(name):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(path))
    return name


def read_points(
    path: Path, columns: Optional[Sequence[Union[str, int]]] = None, dtype: Optional[DTypeLike] = None
) -> Array:
    """Reads points: .npy, .csv, .txt, .ply, .fvecs, .bvecs, .gadget and .hdf5.

    Parameters
    ----------
    path : path
    columns : sequence of str or int, optional
        The columns that are coordinates, by name, or by number from 1.
    dtype : float32 or float64, optional
        By default as the file has them; text is float64.

    Returns
    -------
    ndarray of shape (N, D)

    Examples
    --------
    >>> import ccvt, os, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     name = os.path.join(folder, "points.csv")
    ...     ccvt.write_points(name, [[0.5, 1], [2, 3]])
    ...     ccvt.read_points(name)
    array([[0.5, 1. ],
           [2. , 3. ]])
    """
    names = [str(column) for column in columns] if columns is not None else []
    scalar = "" if dtype is None else _checks.dtype_of(dtype).name
    return _ccvt.read_points(_existing(path), names, scalar)


def write_points(path: Path, points: ArrayLike) -> None:
    """Writes points, one a row or line: .npy, .csv and .txt.

    Parameters
    ----------
    path : path
    points : array_like of shape (N, D)
    """
    _ccvt.write_points(_named(path), _checks.table("points", points))


def read_owners(path: Path) -> Array:
    """Reads whole numbers, such as owners or capacities: .npy, .csv and .txt.

    Parameters
    ----------
    path : path

    Returns
    -------
    ndarray of int32, shape (N,)
    """
    return _ccvt.read_indices(_existing(path))


def write_owners(path: Path, owners: ArrayLike) -> None:
    """Writes whole numbers, such as owners: .npy, .csv and .txt.

    Parameters
    ----------
    path : path
    owners : array_like of int, shape (N,)
    """
    _ccvt.write_owners(_named(path), _checks.indices("owners", owners))


def read_numbers(path: Path) -> Array:
    """Reads numbers, such as masses: .npy, .csv and .txt.

    Parameters
    ----------
    path : path

    Returns
    -------
    ndarray of float64, shape (N,)
    """
    return _ccvt.read_numbers(_existing(path))


def read_image(path: Path) -> Array:
    """Reads a PNG or JPEG file in grey, turned upright as Exif data say.

    Parameters
    ----------
    path : path

    Returns
    -------
    ndarray of float32, shape (height, width)
        From 0, black, to 1, white, as stored.
    """
    return _ccvt.read_image(_existing(path))


def write_png(path: Path, image: ArrayLike) -> None:
    """Writes a PNG file of 8 bits.

    Parameters
    ----------
    path : path
    image : array_like
        Of floats from 0 to 1 and shape (height, width): grey; of uint8 and shape (height, width) or
        (height, width, 3): grey or colours.
    """
    pixels = _checks.plain("image", image)
    if pixels.ndim == 3 and pixels.shape[2] == 3 and pixels.dtype == np.uint8:
        _ccvt.write_colour(_named(path), np.ascontiguousarray(pixels))
        return
    if pixels.ndim != 2 or pixels.dtype.kind not in "fu":
        raise ValueError(
            f"image: is an array of {pixels.dtype} of shape {pixels.shape}, but must be grey, "
            "(height, width), or uint8 of (height, width, 3)"
        )
    if pixels.dtype.kind == "u":
        pixels = pixels / np.float32(np.iinfo(pixels.dtype).max)
    _ccvt.write_grey(_named(path), _checks.shades("image", pixels))


class VolumeFile(NamedTuple):
    """What :func:`read_volume` returns: ``data``, and the ``affine`` that takes indices to the world."""

    data: Array
    affine: Array


def read_volume(path: Path) -> VolumeFile:
    """Reads a volume: .nii, .nii.gz, .nrrd, .nhdr and .npy.

    Parameters
    ----------
    path : path

    Returns
    -------
    VolumeFile
        ``data`` of shape (X, Y, Z), in Fortran order, or as an .npy file has it, in the type of the
        file unless that scales its numbers, and ``affine`` of shape (4, 4): as
        :func:`sample_volume` takes them.
    """
    read = _ccvt.read_volume(_existing(path))
    shape = read["shape"]
    axes = read["axes"].T
    data = read["values"].reshape(shape, order="F")
    if os.fsencode(path).lower().endswith(b".npy") and axes[0, 0] == 0:
        # In C order, whose first axis in memory is the last of the array.
        data = data.T
        axes = axes[:, ::-1]
    if read["slope"] != 1 or read["intercept"] != 0:
        data = read["slope"] * data.astype(np.float64) + read["intercept"]
    affine = np.eye(len(shape) + 1)
    affine[:-1, :-1] = axes
    affine[:-1, -1] = read["origin"]
    return VolumeFile(data, affine)


class Mesh(NamedTuple):
    """What :func:`read_mesh` returns: arguments of :func:`sample_surface`."""

    vertices: Array
    triangles: Array
    density: Optional[Array]


def read_mesh(path: Path, density: str = "") -> Mesh:
    """Reads a triangle mesh: .ply and .obj. Polygons become triangles.

    Parameters
    ----------
    path : path
    density : str, optional
        The vertex property that is the density of samples.

    Returns
    -------
    Mesh
        ``vertices`` of float64, shape (V, 3), ``triangles`` of int32, shape (F, 3), and ``density``,
        None or float64 of shape (V,).
    """
    return Mesh._make(_ccvt.read_mesh(_existing(path), str(density)))


def write_samples(path: Path, samples: Union[VolumeSamples, SurfaceSamples]) -> None:
    """Writes samples of a volume or a surface with all that they carry: .ply, .vtp, .vtk, .csv, .npy.

    Parameters
    ----------
    path : path
    samples : VolumeSamples or SurfaceSamples
    """
    sites = _checks.table("sites", samples.sites, np.float64)

    def one_each(name: str, value: Array) -> Array:
        if len(value) != len(sites):
            raise ValueError(f"{name}: there are {len(value)} for {len(sites)} sites: one each is needed")
        return value

    given = {
        "sites": sites,
        "capacities": one_each("capacities", _checks.indices("capacities", samples.capacities)),
        "weights": one_each("weights", _checks.vector("weights", samples.weights)),
        "radii": one_each("radii", _checks.vector("radii", samples.radii)),
        "doubles": samples.dtype == np.float64,
    }
    if isinstance(samples, SurfaceSamples):
        given.update(triangles=one_each("triangles", _checks.indices("triangles", samples.triangles)))
        for name in ("barycentric", "normals"):
            rows = _checks.table(name, getattr(samples, name), np.float64)
            if rows.shape[1] != 3:
                raise ValueError(f"{name}: has the shape {rows.shape}, but must be (N, 3)")
            given[name] = one_each(name, rows)
    _ccvt.write_samples(_named(path), given)


def write_svg(path: Path, stippling: Stippling) -> None:
    """Writes the dots of a stippling as circles of an SVG document.

    Parameters
    ----------
    path : path
    stippling : Stippling
    """
    _ccvt.write_svg(
        _named(path),
        _checks.table("sites", stippling.sites),
        stippling.width,
        stippling.height,
        stippling.dot_radius,
    )


def write_particles(
    path: Path,
    sites: ArrayLike,
    *,
    box_size: float = 1.0,
    repeat: SupportsIndex = 1,
    density: float = 1.0,
    redshift: float = 0.0,
    gas: bool = False,
    gadget_format: SupportsIndex = 1,
) -> None:
    """Writes sites in the periodic unit cube as particles of a simulation: .gadget and .hdf5.

    Parameters
    ----------
    path : path
    sites : array_like of shape (N, 3)
    box_size : float, default 1
        Side of the periodic cube that is written.
    repeat : int, default 1
        The sites are laid so many times along each axis.
    density : float, default 1
        Mean mass in a unit of volume.
    redshift : float, default 0
    gas : bool, default False
        Gas instead of dark matter.
    gadget_format : {1, 2}
    """
    given: Dict[str, Any] = {
        "box_size": _checks.real("box_size", box_size),
        "repeat": _checks.whole("repeat", repeat, 1),
        "density": _checks.real("density", density),
        "redshift": _checks.real("redshift", redshift),
        "gas": _checks.flag("gas", gas),
        "gadget_format": _checks.whole("gadget_format", gadget_format, 1, 2),
    }
    _ccvt.write_particles(_named(path), _checks.table("sites", sites), given)
