"""Which arrays go in, which come out, and what is said of those that may not."""

import numpy as np
import pytest

import ccvt
from ccvt import _checks, _density


def unaligned(array):
    """The same one byte further on; in the same order."""
    moved = np.frombuffer(b"." + array.tobytes("A"), np.uint8)[1:].view(array.dtype)
    return moved.reshape(array.shape, order="F" if array.flags.fnc else "C")


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_no_copy(dtype):
    wide = np.random.default_rng(1).random((100, 6)).astype(dtype)
    for array in [wide, wide[::3], wide[:, 1:3], wide[10:50, 2:]]:
        assert np.shares_memory(_checks.table("points", array), array)
        assert _checks.table("points", array) is array


@pytest.mark.parametrize("change", [
    lambda points: np.asfortranarray(points),
    lambda points: points.astype(points.dtype.newbyteorder()),
    lambda points: points[::-1][::-1].tolist(),
    lambda points: np.repeat(points, 2, axis=1)[:, ::2],
    lambda points: unaligned(points),
])  # fmt: skip
def test_any_layout_gives_the_same(points, change):
    expected = ccvt.tessellate(points, 20)
    found = ccvt.tessellate(change(points), 20)
    assert np.array_equal(found.sites, expected.sites)
    assert np.array_equal(found.owners, expected.owners)


def test_strided_rows_are_read_in_place(points):
    wide = np.hstack([points, np.full_like(points, np.nan)])
    assert np.array_equal(ccvt.tessellate(wide[:, :2], 20).sites, ccvt.tessellate(points, 20).sites)
    assert np.array_equal(
        ccvt.tessellate(wide[::2, :2], 20).sites, ccvt.tessellate(points[::2].copy(), 20).sites
    )


@pytest.mark.parametrize("dtype", [np.int16, np.uint8, np.float16, np.int64, np.longdouble, object])
def test_other_types_are_converted(dtype):
    whole = np.random.default_rng(1).integers(0, 200, (1000, 2))
    expected = ccvt.tessellate(whole.astype(np.float64), 10)
    found = ccvt.tessellate(whole.astype(dtype), 10)
    assert found.sites.dtype == np.float64
    assert np.array_equal(found.sites, expected.sites)


def test_foreign_byte_order_keeps_its_precision(points):
    swapped = points.astype(">f4")
    result = ccvt.tessellate(swapped, 20)
    assert result.sites.dtype == np.float32
    assert np.array_equal(result.sites, ccvt.tessellate(swapped.astype("=f4"), 20).sites)


def test_results_are_compared_by_identity(points):
    one, other = ccvt.tessellate(points, 5), ccvt.tessellate(points, 5)
    assert one == one and one != other and len({one, other}) == 2


def test_results_own_their_memory(points):
    given = points.copy()
    result = ccvt.tessellate(points, 20)
    assert result.sites.flags.owndata and result.owners.flags.owndata
    assert result.sites.flags.writeable and result.sites.flags.c_contiguous
    assert np.array_equal(points, given)
    assert result.owners.dtype == np.int32


@pytest.mark.parametrize("call, text", [
    (lambda p: ccvt.tessellate(p[:, 0], 3), r"points: has the shape \(6400,\), .*points\[:, None\]"),
    (lambda p: ccvt.tessellate(p[None], 3), r"points: has the shape \(1, 6400, 2\)"),
    (lambda p: ccvt.tessellate(p + 1j, 3), "points: is an array of complex128"),
    (lambda p: ccvt.tessellate([["a", "b"]], 1), "points: is an array of <U1"),
    (lambda p: ccvt.tessellate([[1, 2], [3]], 1), "points: must be an array of numbers"),
    (lambda p: ccvt.tessellate([[2**53 + 1, 1]], 1), "points: has whole numbers that float64 does"),
    (lambda p: ccvt.tessellate(np.full((1, 1), 2**64 - 1, np.uint64), 1), "points: has whole numbers"),
    (lambda p: ccvt.tessellate(p.astype("f4"), np.array([[2**24 + 1, 0]], "i4")), "has whole numbers that float32"),
    (lambda p: ccvt.tessellate([[10**400, 1]], 1), "points: must be an array of numbers"),
    (lambda p: ccvt.tessellate(np.ma.masked_less(p, .5), 3), "points: has masked entries"),
    (lambda p: ccvt.tessellate(np.zeros((0, 2)), 1), "sites|points"),
    (lambda p: ccvt.tessellate(p, np.zeros((0, 2))), "sites"),
    (lambda p: ccvt.tessellate(np.where(p > 0.999, np.nan, p), 3), "points.*nan"),
    (lambda p: ccvt.tessellate(np.zeros((0, 2**31), "f4"), 1), "points: have 2147483648 dimensions, but at most"),
    (lambda p: ccvt.tessellate(p, 0), "sites: is 0, but must be from 1 to 2147483647"),
    (lambda p: ccvt.tessellate(p, 7000), "sites.*7000"),
    (lambda p: ccvt.tessellate(p, p[:4, :1]), "sites: have 1 dimensions, the points 2"),
    (lambda p: ccvt.tessellate(p, 3, capacities=[1, 2, 3]), "capacities"),
    (lambda p: ccvt.tessellate(p, 3, capacities=[.5, 2, 3]), "capacities: entry 0 is 0.5"),
    (lambda p: ccvt.tessellate(p, 3, periodic=True), "periodic: needs a box"),
    (lambda p: ccvt.tessellate(p, 3, periodic=[True], box=[[0, 0], [1, 1]]), "periodic: is"),
    (lambda p: ccvt.tessellate(p, 3, box=[0, 1]), r"box: has the shape \(2,\)"),
    (lambda p: ccvt.tessellate(p, 3, box=[[0, 0], [.5, .5]]), "points"),
    (lambda p: ccvt.tessellate(p, 3, seed=-1), "seed: is -1"),
    (lambda p: ccvt.tessellate(p, 3, threads=5000), "threads: is 5000"),
    (lambda p: ccvt.tessellate(p, 3, until="soon"), "until: is 'soon', but must be one of stable"),
    (lambda p: ccvt.tessellate(p, 3, preset="none"), "none"),
    (lambda p: ccvt.tessellate(p, 3, energy_tolerance=2), "energy_tolerance"),
    (lambda p: ccvt.tessellate(p, 3, method="resampled"), "are for points with masses"),
    (lambda p: ccvt.tessellate(p, 3, masses=np.ones(7)), "masses"),
    (lambda p: ccvt.sample(3, 2, distribution="x"), "distribution: is 'x'"),
    (lambda p: ccvt.sample(2**30, 2), "sites . points_per_site: is 274877906944"),
    (lambda p: ccvt.sample(3, 2, dtype=int), "dtype: is int64"),
    (lambda p: ccvt.sample_volume(-np.ones((3, 3)), 2), "value|densit"),
    (lambda p: ccvt.sample_volume(np.zeros((3, 3)), 2), "zero|0"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, np.eye(4)), "affine: has the shape"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, mask=np.ones(3)), "mask: has the shape"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, mask=np.full((3, 3), "a")), "mask: is an array of <U1"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, window=(2, 1)), "low|window"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, threshold=np.nan), "threshold: is nan"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, window=(2,)), r"window: is \(2,\)"),
    (lambda p: ccvt.sample_volume(np.ones((3, 3)), 2, window=(1, 2), gamma=2), "gamma: cannot"),
    (lambda p: ccvt.sample_volume(-np.ones((3, 3)), 2, gamma=2, invert=True),
     "gamma: the greatest value is -1.0, but must be positive"),
    (lambda p: ccvt.stipple(np.ones((4, 4)), 3), "image: is white everywhere"),
    (lambda p: ccvt.stipple(np.full((4, 4), 7.), 3), "from 0 .black. to 1"),
    (lambda p: ccvt.stipple(np.zeros((4, 4), int), 3), "image: is of int64"),
    (lambda p: ccvt.thin(p, 3, normals=p[:5]), "normals"),
    (lambda p: ccvt.sample_surface(p, [[0, 1, 2]], 3), r"vertices: has the shape \(6400, 2\)"),
    (lambda p: ccvt.sample_surface([[0, 0, 0]], [[0, 0, 7]], 3), "triangle"),
    (lambda p: ccvt.sample_surface(np.eye(3), [[0, 1, 2]], 3, density=[]), "density: there are 0 for 3"),
    (lambda p: ccvt.analyze(p[:1]), "points"),
    (lambda p: ccvt.energy(p, p[:3], [0, 1]), "owners"),
    (lambda p: ccvt.read_points(__file__), "test_arrays.py"),
])  # fmt: skip
def test_refused(points, call, text):
    with pytest.raises(ValueError, match=text):
        call(points)


@pytest.mark.parametrize("call, text", [
    (lambda p: ccvt.tessellate(p, True), "sites: is True, but must be a whole number"),
    (lambda p: ccvt.tessellate(p, 2.5), "sites: is 2.5"),
    (lambda p: ccvt.tessellate(p, 2, seed="x"), "seed: is 'x'"),
    (lambda p: ccvt.tessellate(p, 2, time_limit="x"), "time_limit: is 'x'"),
    (lambda p: ccvt.tessellate(p, 2, progress=3), "progress: is 3, but must be a function"),
    (lambda p: ccvt.tessellate(np.array([[{}, 1]]), 1), "points: must be an array of numbers"),
    (lambda p: ccvt.sample(3, 2, dtype="x"), "dtype: is 'x'"),
    (lambda p: ccvt.stipple(p, 2, invert=1), "invert: is 1, but must be True or False"),
])  # fmt: skip
def test_wrong_type(points, call, text):
    with pytest.raises(TypeError, match=text):
        call(points)


def test_analyze_takes_float32_on_faces():
    """0.1f is above 0.1: as float64 such points were outside."""
    box = [[0, 0], [0.1, 0.1]]
    on_face = np.append(0.1 * np.random.default_rng(1).random((99, 2)), [[0.1, 0.05]], axis=0)
    single = on_face.astype(np.float32)
    found = ccvt.analyze(single, box=box)
    assert np.isclose(found.mean_distance, ccvt.analyze(on_face, box=box).mean_distance, rtol=1e-5)


@pytest.mark.parametrize("take", [
    lambda array: _checks.table("points", array),
    lambda array: _checks.vector("masses", array[:, 0]),
    lambda array: _checks.vector("masses", unaligned(array[:, 0].copy())),
    lambda array: _checks.indices("triangles", array, 2),
    lambda array: _checks.indices("triangles", unaligned(np.arange(6, dtype=np.int32)[:, None]), 2),
    lambda array: _checks.domain_of(array, False, 2)[0],
    lambda array: _density._values(array),
    lambda array: _density._values(unaligned(np.asfortranarray(array))),
])  # fmt: skip
def test_numbers_reach_the_library_aligned(take):
    array = unaligned(np.arange(4.0).reshape(2, 2))
    taken = take(array)
    assert not array.flags.aligned and taken.flags.aligned
    if taken.shape == array.shape:
        assert np.array_equal(taken, array)


def test_contiguous_values_keep_their_order():
    values = np.arange(6.0).reshape(2, 3)
    for array in [values, values.T, values[0]]:
        assert _density._values(array) is array
    assert _density._values(unaligned(np.asfortranarray(values))).flags.f_contiguous


@pytest.mark.parametrize("options", [{}, {"gamma": 2}, {"invert": True}, {"gamma": 2, "invert": True}])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_named(options, value):
    values = np.ones((4, 5))
    values[2, 3] = value
    with pytest.raises(ValueError, match=r"values\[13\], cell .* is (nan|inf)"):
        ccvt.sample_volume(values, 2, **options)
    with pytest.raises(ValueError, match=r"values\[0\], cell .* is (nan|inf)"):
        ccvt.sample_volume(np.full((4, 5), value), 2, **options)
