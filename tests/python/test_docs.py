"""What the documentation shows and says is so."""

import dataclasses
import doctest
import importlib
import inspect
import pathlib
import pkgutil
import subprocess
import sys

import pytest

import ccvt

MODULES = ["ccvt"] + [f"ccvt.{module.name}" for module in pkgutil.iter_modules(ccvt.__path__)
                      if module.name != "_ccvt"]  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_doctests(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_doctests():
    found = doctest.DocTestFinder().find
    assert sum(len(test.examples) for name in MODULES for test in found(importlib.import_module(name))) > 30


@pytest.mark.parametrize("name", [name for name in ccvt.__all__ if callable(getattr(ccvt, name))])
def test_every_parameter_is_documented(name):
    """In numpydoc's sections: each parameter of each public function and class."""
    thing = getattr(ccvt, name)
    text = inspect.getdoc(thing)
    assert text and not text.startswith(f"{name}(")
    if dataclasses.is_dataclass(thing) or hasattr(thing, "_fields"):
        return  # a record: users do not call it
    parameters = [p for p in inspect.signature(thing).parameters if p not in ("self", "args", "kwargs")]
    sections = text.split("Parameters\n----------\n")
    assert len(sections) == 2 or not parameters
    listed = sections[-1].split("\n\n")[0]
    heads = [line.split(":")[0] for line in listed.splitlines() if line[:1].strip()]
    documented = [word.strip() for head in heads for word in head.replace("\\", "").split(",")]
    assert [p for p in parameters if p not in documented] == []


def test_types(tmp_path):
    """mypy on the package as it is installed, and on code that uses it."""
    user = tmp_path / "user.py"
    user.write_text(
        "from typing import Sequence, Tuple\nimport numpy as np\nimport ccvt\n"
        "result: ccvt.Result = ccvt.tessellate(np.zeros((3, 2)), 2, seed=1)\n"
        "energy: float = result.summary.energy\n"
        "model: ccvt.BalancedKMeans = ccvt.BalancedKMeans(3).fit([[1.0, 2.0]])\n"
        "count = np.int64(2)\n"
        "heavy: ccvt.MassResult = ccvt.tessellate(np.zeros((3, 2)), count, masses=[1, 1, 1], seed=count)\n"
        "def periodic(along: Sequence[bool]) -> ccvt.PointSample:\n"
        "    return ccvt.sample(count, count, periodic=along, seed=count, max_iterations=count)\n"
        "figures: Tuple[float, int, float, str] = (\n"
        "    model.inertia_, model.n_iter_, model.gap_, model.termination_)\n"
        "words: str = model.gap_  # type: ignore[assignment]\n"
        "for record in ccvt.Solver([[0.0]], 1):\n    level: int = record.level\n"
        'ccvt.tessellate([[0.0]], 1, seed="x")  # type: ignore[call-overload]\n'
        'ccvt.lloyd([[0.0]], 1, seed="x")  # type: ignore[arg-type]\n'
        "ccvt.tessellate([[0.0]], 1, sead=1)  # type: ignore[call-overload]\n"
    )
    command = ["/usr/bin/mypy", "--strict", "--warn-unused-ignores", "--implicit-reexport",
               "--cache-dir", str(tmp_path / "cache"), "--python-executable", sys.executable]  # fmt: skip
    package = importlib.import_module("ccvt").__path__[0]
    for target in [str(user), package]:
        done = subprocess.run([*command, target], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr


def test_session(tmp_path):
    """The session of src/python/README.md runs, on pictures made up, and leaves its own."""
    session = pathlib.Path(__file__).with_name("session.py")
    done = subprocess.run([sys.executable, session, "-", tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "clusters of [15 16] pictures" in done.stdout
    made = {path.name for path in tmp_path.iterdir()}
    assert made == {"mosaic.png", "brain.ply", "slab.png", "dots.png", "dots.svg"}


@pytest.mark.parametrize("call", [
    ccvt.tessellate, ccvt.Solver, ccvt.lloyd, ccvt.thin, ccvt.sample_volume, ccvt.BalancedKMeans.fit
])  # fmt: skip
def test_arrays_that_are_used_where_they_are(call):
    words = " ".join(call.__doc__.split())
    assert "not be changed while" in words or "be changed meanwhile" in words
