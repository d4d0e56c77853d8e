"""Common to all tests of the Python module, which must be importable: installed, or by PYTHONPATH.

CCVT_PROGRAM names the program `ccvt`, whose results are to be the same bits.
"""

import json
import os
import pathlib
import subprocess

import numpy as np
import pytest

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"


@pytest.fixture(scope="session")
def program():
    name = os.environ.get("CCVT_PROGRAM")
    assert name, "CCVT_PROGRAM must name the program ccvt"
    return pathlib.Path(name).resolve()


@pytest.fixture
def run(program, tmp_path):
    """Runs the program in a folder of its own; returns the summary that it writes."""

    def call(*arguments):
        summary = tmp_path / "summary.json"
        command = [program, *arguments, "--quiet", "--summary", summary]
        subprocess.run([str(word) for word in command], check=True, cwd=tmp_path)
        return json.loads(summary.read_text())

    return call


@pytest.fixture
def points():
    return np.random.default_rng(5).random((6400, 2))


@pytest.fixture
def camera():
    return DATA / "camera.png"
