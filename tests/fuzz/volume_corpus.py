#!/usr/bin/env python3
"""Writes small valid volumes, one input of volume_fuzzer each, into the folder given."""
import gzip
import pathlib
import struct
import sys

folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
data = bytes(range(24))

nifti1 = bytearray(352)
struct.pack_into("<i", nifti1, 0, 348)
struct.pack_into("<8h", nifti1, 40, 3, 2, 3, 4, 1, 1, 1, 1)
struct.pack_into("<2h", nifti1, 70, 2, 8)
struct.pack_into("<4f", nifti1, 76, 1, 1, 2, 3)
struct.pack_into("<2f", nifti1, 108, 352, 0)
nifti1[344:348] = b"n+1\0"

nifti2 = bytearray(544)
struct.pack_into(">i", nifti2, 0, 540)
nifti2[4:12] = b"n+2\0\r\n\x1a\n"
struct.pack_into(">2h", nifti2, 12, 2, 8)
struct.pack_into(">8q", nifti2, 16, 3, 2, 3, 4, 1, 1, 1, 1)
struct.pack_into(">4d", nifti2, 104, 1, 1, 2, 3)
struct.pack_into(">q", nifti2, 168, 544)

nrrd = b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 3 4\nencoding: %s\n" \
       b"space directions: (1,0,0) (0,1,0) (0,0,3)\nspace origin: (5,6,7)\nkinds: domain domain domain\n\n"
npy = b"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 4), }"
npy = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + npy.ljust(117) + b"\n" + data

inputs = {
    "nifti1": b"\0" + nifti1 + data,
    "nifti2": b"\0" + nifti2 + data,
    "nifti_gz": b"\1" + gzip.compress(nifti1 + data),
    "nrrd_raw": b"\2" + nrrd % b"raw" + data,
    "nrrd_gzip": b"\2" + nrrd % b"gzip" + gzip.compress(data),
    "npy": b"\3" + npy,
    "raw": b"\4" + data,
}
for name, content in inputs.items():
    (folder / name).write_bytes(content)
