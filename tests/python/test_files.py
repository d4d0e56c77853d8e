"""Readers and writers."""

import dataclasses
import os

import numpy as np
import pytest

import ccvt


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("name", ["points.npy", "points.csv", "points.txt"])
def test_points(tmp_path, name, dtype):
    points = np.random.default_rng(1).random((50, 3)).astype(dtype)
    ccvt.write_points(tmp_path / name, points)
    assert np.array_equal(ccvt.read_points(tmp_path / name, dtype=dtype), points)
    read = ccvt.read_points(str(tmp_path / name))
    assert read.dtype == (dtype if name.endswith("npy") else np.float64)
    assert read.flags.owndata


def test_points_of_others(tmp_path):
    points = np.random.default_rng(1).random((50, 3))
    np.save(tmp_path / "points.npy", np.asfortranarray(points))
    assert np.array_equal(ccvt.read_points(tmp_path / "points.npy"), points)
    ccvt.write_points(tmp_path / "ours.npy", points)
    assert np.array_equal(np.load(tmp_path / "ours.npy"), points)


def test_columns(tmp_path):
    (tmp_path / "table.csv").write_text("id,x,y\n7,0.5,1\n8,2,3\n")
    assert ccvt.read_points(tmp_path / "table.csv").tolist() == [[0.5, 1], [2, 3]]
    assert ccvt.read_points(tmp_path / "table.csv", columns=["id"]).tolist() == [[7], [8]]
    assert ccvt.read_points(tmp_path / "table.csv", columns=[3, 1]).tolist() == [[1, 7], [3, 8]]


@pytest.mark.parametrize("name", ["owners.npy", "owners.csv"])
def test_owners(tmp_path, name):
    ccvt.write_owners(tmp_path / name, np.array([3, 1, 2]))
    assert ccvt.read_owners(tmp_path / name).tolist() == [3, 1, 2]
    assert ccvt.read_numbers(tmp_path / name).dtype == np.float64


def test_pictures(tmp_path, camera):
    image = ccvt.read_image(camera)
    assert image.dtype == np.float32 and image.ndim == 2 and image.max() <= 1
    for pixels in [image, np.round(image * 255).astype(np.uint8)]:
        ccvt.write_png(tmp_path / "copy.png", pixels)
        assert np.array_equal(ccvt.read_image(tmp_path / "copy.png"), image)
    colours = np.zeros((4, 6, 3), np.uint8)
    colours[..., 1] = 255
    ccvt.write_png(tmp_path / "green.png", colours)
    assert np.allclose(ccvt.read_image(tmp_path / "green.png"), 0.7152, atol=1e-6)


@pytest.mark.parametrize("order", ["C", "F"])
def test_volume(tmp_path, order):
    values = np.asarray(np.random.default_rng(1).integers(0, 99, (3, 4, 5)).astype(np.int16), order=order)
    np.save(tmp_path / "volume.npy", values)
    data, affine = ccvt.read_volume(tmp_path / "volume.npy")
    assert np.array_equal(data, values) and data.dtype == values.dtype
    assert np.array_equal(affine, np.eye(4))
    from_file = ccvt.sample_volume(data, 20, affine)
    assert np.array_equal(from_file.sites, ccvt.sample_volume(values, 20).sites)


def test_samples_of_any_layout(tmp_path):
    made = ccvt.sample_volume(np.ones((4, 4, 4)), 9)
    surface = ccvt.sample_surface(np.eye(3), [[0, 1, 2]], 9)

    def spread(array):
        return np.repeat(array, 2, axis=0)[::2].astype(array.dtype.newbyteorder())

    for samples in [made, surface]:
        fields = {name: getattr(samples, name) for name in ("sites", "capacities", "weights", "radii")}
        if samples is surface:
            fields |= {name: getattr(samples, name) for name in ("triangles", "barycentric", "normals")}
        ccvt.write_samples(tmp_path / "one.csv", samples)
        other = dataclasses.replace(samples, **{name: spread(one) for name, one in fields.items()})
        ccvt.write_samples(tmp_path / "other.csv", other)
        assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
        for name, one in fields.items():
            with pytest.raises(ValueError, match="one each is needed"):
                ccvt.write_samples(
                    tmp_path / "short.csv", dataclasses.replace(samples, **{name: one[:-1]})
                )
    assert not (tmp_path / "short.csv").exists()


def test_particles(tmp_path):
    sites = ccvt.sample(64, 3, periodic=True).sites
    ccvt.write_particles(tmp_path / "load.gadget", sites, box_size=10, repeat=2)
    assert ccvt.read_points(tmp_path / "load.gadget").shape == (512, 3)


@pytest.mark.parametrize("call", [
    lambda folder: ccvt.read_points(folder / "none.npy"),
    lambda folder: ccvt.read_image(folder / "none.png"),
    lambda folder: ccvt.write_points(folder / "none" / "points.npy", [[1.0]]),
    lambda folder: ccvt.read_volume(folder / "none.nii"),
])  # fmt: skip
def test_errors_of_the_system(tmp_path, call):
    with pytest.raises(OSError, match="none"):
        call(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_names_of_any_bytes(tmp_path):
    name = os.fsencode(tmp_path) + b"/\xff.npy"
    ccvt.write_points(os.fsdecode(name), [[1.0, 2.0]])
    assert ccvt.read_points(name).tolist() == [[1.0, 2.0]]
    with open(name, "wb") as file:
        file.write(b"no array")
    with pytest.raises(ValueError, match="\udcff.npy: "):
        ccvt.read_points(name)
    with pytest.raises(OSError, match="\udcff/x.npy: "):
        ccvt.write_points(os.fsencode(tmp_path) + b"/\xff/x.npy", [[1.0, 2.0]])


@pytest.mark.parametrize("call, text", [
    (lambda folder: ccvt.write_points(folder / "a\0.csv", [[1.0]]), "null"),
    (lambda folder: ccvt.write_owners(folder / "x.npy", []), "owners: there are none"),
    (lambda folder: ccvt.write_points(folder / "points.jpg", [[1.0]]), "points.jpg"),
    (lambda folder: ccvt.write_png(folder / "x.png", np.zeros((2, 2, 2))), "image: is an array"),
    (lambda folder: ccvt.write_png(folder / "x.png", [[0, np.nan]]),
     r"image: entry \(0, 1\) is nan, but floats must be from 0 .black. to 1 .white."),
    (lambda folder: ccvt.write_png(folder / "x.png", [[0.5], [1.5]]), r"image: entry \(1, 0\) is 1.5"),
    (lambda folder: ccvt.write_png(folder / "x.png", [[-0.5]]), r"image: entry \(0, 0\) is -0.5"),
    (lambda folder: ccvt.write_particles(folder / "x.gadget", [[2.0, 0, 0]]), "2"),
    (lambda folder: ccvt.read_points(folder, columns=["x"]), "."),
    (lambda folder: ccvt.write_owners(folder / "x.npy", [1.5]), "owners: entry 0 is 1.5"),
])  # fmt: skip
def test_refused(tmp_path, call, text):
    with pytest.raises(ValueError, match=text):
        call(tmp_path)
    assert list(tmp_path.iterdir()) == []
