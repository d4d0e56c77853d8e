#!/usr/bin/env python3
"""What several processes cost and save: time, memory, and what they send each other.

    ranks.py BIN MPIRUN [--sites 65536] [--dims 2,3] [--ranks 1,2,4,8] [--points-per-site 256]
                        [--vectors 65536] [--repeats 3]

Each line is the fastest of the repeats, which are made in turn; memory is that of the rank with the
most, less what a program takes that only starts MPI. Bytes an iteration are what all ranks send to
others, without what all of them gather; the share is of the bytes of all cells. Then codebooks of
1024 codewords for so many vectors of 64 dimensions, in 200 clouds of unequal size and spread.
"""

import argparse
import array
import json
import os
import pathlib
import random
import subprocess
import tempfile

parser = argparse.ArgumentParser()
parser.add_argument("bin", type=pathlib.Path)
parser.add_argument("mpirun")
for name, default in (("sites", "65536"), ("dims", "2,3"), ("ranks", "1,2,4,8")):
    parser.add_argument("--" + name, default=default)
parser.add_argument("--points-per-site", type=int, default=256)
parser.add_argument("--vectors", default="65536")
parser.add_argument("--repeats", type=int, default=3)
given = parser.parse_args()
program = str(given.bin.resolve() / "ccvt-mpi")
os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
os.environ.update(OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none")


def numbers(text):
    return [int(number) for number in text.split(",")]


def program_of(ranks, *arguments):
    subprocess.run([given.mpirun, "-n", str(ranks), program, *arguments, "--threads", "1", "-o", f"{ranks}.npy",
                    "--summary", "run.json", "-q"], check=True)  # fmt: skip
    return json.loads(pathlib.Path("run.json").read_text())


def run(ranks, dimension, sites):
    return program_of(ranks, "sample", "--dim", str(dimension), "--sites", str(sites), "--points-per-site",
                      str(given.points_per_site), "--periodic")  # fmt: skip


def fastest(make):
    """Of each number of ranks, the summary of the fastest of the repeats; all have the same output."""
    best = {}
    for _ in range(given.repeats):
        for ranks in numbers(given.ranks):
            summary = make(ranks)
            if ranks not in best or summary["seconds"]["total"] < best[ranks]["seconds"]["total"]:
                best[ranks] = summary
    for ranks in best:
        assert pathlib.Path(f"{ranks}.npy").read_bytes() == pathlib.Path(f"{min(best)}.npy").read_bytes()
    return best


def write_clouds(path, count, dimension=64, clouds=200):
    draw = random.Random(1)
    middles = [[draw.gauss(0, 1) for _ in range(dimension)] for _ in range(clouds)]
    shares = [draw.expovariate(1) for _ in range(clouds)]
    spreads = [draw.uniform(0.2, 0.6) for _ in range(clouds)]
    values = array.array("f")
    for cloud in draw.choices(range(clouds), shares, k=count):
        values.extend(draw.gauss(middle, spreads[cloud]) for middle in middles[cloud])
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({count}, {dimension}), }}".ljust(117) + "\n"
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode())
        values.tofile(file)


with tempfile.TemporaryDirectory() as work:
    os.chdir(work)
    empty = run(2, 2, 1)["ranks"]["largest_peak_memory_bytes"]
    print("| dimensions | sites | ranks | seconds | times as fast | largest rank | of one | bytes an iteration"
          " | of the cells | messages |\n|---|---|---|---|---|---|---|---|---|---|")  # fmt: skip
    for dimension in numbers(given.dims):
        for sites in numbers(given.sites):
            best = fastest(lambda ranks: run(ranks, dimension, sites))
            first = best[min(best)]
            for ranks, summary in sorted(best.items()):
                figures = summary["ranks"]
                memory = figures["largest_peak_memory_bytes"] - empty
                sent = figures["sent_bytes"] / summary["iterations"]
                cells = summary["points"] * 4 * (dimension + 1)
                print(f"| {dimension} | {sites} | {ranks} | {summary['seconds']['total']:.2f} | "
                      f"{first['seconds']['total'] / summary['seconds']['total']:.2f} | {memory / 1e6:.0f} MB | "
                      f"{memory / (first['ranks']['largest_peak_memory_bytes'] - empty):.2f} | {sent / 1e6:.3f} MB | "
                      f"{100 * sent / cells:.2f} % | {figures['messages']} |", flush=True)  # fmt: skip
    print("\n| vectors | method | ranks | seconds | times as fast | largest rank | messages |\n|---|---|---|---|---|---|---|")
    for vectors in numbers(given.vectors):
        write_clouds("vectors.npy", vectors)
        for method in ("exact", "lloyd"):
            best = fastest(lambda ranks: program_of(ranks, "quantize", "vectors.npy", "--codewords", "1024",
                                                    "--method", method))  # fmt: skip
            for ranks, summary in sorted(best.items()):
                figures = summary["ranks"]
                print(f"| {vectors} | {method} | {ranks} | {summary['seconds']['total']:.2f} | "
                      f"{best[min(best)]['seconds']['total'] / summary['seconds']['total']:.2f} | "
                      f"{(figures['largest_peak_memory_bytes'] - empty) / 1e6:.0f} MB | {figures['messages']} |",
                      flush=True)  # fmt: skip
