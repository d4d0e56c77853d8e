"""Capacity-constrained Voronoi tessellation in any dimension.

Given m points, n sites and a capacity for each site, every point gets an owner so that each site owns
exactly as many points as its capacity, no exchange of points between any two sites lowers the sum of
squared distances, and each site is the centroid of its points.

>>> import numpy as np
>>> import ccvt
>>> points = np.random.default_rng(1).random((10000, 2))
>>> sites = ccvt.tessellate(points, 100).sites

Points are arrays of shape (N, D), one a row. Any number of threads gives identical bits, those of the
C++ library and of the program ``ccvt``.
"""

from typing import TYPE_CHECKING, Any, List

from ._analysis import analyze, energy
from ._ccvt import __version__
from ._density import render, sample_volume, stipple
from ._files import (
    Mesh,
    VolumeFile,
    read_image,
    read_mesh,
    read_numbers,
    read_owners,
    read_points,
    read_volume,
    write_owners,
    write_particles,
    write_png,
    write_points,
    write_samples,
    write_svg,
)
from ._records import (
    Analysis,
    Iteration,
    MassResult,
    Phase,
    PointSample,
    Result,
    Spectrum,
    Stippling,
    Summary,
    SurfaceSamples,
    Thinning,
    VolumeSamples,
)
from ._sampling import sample, sample_surface, thin
from ._tessellate import Solver, lloyd, tessellate

if TYPE_CHECKING:
    from ._kmeans import BalancedKMeans

__all__ = [
    "Analysis",
    "BalancedKMeans",
    "Iteration",
    "MassResult",
    "Mesh",
    "Phase",
    "PointSample",
    "Result",
    "Solver",
    "Spectrum",
    "Stippling",
    "Summary",
    "SurfaceSamples",
    "Thinning",
    "VolumeFile",
    "VolumeSamples",
    "__version__",
    "analyze",
    "energy",
    "lloyd",
    "read_image",
    "read_mesh",
    "read_numbers",
    "read_owners",
    "read_points",
    "read_volume",
    "render",
    "sample",
    "sample_surface",
    "sample_volume",
    "stipple",
    "tessellate",
    "thin",
    "write_owners",
    "write_particles",
    "write_png",
    "write_points",
    "write_samples",
    "write_svg",
]


def __getattr__(name: str) -> Any:
    # Late, as it imports scikit-learn where that is installed, which takes a second.
    if name == "BalancedKMeans":
        from ._kmeans import BalancedKMeans

        return BalancedKMeans
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> List[str]:
    return __all__
