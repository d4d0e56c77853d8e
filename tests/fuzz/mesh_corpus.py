#!/usr/bin/env python3
"""Writes small valid meshes, one input of mesh_fuzzer each, into the folder given."""
import pathlib
import struct
import sys

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)

header = "ply\nformat %s 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty double y\n" \
         "property list uchar short skipped\nproperty uchar quality\nproperty float z\nelement face 2\n" \
         "property uchar flags\nproperty list uchar int vertex_indices\nend_header\n"
places = [(0, 0, 2), (1, 0, 2), (1, 1, 2), (0, 1, 2)]
faces = [[0, 1, 2, 3], [2, 1, 0]]


def binary(order):
    body = b""
    for k, (x, y, z) in enumerate(places):
        body += struct.pack(order + "fdB%dhBf" % (k % 2), x, y, k % 2, *[7] * (k % 2), k, z)
    for face in faces:
        body += struct.pack(order + "BB%di" % len(face), 0, len(face), *face)
    return body


ascii_body = "".join("%d %d 1 7 5 %d\n" % place for place in places)
ascii_body += "".join("0 %d %s\n" % (len(face), " ".join(map(str, face))) for face in faces)
obj = "# a square\nmtllib x.mtl\nv 0 0 2 1 0 0\nv 1 0 2 .5 0 0\nvt 0 0\nvn 0 0 1\nv 1 1 2 0 1 1\r\n" \
      "v 0 1 2 .1 .2 .3\ng all\nf 1/1/1 2//1 \\\n3/1 4\nf -2 -3 \\\n-4/1\n"
inputs = {
    "ascii": b"\0" + (header % "ascii" + ascii_body).encode(),
    "ascii_dense": b"\2" + (header % "ascii" + ascii_body).encode(),
    "little": b"\0" + (header % "binary_little_endian").encode() + binary("<"),
    "big": b"\2" + (header % "binary_big_endian").encode() + binary(">"),
    "obj": b"\1" + obj.encode(),
    "obj_dense": b"\3" + obj.encode(),
}
for name, content in inputs.items():
    (folder / name).write_bytes(content)
