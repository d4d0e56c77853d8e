#!/usr/bin/env python3
"""ccvt-mpi beside ccvt: the same files to the bit, and how it ends when something is wrong.

    program.py BIN MPIRUN [--ranks 1,2,3] [--short] [--parts bits,faults | --soak PROBLEMS]

BIN is the directory of both programs. With --short, not each number of ranks with each number of
threads, but one and two of these in turn. With --parts, only these. With --soak, random problems
instead.
"""

import argparse
import fcntl
import gzip
import json
import os
import pathlib
import random
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time

parser = argparse.ArgumentParser()
parser.add_argument("bin", type=pathlib.Path)
parser.add_argument("mpirun")
parser.add_argument("--ranks", default="1,2,3,4,7")
parser.add_argument("--short", action="store_true")
parser.add_argument("--parts", default="")
parser.add_argument("--soak", type=int, default=0)
given = parser.parse_args()
given.bin = given.bin.resolve()
ALONE = str(given.bin / "ccvt")
TOGETHER = str(given.bin / "ccvt-mpi")
RANKS = [int(n) for n in given.ranks.split(",")]
# Open MPI asks these of root; and wants to hear that there are more ranks than processors.
os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
os.environ.update(OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none")
work = tempfile.TemporaryDirectory()
os.chdir(work.name)
failures = 0


def check(holds, what):
    global failures
    if not holds:
        failures += 1
        print("FAILED:", what, flush=True)


def alone(*arguments):
    subprocess.run([ALONE, *arguments, "-q"], check=True)


def together(ranks, *arguments):
    command = [given.mpirun, "-n", str(ranks), TOGETHER, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def files(prefix, *options):
    """Options that name outputs, which begin with a prefix."""
    return [part for option, name in options for part in (option, prefix + name)]


def compare(command, options, arguments, ranks=RANKS, threads=(1, 2)):
    alone(*command, *arguments, *files("alone-", *options))
    for k, n in enumerate(ranks):
        for t in (threads[k % len(threads)],) if given.short else threads:
            run = together(n, *command, *arguments, *files("ranks-", *options), "--threads", str(t))
            check(run.returncode == 0, f"{command} {arguments}, {n} ranks: {run.stderr}")
            for _, name in options:
                path = pathlib.Path("ranks-" + name)
                same = path.exists() and path.read_bytes() == pathlib.Path("alone-" + name).read_bytes()
                check(same, f"{command} {arguments}, {n} ranks, {t} threads: {name}")
                path.unlink(missing_ok=True)


ALL = [("-o", "sites.npy"), ("--owners-out", "owners.npy"), ("--points-out", "points.npy")]


def bits():
    for dimension in ("2", "3"):
        for domain in ([], ["--periodic"]):
            compare(["sample"], ALL, ["--dim", dimension, "--sites", "700", *domain])
    compare(["sample"], ALL, ["--dim", "2", "--sites", "300", "--double", "--seed", "4",
                              "--distribution", "white", "--points-per-site", "100"])
    compare(["sample"], [("-o", "load.hdf5" if "hdf5" in supported() else "load.csv")],
            ["--dim", "3", "--sites", "200", "--periodic"], threads=(1,))
    alone("sample", "--dim", "3", "--sites", "10", "--points-per-site", "5000", "-o", "ten.npy",
          "--points-out", "cloud.npy")
    random.seed(1)
    sizes = [random.randrange(1, 200) for _ in range(399)]
    pathlib.Path("capacities.csv").write_text("\n".join(map(str, sizes + [50000 - sum(sizes)])))
    compare(["tessellate"], ALL[:2], ["cloud.npy", "--sites", "12"])  # many points a site
    given_capacities = ["cloud.npy", "--sites", "400", "--capacities", "capacities.csv"]
    compare(["tessellate"], ALL[:2], given_capacities)
    compare(["tessellate"], ALL[:2], ["cloud.npy", "--capacities", "capacities.csv"], threads=(1,))
    compare(["tessellate"], ALL[:2], ["cloud.npy", "--sites", "150", "--periodic", "--box",
                                      *"0 0 0 1 1 1".split(), "--fixed-sites", "ten.npy"])
    compare(["tessellate"], ALL[:2], ["cloud.npy", "--sites", "150", "--periodic", "--box",
                                      *"0 0 0 1 1 1".split(), "--units", "1,3,.5", "--fixed-sites",
                                      "ten.npy"])
    compare(["tessellate"], ALL[:2], ["cloud.npy", "--sites", "150", "--whiten", "--fixed-sites", "ten.npy"])


SAMPLES = [("-o", "samples.csv")]


def volumes():
    """A bright half of a volume whose last layers are empty; and labels, a thin one of which is a shell."""
    shape = (24, 20, 40)
    cells = [(i, j, k) for k in range(shape[2]) for j in range(shape[1]) for i in range(shape[0])]
    values = [0 if k > 33 else 50 + i * 3 + k for i, _, k in cells]
    shell = [1 if 60 < (i - 12) ** 2 + (j - 10) ** 2 + (k - 15) ** 2 < 85 else 0 for i, j, k in cells]
    pathlib.Path("v.raw").write_bytes(struct.pack(f"<{len(values)}h", *values))
    header = "NRRD0004\ntype: short\ndimension: 3\nsizes: 24 20 40\nendian: {}\nencoding: {}\n\n"
    pathlib.Path("v.nrrd").write_bytes(header.format("big", "raw").encode()
                                       + struct.pack(f">{len(values)}h", *values))
    pathlib.Path("packed.nrrd").write_bytes(header.format("little", "gzip").encode()
                                            + gzip.compress(struct.pack(f"<{len(values)}h", *values)))
    pathlib.Path("labels.raw").write_bytes(struct.pack(f"<{len(shell)}h", *shell))
    raw = "--shape 24,20,40 --type int16".split()
    sites = ["--sites", "300", "--points-per-site", "60"]
    compare(["volume"], SAMPLES, ["v.raw", *raw, *sites])
    compare(["volume"], [("-o", "samples.ply")], ["v.nrrd", *sites, "--double", "--seed", "7"])
    compare(["volume"], SAMPLES, ["packed.nrrd", *sites, "--map", "gamma:2", "--invert"], threads=(1,))
    compare(["volume"], SAMPLES, ["v.raw", *raw, "--sites", "30", "--points-per-site", "700", "--mask",
                                  "labels.raw", "--label", "1", "--interpolation", "constant"])
    compare(["volume"], SAMPLES, ["v.nrrd", *raw, "--sites", "30", "--mask", "labels.raw"], threads=(1,))


def volume_faults():
    outputs = ["--sites", "20", "-o", "bad-samples.csv"]
    raw = "--shape 24,20,40 --type int16".split()
    ends(together(3, "volume", "v.nrrd", *outputs, "--preview", "bad-p.png"), 2, "--preview: is for ccvt only")
    ends(together(3, "volume", "v.nrrd", *outputs, "--label", "3"), 2, "--label: needs --mask")
    ends(together(3, "volume", "absent.nrrd", *outputs), 2, "absent.nrrd")
    ends(together(3, "volume", "v.raw", *raw, "--mask", "labels.raw", "--label", "9", *outputs), 2,
         "labels.raw: no cell has the label 9")
    for order in (False, True):
        header = f"{{'descr': '|u1', 'fortran_order': {order}, 'shape': (4, 4, 4), }}\n"
        pathlib.Path(f"{order}.npy").write_bytes(
            b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + b"\1" * 64)
    ends(together(3, "volume", "True.npy", "--mask", "False.npy", *outputs), 2,
         "False.npy: its axes are stored in another order than those of True.npy")
    short = pathlib.Path("v.nrrd").read_bytes()[:-3]
    pathlib.Path("short.nrrd").write_bytes(short)
    ends(together(3, "volume", "short.nrrd", *outputs), 2, "short.nrrd: is truncated")
    packed = bytearray(pathlib.Path("packed.nrrd").read_bytes())
    packed[-8] ^= 1  # the checksum, which the last rank reads
    pathlib.Path("damaged.nrrd").write_bytes(packed)
    ends(together(3, "volume", "damaged.nrrd", *outputs), 2, "damaged.nrrd")
    numbers = [1.0] * (24 * 20 * 40)
    numbers[-2] = float("nan")
    pathlib.Path("nan.raw").write_bytes(struct.pack(f"<{len(numbers)}f", *numbers))
    ends(together(3, "volume", "nan.raw", "--shape", "24,20,40", "--type", "float32", *outputs), 2,
         "nan.raw: value 19198 is nan")
    numbers[-2] = -4
    pathlib.Path("negative.raw").write_bytes(struct.pack(f"<{len(numbers)}f", *numbers))
    ends(together(3, "volume", "negative.raw", "--shape", "24,20,40", "--type", "float32", *outputs), 2,
         "has values from -4 to 1")


def make_vectors(name, rows, dimension):
    """Clouds of whole numbers, some vectors twice, as .npy of floats, .fvecs and .bvecs."""
    random.seed(rows)
    clouds = [[random.randrange(20, 230) for _ in range(dimension)] for _ in range(8)]
    values = []
    for row in range(rows):
        cloud = random.choice(clouds)
        again = row % 40 == 9
        values.append(values[row // 2] if again else [x + random.randrange(-20, 21) for x in cloud])
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {dimension}), }}"
    header = header.ljust(117) + "\n"
    pathlib.Path(name + ".npy").write_bytes(
        b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()
        + b"".join(struct.pack(f"<{dimension}f", *row) for row in values))
    pathlib.Path(name + ".fvecs").write_bytes(
        b"".join(struct.pack(f"<i{dimension}f", dimension, *row) for row in values))
    pathlib.Path(name + ".bvecs").write_bytes(
        b"".join(struct.pack(f"<i{dimension}B", dimension, *row) for row in values))


BOOK = [("-o", "book.npy"), ("--codes-out", "codes.npy")]


def codebooks():
    make_vectors("few", 2003, 3)
    make_vectors("many", 4001, 20)
    lloyd = ["--method", "lloyd", "--codewords"]
    compare(["quantize"], BOOK, ["few.npy", *lloyd, "400"])
    compare(["quantize"], BOOK, ["many.fvecs", *lloyd, "30", "--seed", "5"])
    compare(["quantize"], BOOK, ["many.bvecs", *lloyd, "600", "--seeding", "random",
                                 "--max-iterations", "9"], threads=(1,))
    compare(["quantize"], BOOK, ["many.npy", *lloyd, "10", "--columns", "3,1,7"], threads=(1,))
    compare(["quantize"], BOOK, ["few.fvecs", *lloyd, "1"], threads=(1,))
    balanced = [*BOOK, ("--weights-out", "weights.npy")]
    compare(["quantize"], balanced, ["few.npy", "--codewords", "40"])
    compare(["quantize"], balanced, ["many.fvecs", "--codewords", "300", "--gap", "1e-3"], threads=(1,))
    compare(["quantize"], balanced, ["many.bvecs", "--codewords", "30", "--effort", "0",
                                     "--train-sample", "2000"], threads=(1,))
    compare(["quantize"], BOOK, ["many.npy", "--codewords", "30", "--method", "pairwise"], threads=(1,))
    pathlib.Path("capacities.csv").write_text("1\n2000\n1500\n500\n")
    compare(["quantize"], balanced, ["many.npy", "--codewords", "4", "--capacities", "capacities.csv"],
            threads=(1,))
    alone("quantize", "many.npy", "--codewords", "70", "-o", "trained.npy", "--weights-out",
          "weights.npy")
    compare(["quantize"], BOOK, ["many.fvecs", *lloyd, "70", "--seeding", "trained.npy"], threads=(1,))
    for vectors in ("many.npy", "many.fvecs", "many.bvecs"):
        compare(["encode"], [("-o", "codes.npy")], [vectors, "--codebook", "trained.npy"])
    compare(["encode"], [("-o", "codes.npy")],
            ["many.npy", "--codebook", "trained.npy", "--weights", "weights.npy"])
    alone("quantize", "few.npy", *lloyd, "200", "-o", "trained3.npy")
    compare(["encode"], [("-o", "codes.npy")], ["few.fvecs", "--codebook", "trained3.npy"])
    reports()


def reports():
    """What is printed and summed up is the same, but for times and memory."""
    for command in (["quantize", "many.npy", "--method", "lloyd", "--codewords", "30", "--summary",
                     "summary.json", "-o", "book.npy"],
                    ["encode", "many.npy", "--codebook", "trained.npy", "-o", "codes.npy"]):
        run = subprocess.run([ALONE, *command], capture_output=True, text=True, check=True)
        expected = without_times(run.stdout)
        summary = pathlib.Path("summary.json")
        alone_json = without_times(summary.read_text())
        run = together(3, *command)
        lines = run.stdout.splitlines(keepends=True)
        check(without_times("".join(lines[:-1])) == expected, f"printed: {run.stdout}")
        check(lines[-1].startswith("3 ranks sent"), f"the last line: {lines[-1]}")
        check(without_times(summary.read_text()) == alone_json, f"summary of {command[0]}")


def without_times(text):
    if not text.startswith("{"):
        return re.sub(r", [^ ]* s\n", "\n", text)
    values = json.loads(text)
    for key in ("seconds", "peak_memory_bytes", "ranks", "threads"):
        values.pop(key, None)
    return values


def codebook_faults():
    outputs = ["-o", "bad-book.npy", "--codes-out", "bad-codes.npy"]
    lloyd = ["--method", "lloyd", "--codewords", "30"]
    pathlib.Path("few.csv").write_text("1\n2000\n1500\n499\n")
    ends(together(2, "quantize", "many.npy", "--codewords", "4", "--capacities", "few.csv", *outputs), 2,
         "few.csv: ")
    ends(together(2, "quantize", "many.npy", *lloyd, "--image-blocks", "4", *outputs), 2,
         "--image-blocks: is for ccvt only")
    ends(together(2, "quantize", "many.npy", *lloyd, "-o", "bad-book.npy", "--codes-out",
                  "bad-codes.csv"), 2, "--codes-out: bad-codes.csv")
    ends(together(3, "quantize", "many.npy", "--method", "lloyd", "--codewords", "5000", *outputs), 2,
         "many.npy: ")
    ends(together(3, "quantize", "many.npy", *lloyd, "--seeding", "trained.npy", *outputs), 2,
         "trained.npy: has 70 codewords, but --codewords is 30")
    ends(together(3, "encode", "few.npy", "--codebook", "trained.npy", "-o", "bad-codes.npy"), 2,
         "few.npy: vectors: have 3 dimensions, but the codewords have 20")
    ends(together(3, "encode", "many.npy", "--codebook", "trained.npy", "-o", "bad-codes.csv"), 2,
         "--output: bad-codes.csv")
    # In the last rank's part only.
    broken = bytearray(pathlib.Path("many.fvecs").read_bytes())
    broken[-4:] = b"\x00\x00\xc0\x7f"
    pathlib.Path("broken.fvecs").write_bytes(broken)
    broken[-84:-80] = struct.pack("<i", 19)
    pathlib.Path("other.fvecs").write_bytes(broken)
    for command in (["quantize", *lloyd, "-o", "bad-book.npy"],
                    ["encode", "--codebook", "trained.npy", "-o", "bad-codes.npy"]):
        ends(together(3, command[0], "broken.fvecs", *command[1:]), 2,
             "row 4000, column 19: nan is not finite")
        ends(together(3, command[0], "other.fvecs", *command[1:]), 2,
             "vector 4000 has 19 dimensions, but vector 0 has 20")


def supported():
    return subprocess.run([ALONE, "--version"], capture_output=True, text=True).stdout


def ends(run, status, line):
    """One line of ours says why, whatever the number of ranks; mpirun may say more."""
    own = [text for text in run.stderr.splitlines() if "ccvt-mpi: error: " in text]
    check(run.returncode == status, f"status {run.returncode} instead of {status}: {run.stderr}")
    check(len(own) == 1 and line in own[0], f"expected one line with '{line}': {own}")
    left = [path.name for path in pathlib.Path().iterdir()
            if path.name.startswith(".ccvt") or path.name.startswith("bad-")]
    check(left == [], f"left behind: {left}")


def faults():
    alone("sample", "--dim", "2", "--sites", "10", "--points-per-site", "500", "-o", "x.npy",
          "--points-out", "points.npy")
    outputs = ["-o", "bad-sites.npy", "--owners-out", "bad-owners.npy"]
    ends(together(3, "sample", "--dim", "2", "--sites", "0", *outputs), 2, "--sites")
    ends(together(3, "tessellate", "points.npy", *outputs), 2, "needs --sites")
    ends(together(3, "tessellate", "absent.npy", "--sites", "5", *outputs), 2, "absent.npy")
    ends(together(3, "sample", "--dim", "2", "--sites", "9", "-o", "none/bad.npy"), 2, "none")
    ends(together(3, "sample", "--dim", "9", "--sites", "9", *outputs), 2,
         "--dim: has 9 dimensions; several processes know up to 8")
    ends(together(2, "sample", "--dim", "2", "--sites", "9", "--preset", "fast-ccvt", *outputs), 2,
         "--preset: 'fast-ccvt' does not start balanced")
    pathlib.Path("points.csv").write_text("1,2\n3,4\n")
    ends(together(2, "tessellate", "points.csv", "--sites", "2", *outputs), 2,
         "points.csv: several processes read files in .npy, .fvecs and .bvecs")
    first = ["-n", "1", TOGETHER, "sample", "--dim", "2", "--sites", "9", *outputs]
    for second in (["--max-iterations", "3"], ["--bogus"], ["--seed", "2"]):
        command = [given.mpirun, *first, ":", *first, *second]
        ends(subprocess.run(command, capture_output=True, text=True, timeout=300), 2,
             "rank 1 was started with other arguments than rank 0")
    command = [given.mpirun, *first, ":", *first, "--threads", "2"]
    alike = subprocess.run(command, capture_output=True, text=True, timeout=300)
    check(alike.returncode == 0, f"threads may differ: {alike.stderr}")
    for name in ("bad-sites.npy", "bad-owners.npy"):
        pathlib.Path(name).unlink()
    pathlib.Path("masses.csv").write_text("1\n2\n")
    forty = ["tessellate", "points.npy", "--sites", "40", *outputs]
    ends(together(2, *forty, "--masses", "masses.csv"), 2,
         "--masses: is for ccvt only, not for several processes")
    ends(together(2, *forty, "--shares-out", "bad-shares.csv"), 2,
         "error: --shares-out: is for ccvt only, not for several processes")
    ends(together(2, *forty, "--points-per-site", "9"), 2, "--points-per-site: is for ccvt only")
    ends(together(3, "sample", "--dim", "2", "--sites", "2000000000", "--points-per-site", "2000000000",
                  "-o", "bad-sites.npy"), 2,
         "--sites 2000000000: with --points-per-site 2000000000 there are 4000000000000000000 points, "
         "but at most 1099511627776 are supported")
    ends(together(2, "stipple", "photo.png"), 2, "stipple: is for ccvt only, not for several processes")
    ends(together(2, "tessellate", "npy:-", "--sites", "4", *outputs), 2,
         "POINTS: 'npy:-' is a stream: ccvt-mpi reads and writes files only")
    ends(together(2, "sample", "--dim", "2", "--sites", "9", "-o", "-"), 2,
         "--output: '-' is a stream: ccvt-mpi reads and writes files only")
    texts = together(2, "tessellate", "--help").stdout
    check("Example: mpirun" in texts and ".csv" not in texts.split("Problem:")[0], texts)
    check(not any(word in texts for word in ("mass", "Standard streams", "fast-ccvt")), texts)
    ends(together(2, "sample", "--dim", "2", "--sites", "9", "-o", "bad-sites.npy", "--owners-out",
                  "bad-owners.csv"), 2, ".npy")
    # In the last rank's part only.
    broken = bytearray(pathlib.Path("points.npy").read_bytes())
    broken[-4:] = b"\x00\x00\xc0\x7f"
    pathlib.Path("broken.npy").write_bytes(broken)
    ends(together(3, "tessellate", "broken.npy", "--sites", "40", *outputs), 2,
         "row 4999, column 1: nan is not finite")
    pathlib.Path("short.npy").write_bytes(broken[:-9])
    ends(together(3, "tessellate", "short.npy", "--sites", "40", *outputs), 2, "short.npy")
    # As where each machine has a file of its own under one name.
    for name, sites in (("a", "10"), ("b", "9")):
        pathlib.Path(name).mkdir()
        alone("sample", "--dim", "2", "--sites", sites, "--points-per-site", "50", "-o", f"{name}/x.npy",
              "--points-out", f"{name}/points.npy")
    read = [TOGETHER, "tessellate", "points.npy", "--sites", "5", "-o", f"{work.name}/bad-sites.npy"]
    unlike = [given.mpirun, "-n", "1", "-wdir", "a", *read, ":", "-n", "1", "-wdir", "b", *read]
    ends(subprocess.run(unlike, capture_output=True, text=True, timeout=300), 2,
         "points.npy: its number of rows is 450 on rank 1, but 500 on rank 0")


def sample_of(sites):
    return ["sample", "--dim", "3", "--sites", str(sites), "--threads", "1"]


EVERY = ["--checkpoint", "kept", "--checkpoint-every", "0"]
KEPT = [*sample_of(4000), *EVERY]


def goes_on(command, outputs, what, kept=KEPT):
    """What is kept leads to the result of one process that keeps nothing."""
    run = subprocess.run([*command, *kept, *files("kept-", *outputs)], capture_output=True, text=True)
    check(run.returncode == 0 and "goes on from kept" in run.stderr, f"{what}: {run.stderr}")
    for _, name in outputs:
        same = pathlib.Path("kept-" + name).read_bytes() == pathlib.Path("alone-" + name).read_bytes()
        check(same, f"{what}, going on: {name}")
    check(list(pathlib.Path("kept").iterdir()) == [], f"{what}: something is left of what was kept")


def start_kept(ranks, *arguments, options=()):
    """A run that has been kept once; the numbers of its processes, by rank."""
    run = subprocess.Popen([given.mpirun, *options, "-n", str(ranks), TOGETHER, *arguments],
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while run.poll() is None and not pathlib.Path("kept/ccvt.checkpoint").exists():
        time.sleep(0.02)
    for _ in range(500):
        if len(processes()) == ranks or run.poll() is not None:
            break
        time.sleep(0.02)
    found = {}
    for number in processes():
        for name in (b"OMPI_COMM_WORLD_RANK=", b"PMI_RANK="):
            for entry in pathlib.Path(f"/proc/{number}/environ").read_bytes().split(b"\0"):
                if entry.startswith(name):
                    found[int(entry[len(name):])] = number
    check(sorted(found) == list(range(ranks)), f"{ranks} ranks run: {found}")
    return run, found


def checkpoints():
    """What ranks keep, other numbers of them and one process go on from, and the other way."""
    outputs = ALL[:2]
    alone(*sample_of(4000), *files("alone-", *outputs))
    first = files("kept-", *outputs)
    for ranks, after in ((3, [given.mpirun, "-n", "2", TOGETHER]), (2, [ALONE])):
        run = together(ranks, *KEPT, *first, "--max-iterations", "20")
        check(run.returncode == 0, f"{ranks} ranks are kept: {run.stderr}")
        goes_on(after, outputs, f"kept by {ranks} ranks, then {after}")
    alone(*KEPT, *first, "--max-iterations", "20")
    bad = ["-o", "bad-sites.npy", "--owners-out", "bad-owners.npy"]
    ends(together(3, *KEPT, *bad, "--seed", "3"), 2, "the option seed is 0 there, and here 3")
    directory = os.open("kept", os.O_RDONLY)
    fcntl.flock(directory, fcntl.LOCK_EX)
    ends(together(2, *KEPT, *bad), 2, "another process keeps its run there")
    os.close(directory)
    goes_on([given.mpirun, "-n", "3", TOGETHER], outputs, "kept by one process, then 3 ranks")
    ends(together(2, *sample_of(4000), "--checkpoint", "none/kept", *bad), 2, "none/kept: cannot be made")

    # The disk of one rank becomes full.
    for full in (0, 2):
        run, ranks = start_kept(3, *KEPT, *bad)
        resource.prlimit(ranks[full], resource.RLIMIT_FSIZE, (1000, resource.RLIM_INFINITY))
        errors = run.communicate(timeout=300)[1]
        ends(subprocess.CompletedProcess(run.args, run.returncode, stderr=errors), 1,
             "cannot be written: File too large")
        warned = errors.count("the run goes on, and what was kept of it before stays")
        check(warned == (full == 0), f"rank {full} is full: {warned} warnings: {errors}")
        goes_on([given.mpirun, "-n", "2", TOGETHER], outputs, f"the disk of rank {full} was full")

    # How long it takes to be kept once more is the disk's affair and that of what else runs here.
    for patience in (3, 6, 12):
        sites = long_enough(4 * patience, outputs)
        signals = (signal.SIGINT, signal.SIGTERM)
        if all(end_by(number, patience, sites, bad, outputs) for number in signals):
            break
    else:
        check(False, "ranks were killed before they had said that a signal ends them")
    interrupt_one()

    # The ranks of an mpirun that was killed need a while to notice: who comes next waits for them.
    alone(*sample_of(4000), *files("alone-", *outputs))
    run, _ = start_kept(2, *KEPT, *bad)
    run.kill()
    run.communicate(timeout=60)
    goes_on([given.mpirun, "-n", "2", TOGETHER], outputs, "mpirun was killed")
    wait_for_ranks("mpirun was killed")


def is_open_mpi():
    """Under the name of mpiexec it calls itself by that of its runtime."""
    version = subprocess.run([given.mpirun, "--version"], capture_output=True, text=True).stdout
    return "Open MPI" in version or "OpenRTE" in version


def ended_by(number, run):
    """Whoever gets a signal leaves nothing; but MPICH's mpirun hands Ctrl-C on, with which ranks that
    have begun end as ccvt does: with a result. After a signal its own status is now theirs, now 0."""
    left = sorted(path.name for path in pathlib.Path().iterdir() if "bad-" in path.name)
    if number == signal.SIGINT and not is_open_mpi() and left:
        check(run.returncode in (0, 130), f"SIGINT to ranks: status {run.returncode}")
        check(left == ["bad-owners.npy", "bad-sites.npy"], f"SIGINT to ranks left {left}")
        for name in left:
            pathlib.Path(name).unlink()
        return
    check(run.returncode != 0 or not is_open_mpi(), f"{number.name}: it ended well")
    check(left == [], f"{number.name} left {left}")


def wait_for_ranks(what):
    """mpirun may end before they do."""
    for _ in range(1200):
        if not processes():
            return
        time.sleep(0.05)
    check(False, f"{what}: its ranks went on")


def long_enough(seconds, outputs):
    """How many sites take one process so long; their result."""
    for sites in (64000, 100000, 160000, 256000, 400000):
        began = time.monotonic()
        alone(*sample_of(sites), *files("alone-", *outputs))
        if time.monotonic() - began > seconds:
            return sites
    check(False, f"even {sites} sites take less than {seconds} s")
    return sites


def end_by(number, patience, sites, bad, outputs):
    """mpirun waits for `patience` seconds, tells the ranks, waits as long again, and kills them: they
    are kept once more in between. The run is long enough for that; nothing else would have kept it
    again. It has begun when it says that it goes on. False where they were killed before they had
    said why they end."""
    patient = ["--mca", "odls_base_sigkill_timeout", str(patience)] if is_open_mpi() else []
    checkpoint = pathlib.Path("kept/ccvt.checkpoint")
    kept = [*sample_of(sites), "--checkpoint", "kept", "--checkpoint-every", "3600"]
    alone(*kept, *files("kept-", *outputs), "--max-iterations", "2")
    before = checkpoint.read_bytes()
    run, _ = start_kept(2, *kept, *bad, options=patient)
    begun = next((line for line in run.stderr if "goes on from kept" in line), None)
    check(begun is not None, f"{number.name} to mpirun: it did not go on")
    run.send_signal(number)
    errors = run.communicate(timeout=60)[1]
    wait_for_ranks(f"{number.name} to mpirun")
    if patient and "ended by a signal" not in errors:
        print(f"{number.name} to mpirun: killed within {patience} s: {errors}", flush=True)
        discard_kept()
        return False
    ended_by(number, run)
    check(errors.count("ccvt-mpi: error: ") < 2, f"{number.name} to mpirun: {errors}")
    if number == signal.SIGTERM:
        check("ended by a signal" in errors, f"{number.name} to mpirun: {errors}")
    if patient:
        check(checkpoint.read_bytes() != before, f"{number.name} to mpirun: not kept once more")
    goes_on([ALONE], outputs, f"{number.name} to mpirun", kept)
    return True


def discard_kept():
    for kept in pathlib.Path("kept").iterdir():
        kept.unlink()


def interrupt_one():
    """Ctrl-C to a single rank ends all with what has been reached, and says so."""
    sample = [*sample_of(40000), "-o", "part-sites.npy", "--checkpoint", "kept", "--checkpoint-every", "0"]
    run, ranks = start_kept(2, *sample)
    os.kill(ranks[1], signal.SIGINT)
    run.communicate(timeout=300)
    check(run.returncode == 130, f"SIGINT to one rank: status {run.returncode}")
    check(pathlib.Path("part-sites.npy").exists(), "SIGINT to one rank: no sites")
    discard_kept()


def processes():
    found = subprocess.run(["pgrep", "-f", f"^{TOGETHER} sample"], capture_output=True, text=True)
    return [int(number) for number in found.stdout.split()]


def kills():
    """Who is killed takes the others along, and nothing is half-written. They have been kept once:
    Open MPI's mpirun waits for ever when a rank is killed while it greets mpirun."""
    long_run = [*sample_of(40000), "-o", "bad-sites.npy", "--owners-out", "bad-owners.npy", *EVERY]
    for victim, name in ((signal.SIGKILL, "rank"), (signal.SIGTERM, "mpirun"),
                         (signal.SIGINT, "mpirun")):
        run, ranks = start_kept(3, *long_run)
        os.kill(ranks[1] if name == "rank" else run.pid, victim)
        began = time.time()
        try:
            run.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            run.kill()
            check(False, f"{victim} to {name}: it went on")
        print(f"{victim.name} to {name}: ended after {time.time() - began:.1f} s", flush=True)
        ended_by(victim, run)
        discard_kept()


def soak(problems):
    for k in range(problems):
        random.seed(k)
        dimension = random.randrange(1, 9)
        sites = int(10 ** random.uniform(0, 3.3))
        per_site = random.randrange(2, 1500 if sites < 500 else 500)
        ranks = [random.randrange(1, 8)]
        threads = (random.randrange(1, 4),)
        sample = ["--dim", str(dimension), "--sites", str(sites), "--points-per-site", str(per_site),
                  "--seed", str(k), *random.choice(([], ["--periodic"])),
                  random.choice(("--float", "--double")),
                  "--distribution", random.choice(("white", "jittered", "square", "hexagonal")),
                  *random.choice(([], ["--until", "stable"], ["--max-iterations", "7"]))]
        print(f"{k}: {ranks[0]} ranks of {threads[0]} threads:", *sample, flush=True)
        compare(["sample"], ALL, sample, ranks, threads)
        points = sites * per_site
        cells = random.randrange(max(1, points // 500), points + 1) if points < 20000 else sites
        cuts = sorted(random.sample(range(1, points), cells - 1))
        sizes = [b - a for a, b in zip([0, *cuts], [*cuts, points])]
        pathlib.Path("capacities.csv").write_text("\n".join(map(str, sizes)))
        compare(["tessellate"], ALL[:2], ["alone-points.npy", "--sites", str(cells), "--capacities",
                                          "capacities.csv"], ranks, threads)


PARTS = {part.__name__: part for part in (bits, volumes, codebooks, faults, checkpoints, volume_faults,
                                          codebook_faults, kills)}
if given.soak > 0:
    soak(given.soak)
else:
    for name in given.parts.split(",") if given.parts else PARTS:
        began = time.monotonic()
        PARTS[name]()
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
print("passed" if failures == 0 else f"{failures} failed")
sys.exit(failures > 0)
