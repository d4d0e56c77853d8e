"""The same bits as those of the program, whatever the number of threads."""

import numpy as np
import pytest

import ccvt


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("dimension", [2, 3, 10])
def test_tessellate(run, tmp_path, dimension, dtype, threads):
    points = np.random.default_rng(dimension).random((20000, dimension)).astype(dtype)
    np.save(tmp_path / "points.npy", points)
    summary = run("tessellate", "points.npy", "--sites", 200, "--seed", 3, "-o", "sites.npy",
                  "--owners-out", "owners.npy")  # fmt: skip
    result = ccvt.tessellate(points, 200, seed=3, threads=threads)
    assert result.sites.dtype == dtype
    assert np.array_equal(result.sites, np.load(tmp_path / "sites.npy"))
    assert np.array_equal(result.owners, np.load(tmp_path / "owners.npy"))
    assert result.summary.energy == summary["energy"]
    assert result.summary.iterations == summary["iterations"]


@pytest.mark.parametrize("threads", [1, 2])
def test_box_capacities_and_initial_sites(run, tmp_path, points, threads):
    start = points[:64]
    capacities = np.full(64, 100)
    capacities[:32] += 50
    capacities[32:] -= 50
    np.save(tmp_path / "points.npy", points)
    np.save(tmp_path / "start.npy", start)
    np.save(tmp_path / "capacities.npy", capacities)
    run("tessellate", "points.npy", "--initial-sites", "start.npy", "--capacities", "capacities.npy",
        "--box", 0, 0, 1, 1, "--periodic-along", 2, "-o", "sites.npy")  # fmt: skip
    result = ccvt.tessellate(
        points, start, capacities=capacities, box=[[0, 0], [1, 1]], periodic=[False, True],
        threads=threads,
    )  # fmt: skip
    assert np.array_equal(result.sites, np.load(tmp_path / "sites.npy"))
    assert np.array_equal(np.bincount(result.owners), capacities)


@pytest.mark.parametrize("method", ["whole", "resampled"])
def test_masses(run, tmp_path, points, method):
    masses = np.random.default_rng(2).random(len(points))
    np.save(tmp_path / "points.npy", points)
    np.save(tmp_path / "masses.npy", masses)
    run("tessellate", "points.npy", "--masses", "masses.npy", "--sites", 50, "--mass-method", method,
        "-o", "sites.npy", "--owners-out", "owners.npy")  # fmt: skip
    result = ccvt.tessellate(points, 50, masses=masses, method=method)
    assert np.array_equal(result.sites, np.load(tmp_path / "sites.npy"))
    assert np.array_equal(result.owners, np.load(tmp_path / "owners.npy"))
    point, site, mass = result.shares
    if method == "whole":
        assert len(mass) == 0
        assert np.allclose(np.bincount(result.owners, masses), result.masses)
        assert np.abs(result.masses - result.capacities).max() < result.mass_error_bound
    else:
        assert np.allclose(np.bincount(site, mass), result.masses)
        assert np.allclose(np.bincount(point, mass, len(points)), masses)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("dtype, name", [(np.float32, "--float"), (np.float64, "--double")])
def test_sample(run, tmp_path, dtype, name, threads):
    run("sample", "--dim", 3, "--sites", 300, "--periodic", name, "-o", "sites.npy",
        "--points-out", "points.npy", "--owners-out", "owners.npy")  # fmt: skip
    sample = ccvt.sample(300, 3, periodic=True, dtype=dtype, threads=threads)
    assert np.array_equal(sample.sites, np.load(tmp_path / "sites.npy"))
    assert np.array_equal(sample.points, np.load(tmp_path / "points.npy"))
    assert np.array_equal(sample.owners, np.load(tmp_path / "owners.npy"))


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize(
    "option, keyword",
    [([], {}), (["--map", "window:10,200"], {"window": (10, 200)}),
     (["--map", "threshold:100"], {"threshold": 100}), (["--map", "gamma:2"], {"gamma": 2}),
     (["--invert"], {"invert": True}), (["--interpolation", "constant"], {"interpolation": "constant"})],
)  # fmt: skip
def test_volume(run, tmp_path, order, option, keyword):
    values = np.random.default_rng(1).integers(0, 255, (12, 9, 7)).astype(np.uint8)
    values[:3] = 0
    np.save(tmp_path / "volume.npy", np.asarray(values, order=order))
    np.save(tmp_path / "mask.npy", np.asarray(values > 20, order=order).astype(np.uint8))
    run("volume", "volume.npy", "--sites", 100, "--mask", "mask.npy", "--spacing", "1,2,3", *option,
        "-o", "samples.csv")  # fmt: skip
    volume = np.asarray(values, order=order)
    samples = ccvt.sample_volume(volume, 100, np.diag([1, 2, 3, 1]), mask=values > 20, **keyword)
    ccvt.write_samples(tmp_path / "ours.csv", samples)
    assert (tmp_path / "ours.csv").read_text() == (tmp_path / "samples.csv").read_text()


@pytest.mark.parametrize("threads", [1, 2])
def test_stipple(run, tmp_path, camera, threads):
    run("stipple", camera, "--sites", 1000, "-o", "dots.svg")
    picture = ccvt.stipple(camera, 1000, threads=threads)
    ccvt.write_svg(tmp_path / "ours.svg", picture)
    assert (tmp_path / "ours.svg").read_text() == (tmp_path / "dots.svg").read_text()
    run("stipple", camera, "--sites", 1000, "-o", "dots.png")
    ccvt.write_png(tmp_path / "ours.png", ccvt.render(picture))
    assert (tmp_path / "ours.png").read_bytes() == (tmp_path / "dots.png").read_bytes()


def test_stipple_of_pixels(camera):
    pixels = np.round(ccvt.read_image(camera) * 255).astype(np.uint8)
    assert np.array_equal(ccvt.stipple(pixels, 100).sites, ccvt.stipple(camera, 100).sites)


def test_thin(run, tmp_path):
    points = np.random.default_rng(1).random((3000, 3))
    np.save(tmp_path / "points.npy", points)
    run("thin", "points.npy", "--sites", 300, "-o", "few.npy", "--indices-out", "chosen.npy")
    few = ccvt.thin(points, 300)
    assert np.array_equal(few.chosen, np.load(tmp_path / "chosen.npy"))
    assert np.array_equal(points[few.chosen], np.load(tmp_path / "few.npy"))


def test_surface(run, tmp_path):
    (tmp_path / "mesh.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\n"
        "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n"
    )
    run("surface", "mesh.obj", "--sites", 150, "-o", "samples.csv")
    vertices, triangles, density = ccvt.read_mesh(tmp_path / "mesh.obj")
    assert density is None and triangles.shape == (6, 3)
    ccvt.write_samples(tmp_path / "ours.csv", ccvt.sample_surface(vertices, triangles, 150))
    assert (tmp_path / "ours.csv").read_text() == (tmp_path / "samples.csv").read_text()


@pytest.mark.parametrize("threads, train_sample", [(1, None), (2, None), (2, 1000)])
def test_codebook(run, tmp_path, threads, train_sample):
    vectors = np.random.default_rng(1).normal(size=(3000, 8)).astype(np.float32)
    np.save(tmp_path / "vectors.npy", vectors)
    summary = run("quantize", "vectors.npy", "--codewords", 32, "--seed", 4, "-o", "words.npy",
                  "--codes-out", "codes.npy", "--weights-out", "weights.npy",
                  "--train-sample", train_sample or len(vectors))  # fmt: skip
    model = ccvt.BalancedKMeans(
        32, random_state=4, n_jobs=threads, train_sample=train_sample
    ).fit(vectors)
    assert np.array_equal(model.cluster_centers_, np.load(tmp_path / "words.npy"))
    assert np.array_equal(model.weights_, np.load(tmp_path / "weights.npy").ravel())
    assert np.array_equal(model.labels_, np.load(tmp_path / "codes.npy"))
    assert model.inertia_ == summary["energy"] and model.gap_ == summary["gap"]


def test_analysis(program, tmp_path):
    import json
    import subprocess

    sites = ccvt.sample(256, periodic=True).sites
    np.save(tmp_path / "sites.npy", sites)
    subprocess.run([program, "analyze", "sites.npy", "--periodic", "--quiet", "-o", "report"],
                   check=True, cwd=tmp_path)  # fmt: skip
    text = (tmp_path / "report" / "metrics.json").read_text()
    found = ccvt.analyze(sites, periodic=True)
    numbers = _numbers(json.loads(text))
    for figure in [found.smallest_distance, found.mean_distance, found.psi6_local,
                   found.star_discrepancy, found.spectrum.peak, found.integration_disk,
                   found.spectrum.low_frequency_power]:  # fmt: skip
        assert figure in numbers


def _numbers(tree):
    if isinstance(tree, dict):
        return {number for value in tree.values() for number in _numbers(value)}
    if isinstance(tree, list):
        return {number for value in tree for number in _numbers(value)}
    return {tree} if isinstance(tree, float) else set()
