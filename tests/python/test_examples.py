"""The notebooks in tests/examples, run as scripts, and what they print and write."""

import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import ccvt

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture
def printed(tmp_path):
    """What an example prints; it writes to `tmp_path`, where nobody has made the folder yet."""

    def call(name):
        command = [sys.executable, EXAMPLES / f"{name}.py", tmp_path / "made"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return call


def numbers(pattern, text):
    """All numbers in the part of the text that the pattern has in brackets."""
    return [float(word) for word in re.findall(r"-?[\d.]+(?:e[+-]\d+)?", re.search(pattern, text, re.DOTALL)[1])]


def test_start(printed, tmp_path):
    text = printed("python_start")
    assert text.startswith("stable after")
    assert numbers(r"points a site: \[(.*?)\]", text) == [256]
    owners = ccvt.read_owners(tmp_path / "made" / "owners.npy")
    sites = ccvt.read_points(tmp_path / "made" / "sites.npy")
    points = np.random.default_rng(1).random((25_600, 2))
    means = np.stack([points[owners == site].mean(axis=0) for site in range(100)])
    np.testing.assert_allclose(sites, means, rtol=1e-12)


def test_clusters(printed, tmp_path):
    text = printed("python_clusters")
    assert numbers(r"addresses a district: \[(.*?)\]", text) == [250]
    assert numbers(r"gap (\S+)", text)[0] < 1e-9
    fewest, most = numbers(r"plain k-means: (\d+ to \d+)", text)
    assert fewest < 200 and most > 300
    assert numbers(r"inertia (\S+) of it", text)[0] < 1
    new = numbers(r"new ones a district: \[(.*?)\]", text)
    assert sum(new) == 3000 and most - fewest > new[-1] - new[0]
    assert numbers(r"short shifts: \[(.*?)\]", text) == [270] * 10 + [150] * 2
    picture = ccvt.read_image(tmp_path / "made" / "districts.png")
    assert picture.shape == (500, 500) and len(np.unique(picture)) == 13


def test_stipple(printed, tmp_path):
    text = printed("python_stipple")
    assert "4000 dots" in text and "stable after" in text
    joined = [int(word) for word in re.findall(r": (\d+) points have joined", text)]
    assert joined[0] < joined[-1] == 64_000
    assert (tmp_path / "made" / "ball.svg").read_text().count("<circle ") == 4000
    for name in ["ball.png", "night.png"]:
        picture = ccvt.read_image(tmp_path / "made" / name)
        high, wide = np.array(picture.shape) // 8
        lit = picture[2 * high : 3 * high, 2 * wide : 3 * wide].mean()
        dark = picture[5 * high : 6 * high, 6 * wide : 7 * wide].mean()
        assert lit > dark + 0.4, name


def test_volume(printed, tmp_path):
    text = printed("python_volume")
    assert "3000 sites in 3D" in text
    sites = ccvt.read_points(tmp_path / "made" / "lumps.ply")
    assert sites.shape == (3000, 3)
    assert np.hypot(*sites[:, :2].T).max() < 28 + 1
    assert (np.abs(sites) <= [30, 30, 30]).all()
    by_samples, by_cells = [float(number) for number in re.findall(r"mass (\S+)", text)]
    assert by_samples == pytest.approx(by_cells, rel=1e-9)
    centre = numbers(r"centre \[(.*?)\]", text)[0]
    assert centre == pytest.approx(numbers(r"x of the centre (\S+)", text)[0], abs=0.05)
    picture = ccvt.read_image(tmp_path / "made" / "slab.png")
    assert picture.shape == (480, 480) and picture.min() == 0 and picture[0, 0] == 1


def test_all_are_tested():
    names = {path.stem.removeprefix("python_") for path in EXAMPLES.glob("*.py")}
    assert names == {name.removeprefix("test_") for name in globals() if name.startswith("test_")} - {"all_are_tested"}
