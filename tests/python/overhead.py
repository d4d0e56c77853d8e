#!/usr/bin/python3
"""How much longer ccvt.tessellate() takes in Python than in C++, at 4096 sites of 256 points.

    overhead.py PROGRAM [RUNS]

Both tessellate the same points, turn by turn, with one thread; the fastest run of each counts. Of the
program it is what its summary says of the tessellation alone; of Python all of the call.
"""

import json
import pathlib
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
    cpp, python = [], []
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/points.npy", points)
        for _ in range(runs):
            subprocess.run([program, "tessellate", "points.npy", "--sites", str(SITES), "--threads", "1",
                            "--quiet", "--summary", "summary.json", "-o", "sites.npy"],
                           check=True, cwd=folder)  # fmt: skip
            cpp.append(json.loads(pathlib.Path(folder, "summary.json").read_text())["seconds"]["total"])
            begin = time.perf_counter()
            sites = ccvt.tessellate(points, SITES, threads=1).sites
            python.append(time.perf_counter() - begin)
        assert np.array_equal(sites, np.load(f"{folder}/sites.npy"))
    ratio = min(python) / min(cpp)
    print(f"C++ {min(cpp):.4f} s, Python {min(python):.4f} s, ratio {ratio:.3f}, of {runs} runs each")
    return ratio


if __name__ == "__main__":
    main()
