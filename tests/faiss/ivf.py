#!/usr/bin/python3
"""A codebook of ccvt as an inverted file of FAISS: ivf.py PROGRAM

Trains with PROGRAM (ccvt) in a directory of its own, loads the result in the two ways that
src/docs/codebooks.md shows, and checks what that promises. Needs python3-faiss.
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
    """The lists that FAISS finds: |(p, 0) - (s, sqrt(W - w))|^2 = |p - s|^2 - w + W."""
    lifted = faiss.IndexFlatL2(DIMENSION + 1)
    lifted.add(lift(codewords, numpy.sqrt(weights.max() - weights)))
    return lifted.search(lift(vectors, numpy.zeros(len(vectors))), 1)[1].ravel()


def ids(index, k):
    pointer = index.invlists.get_ids(k)
    return numpy.sort(faiss.rev_swig_ptr(pointer, index.invlists.list_size(k)))


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
    for k in range(LISTS):
        check((ids(index, k) == numpy.flatnonzero(codes == k)).all(), f"by codes: list {k} differs")
    queries = vectors[::20] + numpy.float32(0.01)
    exact = faiss.IndexFlatL2(DIMENSION)
    exact.add(vectors)
    index.nprobe = 8
    recall = (index.search(queries, 1)[1] == exact.search(queries, 1)[1]).mean()
    check(recall > 0.9, f"by codes: 8 of {LISTS} lists find {recall} of the nearest")

    # At the optimum about one vector a list costs as much in another one.
    other = (by_weights(vectors, codewords, weights.ravel()) != codes).sum()
    check(other <= 2 * LISTS, f"by weights: {other} vectors in other lists")
    print(f"by codes: lists of {capacities.min()} to {capacities.max()} vectors, as trained; "
          f"8 of them find {recall:.3f} of the nearest; "
          f"by weights: {other} of {COUNT} vectors in another list")


if __name__ == "__main__":
    main()
