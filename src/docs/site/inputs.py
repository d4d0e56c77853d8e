#!/usr/bin/python3
"""Makes, in a folder, the files that the guides' commands read and the repository does not hold:
points, a scan, a volume, vectors, all made up. No other packages.

usage: inputs.py DIR
"""

import array
import gzip
import math
import pathlib
import random
import struct
import sys


def inputs(folder):
    """Points, scans, vectors and volumes, made up, under the names that the guides use."""
    folder = pathlib.Path(folder)
    draw = random.Random(1)

    def rows(name, table, header=None):
        text = "\n".join(",".join(f"{x:.6g}" for x in row) for row in table) + "\n"
        (folder / name).write_text((header + "\n" if header else "") + text)

    def npy(name, shape, values):
        head = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}"
        head += " " * (63 - (len(head) + 10) % 64) + "\n"
        data = array.array("f", values)
        (folder / name).write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + data.tobytes())

    def vecs(name, table):
        (folder / name).write_bytes(b"".join(struct.pack(f"<i{len(v)}f", len(v), *v) for v in table))

    plane = [(draw.random(), draw.random()) for _ in range(12800)]
    rows("points.csv", plane, "x,y")
    rows("samples.csv", [(draw.gauss(0, 1), x, y) for x, y in plane], "time,x,y")
    rows("stars.csv", [(x, y, draw.paretovariate(3)) for x, y in plane[:6000]], "x,y,m")
    rows("theirs1.csv", plane[:256])
    rows("theirs2.csv", plane[256:512])
    design = [((i + .5) / 4, (j + .5) / 4) for i in range(4) for j in range(4)]
    rows("design.csv", design)
    npy("design.npy", (16, 2), [x for place in design for x in place])
    pixels = [(x, y) for y in range(200) for x in range(200)]
    npy("pixels.npy", (40000, 2), [c for pixel in pixels for c in pixel])
    npy("darkness.npy", (40000,), [1.5 + math.sin(x / 20) * math.cos(y / 30) for x, y in pixels])
    clouds = [[draw.gauss(0, 4) for _ in range(8)] for _ in range(12)]
    vectors = [[c + draw.gauss(0, 1) for c in draw.choice(clouds)] for _ in range(8000)]
    vecs("vectors.fvecs", vectors)
    vecs("new.fvecs", [[x + draw.gauss(0, .3) for x in v] for v in vectors[:2000]])
    size = 48
    grid = [i / (size - 1) * 2 - 1 for i in range(size)]
    field = [shell(x, y, z) for x in grid for y in grid for z in grid]
    npy("head.npy", (size, size, size), field)
    (folder / "head.raw").write_bytes(array.array("f", field).tobytes())
    labels = [3.0 if x > 0 else 7.0 for x in grid for y in grid for z in grid]
    (folder / "head.nii.gz").write_bytes(gzip.compress(nifti(size, field), mtime=0))
    (folder / "labels.nii").write_bytes(nifti(size, labels))
    scan = [bump(draw.random(), draw.random() ** 2, draw) for _ in range(60000)]
    text = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(scan)
    text += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")) + "end_header\n"
    (folder / "scan.ply").write_text(text + "\n".join(" ".join(f"{v:.5f}" for v in p) for p in scan) + "\n")


def nifti(size, values):
    """A volume of float32 in NIfTI-1: cells of 2 millimetres around the origin."""
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, size, size, size, 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, 16, 32)  # datatype, bits
    struct.pack_into("<8f", head, 76, 1, 2, 2, 2, 1, 1, 1, 1)
    struct.pack_into("<fff", head, 108, 352, 1, 0)  # vox_offset, slope, intercept
    struct.pack_into("<hh", head, 252, 0, 1)  # sform
    for axis in range(3):
        row = [0.0, 0.0, 0.0, 1.0 - size]
        row[axis] = 2.0
        struct.pack_into("<4f", head, 280 + 16 * axis, *row)
    head[344:348] = b"n+1\0"
    return bytes(head) + array.array("f", values).tobytes()


def shell(x, y, z):
    """A field with an inside, a bright rind and nothing outside."""
    r = math.sqrt(x * x + 1.3 * y * y + 1.6 * z * z)
    folds = .08 * math.sin(9 * x) * math.sin(8 * y) * math.sin(7 * z)
    return max(0.0, math.exp(-((r - .72 + folds) / .12) ** 2) + .25 * (r < .6)) if r < .98 else 0.0


def bump(u, v, draw):
    """A point with its normal on a wavy sheet, with the noise of a scanner."""
    z = .12 * math.sin(7 * u) * math.cos(6 * v)
    slope = (-.84 * math.cos(7 * u) * math.cos(6 * v), .72 * math.sin(7 * u) * math.sin(6 * v), 1.0)
    length = math.sqrt(sum(s * s for s in slope))
    return (u, v, z + draw.gauss(0, .0015), *(s / length for s in slope))


if __name__ == "__main__":
    inputs(sys.argv[1])
