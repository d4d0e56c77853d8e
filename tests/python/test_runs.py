"""Runs as they go: iterating, hearing of progress, stopping, threads of Python, pickling."""

import copy
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import ccvt


def test_solver_is_tessellate_step_by_step(points):
    whole = ccvt.tessellate(points, 64, seed=2)
    solver = ccvt.Solver(points, 64, seed=2)
    assert solver.summary.termination == "running"
    records = list(solver)
    assert next(solver, None) is None
    assert [record.iteration for record in records] == list(range(1, len(records) + 1))
    assert records[-1].progress == 1
    assert len(records) == whole.summary.iterations
    assert [r[:-2] for r in records] == [r[:-2] for r in whole.summary.log]
    assert np.array_equal(solver.sites, whole.sites)
    assert np.array_equal(solver.owners, whole.owners)


def test_solver_between_steps(points):
    solver = ccvt.Solver(points, 64)
    record = next(solver)
    owners = solver.owners
    assert np.count_nonzero(owners >= 0) == record.points < len(points)
    assert solver.sites.shape == (64, 2)
    solver.cancel()
    assert next(solver, None) is None
    assert solver.summary.termination == "cancelled"


def test_solver_keeps_the_points():
    solver = ccvt.Solver(np.random.default_rng(1).random((6400, 2)), 64)
    filling = [np.random.default_rng(k).random((6400, 2)) for k in range(8)]
    solver.run()
    expected = ccvt.tessellate(np.random.default_rng(1).random((6400, 2)), 64)
    assert np.array_equal(solver.sites, expected.sites) and len(filling) == 8


def test_progress_hears_all_and_changes_nothing(points):
    records = []
    result = ccvt.tessellate(points, 64, progress=records.append)
    assert [r.energy for r in records] == [r.energy for r in result.summary.log]
    assert isinstance(records[0], ccvt.Iteration)
    assert np.array_equal(result.sites, ccvt.tessellate(points, 64).sites)


def test_progress_false_stops(points):
    result = ccvt.tessellate(points, 64, progress=lambda record: record.iteration < 3)
    assert result.summary.termination == "cancelled"
    assert result.summary.iterations == 3
    assert set(np.bincount(result.owners)) == {100}


def test_numpys_false_stops_too(points):
    result = ccvt.tessellate(points, 64, progress=lambda record: np.bool_(record.iteration < 3))
    assert result.summary.termination == "cancelled"
    assert result.summary.iterations == 3
    for goes_on in [None, True, np.bool_(True), 0, "", []]:
        assert ccvt.tessellate(points, 64, progress=lambda _: goes_on).summary.termination == "stable"


def test_progress_never_falls(points):
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    for call in [lambda hear: ccvt.lloyd(points, 20, progress=hear),
                 lambda hear: ccvt.sample_surface(corners, faces, 40, progress=hear)]:  # fmt: skip
        heard = []
        call(lambda record: heard.append((record.progress, record.seconds)))
        for figures in zip(*heard):
            assert all(a <= b for a, b in zip(figures, figures[1:]))
        assert 0 <= heard[0][0] < heard[-1][0] == 1


def test_progress_that_raises(points):
    def raising(record):
        raise LookupError("from progress")

    with pytest.raises(LookupError, match="from progress"):
        ccvt.tessellate(points, 64, progress=raising)
    with pytest.raises(LookupError, match="from progress"):
        ccvt.BalancedKMeans(4, progress=raising).fit(points)


def test_progress_bar(points, capsys):
    ccvt.tessellate(points, 64, progress=True)
    assert "100%" in capsys.readouterr().err


def test_progress_bar_without_tqdm(points, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="progress: True draws a bar with tqdm"):
        ccvt.tessellate(points, 64, progress=True)


LONG = """
import signal, sys
import numpy as np, ccvt
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
points = np.random.default_rng(1).random(({count}, {dimension}))
print("ready", flush=True)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted")
    sys.exit(7)
print("done")
"""


@pytest.mark.parametrize("count, dimension, call", [
    (4_000_000, 3, "ccvt.tessellate(points, 40000)"),
    (4_000_000, 3, "[record for record in ccvt.Solver(points, 40000)]"),
    (400_000, 16, "ccvt.BalancedKMeans(256, random_state=1).fit(points)"),
    (400_000, 2, "ccvt.analyze(points)"),
])  # fmt: skip
def test_interrupt(count, dimension, call):
    script = LONG.format(count=count, dimension=dimension, call=call)
    # Into the call, which takes seconds; sooner where the machine is too fast for that.
    for delay in (0.4, 0.2, 0.1, 0.05, 0.02):
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE,
                              text=True) as child:  # fmt: skip
            assert child.stdout.readline() == "ready\n"
            time.sleep(delay)
            child.send_signal(signal.SIGINT)
            sent = time.monotonic()
            output, _ = child.communicate(timeout=60)
        if output != "done\n":
            break
    assert output == "interrupted\n" and child.returncode == 7
    assert time.monotonic() - sent < 5


def test_python_runs_meanwhile():
    points = np.random.default_rng(1).random((400000, 2))
    ended = threading.Event()

    def work():
        ccvt.tessellate(points, 4000, threads=1)
        ended.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns = 0
    while not ended.wait(0.001):
        turns += 1
    thread.join()
    assert turns > 20


def test_solvers_in_threads_are_the_same(points):
    expected = ccvt.tessellate(points, 64).sites
    found = [None] * 4

    def work(k):
        found[k] = ccvt.tessellate(points, 64, threads=2).sites

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(sites, expected) for sites in found)


def test_one_solver_in_two_threads_is_refused():
    solver = ccvt.Solver(np.random.default_rng(1).random((400000, 2)), 4000, threads=1)
    thread = threading.Thread(target=solver.run)
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            solver.sites
        except RuntimeError as error:
            assert "at work in another call; until that is over, there is only cancel()" in str(error)
            refused += 1
            time.sleep(0.001)
    thread.join()
    assert refused > 0
    assert solver.summary.termination == "stable"


def test_warm_start(points):
    first = ccvt.tessellate(points, 64)
    again = ccvt.tessellate(points, 64, owners=first.owners)
    assert again.summary.exchanged == 0
    assert np.array_equal(again.owners, first.owners)


def test_fixed_sites(points):
    stay = np.array([[0.25, 0.25], [0.75, 0.5]])
    result = ccvt.tessellate(points, 64, fixed_sites=stay)
    assert np.array_equal(result.sites[:2], stay)
    assert set(np.bincount(result.owners)) == {100}


def test_limits(points):
    assert ccvt.tessellate(points, 64, max_iterations=2).summary.termination == "iteration_limit"
    assert ccvt.tessellate(points, 64, time_limit=1e-9).summary.termination == "time_limit"
    loose = ccvt.tessellate(points, 64, energy_tolerance=0.5).summary
    assert loose.termination == "energy_tolerance"


def test_energy_agrees(points):
    result = ccvt.tessellate(points, 64)
    assert np.isclose(ccvt.energy(points, result.sites, result.owners), result.summary.energy)
    direct = ((points - result.sites[result.owners]) ** 2).sum()
    assert np.isclose(direct, result.summary.energy)


def test_lloyd(points):
    result = ccvt.lloyd(points, 20)
    squares = ((points[:, None] - result.sites) ** 2).sum(axis=2)
    own = squares[np.arange(len(points)), result.owners]
    assert np.allclose(own, squares.min(axis=1), rtol=1e-12)


def test_results_can_be_pickled(points):
    for made in [ccvt.tessellate(points, 10), ccvt.sample(10), ccvt.thin(points, 10),
                 ccvt.sample_volume(np.ones((4, 4, 4)), 5), ccvt.stipple(np.eye(8), 5),
                 ccvt.analyze(points)]:  # fmt: skip
        copy = pickle.loads(pickle.dumps(made))
        assert repr(copy) == repr(made)
        if hasattr(made, "summary"):
            assert copy.summary == made.summary
    assert "stable" in str(ccvt.tessellate(points, 10).summary)


def test_time_per_call_is_small():
    points = np.random.default_rng(1).random((20, 2))
    ccvt.tessellate(points, 2, threads=1)
    begin = time.perf_counter()
    for _ in range(100):
        ccvt.tessellate(points, 2, threads=1)
    assert (time.perf_counter() - begin) / 100 < 0.02


def test_a_solver_is_not_copied(points):
    solver = ccvt.Solver(points, 64)
    inner = solver._solver
    for call in [lambda: type(inner)(), lambda: type(inner).__new__(type(inner)),
                 lambda: copy.copy(inner), lambda: copy.deepcopy(solver), lambda: pickle.dumps(solver)]:  # fmt: skip
        with pytest.raises(TypeError):
            call().sites()
    assert solver.run().summary.termination == "stable"
