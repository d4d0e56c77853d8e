"""How calls end early: with the interpreter, by cancel(), by signals."""

import subprocess
import sys

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
