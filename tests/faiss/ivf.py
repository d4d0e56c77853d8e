#!/usr/bin/python3
"""A codebook of ccvt as an inverted file of FAISS: ivf.py PROGRAM

Trains with PROGRAM (ccvt) in a directory of its own, loads the result in the two ways that
README.md shows, and checks what that promises. Needs python3-faiss.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import faiss
import numpy

COUNT, DIMENSION, LISTS = 20000, 16, 64


def clouds():
    """Clouds of unequal size and spread."""
    random = numpy.random.default_rng(1)
    centres = random.normal(size=(30, DIMENSION))
    cloud = (30 * random.random(COUNT) ** 2).astype(int)
    spread = 0.2 + cloud / 60
    noise = random.normal(size=(COUNT, DIMENSION)) * spread[:, None]
    return (centres[cloud] + noise).astype("float32")


def train(program, directory, vectors):
    numpy.save(directory / "vectors.npy", vectors)
    subprocess.run(
        [program, "quantize", "vectors.npy", "--codewords", str(LISTS), "--quiet",
         "-o", "codewords.npy", "--codes-out", "codes.npy", "--weights-out", "weights.npy"],
        cwd=directory, check=True)
    return [numpy.load(directory / name) for name in ("codewords.npy", "codes.npy", "weights.npy")]


def by_codes(vectors, codewords, codes):
    """Lists as ccvt has filled them; queries look at the nearest codewords."""
    quantizer = faiss.IndexFlatL2(DIMENSION)
    quantizer.add(codewords.astype("float32"))
    index = faiss.IndexIVFFlat(quantizer, DIMENSION, LISTS)
    index.is_trained = True
    lists = codes.astype("int64")
    index.add_core(len(vectors), faiss.swig_ptr(vectors), None, faiss.swig_ptr(lists))
    return index, quantizer


def lift(vectors, last):
    return numpy.column_stack([vectors, last]).astype("float32")


def by_weights(vectors, codewords, weights):
    """FAISS fills the lists: |(p, 0) - (s, sqrt(W - w))|^2 = |p - s|^2 - w + W."""
    quantizer = faiss.IndexFlatL2(DIMENSION + 1)
    quantizer.add(lift(codewords, numpy.sqrt(weights.max() - weights)))
    index = faiss.IndexIVFFlat(quantizer, DIMENSION + 1, LISTS)
    index.is_trained = True
    index.add(lift(vectors, numpy.zeros(len(vectors))))
    return index, quantizer


def lengths(index):
    return numpy.array([index.invlists.list_size(k) for k in range(LISTS)])


def check(condition, message):
    if not condition:
        sys.exit("ivf.py: " + message)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    vectors = clouds()
    with tempfile.TemporaryDirectory() as name:
        codewords, codes, weights = train(Path(sys.argv[1]).resolve(), Path(name), vectors)
    capacities = numpy.bincount(codes, minlength=LISTS)
    check(capacities.max() - capacities.min() <= 1, f"lists of {capacities}")

    index, keep = by_codes(vectors, codewords, codes)
    check((lengths(index) == capacities).all(), "by codes: lists are not as long as capacities")
    index.nprobe = LISTS  # all: the search must find what a search without lists finds
    queries = clouds()[:100] + numpy.float32(0.01)
    exact = faiss.IndexFlatL2(DIMENSION)
    exact.add(vectors)
    check((index.search(queries, 1)[1] == exact.search(queries, 1)[1]).mean() > 0.98,
          "by codes: other neighbours than without lists")

    index, keep = by_weights(vectors, codewords, weights.ravel())
    # At the optimum about a vector a list costs as much in another one, and FAISS computes in float.
    moved = numpy.abs(lengths(index) - capacities).sum() // 2
    check(moved <= 2 * LISTS, f"by weights: {moved} vectors are in other lists")
    print(f"by codes: lists of {capacities.min()} to {capacities.max()} vectors, as trained; "
          f"by weights: {lengths(index).min()} to {lengths(index).max()}, "
          f"{moved} of {COUNT} on the other side of a tie")


if __name__ == "__main__":
    main()
