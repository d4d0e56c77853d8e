#!/usr/bin/env python3
"""Writes small valid point clouds, one input of cloud_fuzzer each, into the folder given."""
import pathlib
import struct
import sys

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)

head = b"ply\nformat %s 1.0\ncomment c\nelement face 1\nproperty list uchar int i\n" \
       b"element vertex 2\nproperty float x\nproperty double y\nproperty list ushort short w\n" \
       b"property float z\nproperty float nx\nproperty float ny\nproperty float nz\n" \
       b"property uchar red\nend_header\n"


def binary(order):
    face = struct.pack(order + "B3i", 3, 0, 1, 2)
    vertex = struct.pack(order + "fdH2hffffB", 1, 2, 2, 7, -8, 3, 0, 0, 1, 200)
    return face + vertex + vertex


inputs = {
    "little": b"\0" + head % b"binary_little_endian" + binary("<"),
    "big": b"\0" + head % b"binary_big_endian" + binary(">"),
    "ascii": b"\0" + head % b"ascii" + b"3 0 1 2\n1 2 0 3 0 0 1 4\n1e3 -2 1 9 .5 nan 0 1 4\n",
    "csv": b"\1x,y,z,nx,ny,nz,a\n1,2,3,0,0,1,7\n4,5,6,0,0,nan,8\n",
}
for name, content in inputs.items():
    (folder / name).write_bytes(content)
