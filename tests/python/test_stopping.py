"""How calls end early: with the interpreter, by cancel(), by signals."""

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import ccvt
from ccvt import _ccvt

# A daemon thread, and the end of the main one while that is at work.
DAEMON = """
import threading, time
import numpy as np, ccvt
points = np.random.default_rng(1).random(({count}, 3), np.float32)
begun = threading.Event()
def work():
    begun.set()
    {call}
threading.Thread(target=work, daemon=True).start()
begun.wait()
time.sleep({delay})
"""


@pytest.mark.parametrize("delay", [0.05, 0.3])
@pytest.mark.parametrize("count, call", [
    (1_000_000, "ccvt.tessellate(points, 4000, threads=1)"),
    (50_000, "ccvt.tessellate(points, 500, progress=lambda record: sum(range(1000000)) >= 0)"),
    (400_000, "ccvt.analyze(points, threads=1)"),
    (100_000, "while True: ccvt.energy(points, points[:1], np.zeros(len(points), np.int32))"),
])  # fmt: skip
def test_interpreter_ends_while_a_daemon_thread_is_in_a_call(count, call, delay):
    script = DAEMON.format(count=count, call=call, delay=delay)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.fixture
def long_run():
    return ccvt.Solver(np.random.default_rng(1).random((2_000_000, 3), np.float32), 20_000, threads=1)


@pytest.mark.parametrize("work", [ccvt.Solver.run, list])
def test_cancel_from_another_thread(long_run, work):
    timer = threading.Timer(0.1, long_run.cancel)
    timer.start()
    begin = time.monotonic()
    work(long_run)
    assert time.monotonic() - begin < 3
    assert long_run.summary.termination == "cancelled"
    timer.join()


def test_cancel_between_two_steps_of_another_thread(long_run):
    cancelled = threading.Event()

    def cancel():
        long_run.cancel()
        cancelled.set()

    threading.Timer(0.1, cancel).start()
    for _ in long_run:
        cancelled.wait(0.3)  # where the solver is at rest nearly always
    assert cancelled.wait(10)
    assert long_run.summary.termination == "cancelled"


def test_cancel_from_a_signal_handler(long_run):
    before = signal.signal(signal.SIGALRM, lambda *_: long_run.cancel())
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        long_run.run()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert long_run.summary.termination == "cancelled"
    assert next(long_run, None) is None


def test_cancel_after_the_end_changes_nothing(points):
    solver = ccvt.Solver(points, 64).run()
    solver.cancel()
    assert solver.summary.termination == "stable"


def test_signals_are_heard_while_points_are_drawn():
    def draw():
        begin = time.monotonic()
        try:
            _ccvt.sample_uniform(np.array([[0.0, 0.0], [1.0, 1.0]]), 20_000_000, 1, "jittered", 1, False)
        except KeyboardInterrupt:
            return "interrupted", time.monotonic() - begin
        return "drawn", time.monotonic() - begin

    _, whole = draw()
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, whole / 10)
        end, seconds = draw()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert end == "interrupted" and seconds < whole / 2


def test_time_to_draw_counts(monkeypatch):
    drawn = _ccvt.sample_uniform

    def slow(*arguments):
        time.sleep(0.2)
        return drawn(*arguments)

    assert ccvt.sample(16, time_limit=100).summary.termination != "time_limit"
    monkeypatch.setattr(_ccvt, "sample_uniform", slow)
    assert ccvt.sample(16, time_limit=0.2).summary.termination == "time_limit"
