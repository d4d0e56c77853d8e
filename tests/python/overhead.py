#!/usr/bin/python3
"""How much longer ccvt.tessellate() takes in Python than in C++, at 4096 sites of 256 points.

    overhead.py PROGRAM [RUNS]

Both tessellate the same points, turn by turn, with one thread. Two ratios: the fastest call from Python
over the fastest tessellation in the program, which a machine with other work shakes; and the median of
each call over what the library itself took within it, which says what Python adds.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import ccvt

SITES = 4096


def main():
    program, runs = pathlib.Path(sys.argv[1]).resolve(), int((sys.argv + ["7"])[2])
    points = np.random.default_rng(1).random((SITES * 256, 2)).astype(np.float32)
    cpp, python, added = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/points.npy", points)
        for _ in range(runs):
            subprocess.run([program, "tessellate", "points.npy", "--sites", str(SITES), "--threads", "1",
                            "--quiet", "--summary", "summary.json", "-o", "sites.npy"],
                           check=True, cwd=folder)  # fmt: skip
            cpp.append(json.loads(pathlib.Path(folder, "summary.json").read_text())["seconds"]["total"])
            begin = time.perf_counter()
            result = ccvt.tessellate(points, SITES, threads=1)
            python.append(time.perf_counter() - begin)
            added.append(python[-1] / result.summary.seconds_total)
            assert np.array_equal(result.sites, np.load(f"{folder}/sites.npy"))
    print(f"C++ {min(cpp):.4f} s, Python {min(python):.4f} s, ratio {min(python) / min(cpp):.3f}, fastest "
          f"of {runs} runs each")  # fmt: skip
    print(f"a call over what the library takes in it: {statistics.median(added):.4f}")


if __name__ == "__main__":
    main()
