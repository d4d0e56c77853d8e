"""How calls end early: with the interpreter, by cancel(), by signals."""

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import ccvt

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
