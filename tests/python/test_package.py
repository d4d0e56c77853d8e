"""How the package is built, and how many processors it takes."""

import importlib.util
import os
import pathlib

import pytest

from ccvt import BalancedKMeans

BUILD = pathlib.Path(__file__).resolve().parents[2] / "src" / "python" / "build_with_cmake.py"


@pytest.fixture
def three_processors(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 2, 5}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)


@pytest.mark.parametrize("level, words", [(None, ["--parallel", "3"]), ("", ["--parallel", "3"]), ("2", [])])
def test_compilers_at_once(level, words, monkeypatch, three_processors):
    specification = importlib.util.spec_from_file_location("build_with_cmake", BUILD)
    build = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(build)
    monkeypatch.delenv("CMAKE_BUILD_PARALLEL_LEVEL", raising=False)
    if level is not None:
        monkeypatch.setenv("CMAKE_BUILD_PARALLEL_LEVEL", level)
    assert build.parallel() == words


@pytest.mark.parametrize("jobs, threads", [(None, 0), (5, 5), (-1, 3), (-2, 2), (-9, 1)])
def test_jobs_are_of_the_processors_there_are(jobs, threads, three_processors):
    assert BalancedKMeans(n_jobs=jobs)._threads() == threads
