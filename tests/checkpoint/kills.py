#!/usr/bin/python3
"""Kills runs that are kept at random moments; each must go on to the bits of one that was left alone.

usage: kills.py PROGRAM [KILLS [SEED]] [--mpi CCVT_MPI MPIRUN]

With --mpi runs are of several processes: one of them is killed, mpirun, or all; another number of
them, or PROGRAM, goes on.
"""
import argparse
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PICTURE = pathlib.Path(__file__).resolve().parents[1] / "data/camera.png"
EVERY = ("--checkpoint", "run", "--checkpoint-every", "0")
MOST_SECONDS = 60  # in which all processes end when one is killed; they take one or two
# Open MPI asks these of root; and wants to hear that there are more ranks than processors.
MPI_ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}

COMMANDS = {
    "sample, pairs": "sample --dim 3 --sites 3000 --points-per-site 100 --periodic -o OUT.npy",
    "sample, descent": "sample --dim 2 --sites 1000 --points-per-site 600 --until stable --double -o OUT.npy",
    "sample, blue noise": "sample --dim 2 --sites 500 --points-per-site 2100 -o OUT.npy",
    "tessellate": "tessellate points.csv --capacities capacities.csv --sites 300 -o OUT.csv "
                  "--owners-out OUT.owners.csv",
    "tessellate, cached": "tessellate points.csv --sites 300 --preset fast-ccvt -o OUT.csv",
    "masses": "tessellate points.csv --masses masses.csv --sites 300 -o OUT.csv --owners-out OUT.owners.csv",
    "volume": "volume volume.raw --shape 16,16,16 --type uint8 --sites 1500 -o OUT.npy",
    "stipple": f"stipple {PICTURE} --sites 2000 -o OUT.svg",
}
COMMANDS_OF_RANKS = {
    "sample by ranks": "sample --dim 3 --sites 4000 --points-per-site 100 --periodic -o OUT.npy "
                       "--owners-out OUT.owners.npy",
    "tessellate by ranks": "tessellate points.npy --capacities tenfold.csv --sites 300 -o OUT.npy "
                           "--owners-out OUT.owners.npy",
}


def write_inputs(program, folder, chance):
    points, sites = 30000, 300
    lines = [f"{chance.random()} {chance.random()}" for _ in range(points)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    sizes = [points // sites + (s % 7 - 3) * (s < 294) for s in range(sites)]
    (folder / "capacities.csv").write_text("\n".join(map(str, sizes)) + "\n")
    (folder / "tenfold.csv").write_text("\n".join(str(10 * size) for size in sizes) + "\n")
    (folder / "masses.csv").write_text("\n".join(str(1 + chance.random()) for _ in range(points)) + "\n")
    (folder / "volume.raw").write_bytes(bytes(chance.randrange(256) for _ in range(16 ** 3)))
    subprocess.run([program, "sample", "--dim", "2", "--sites", "300", "--points-per-site", "1000", "-q",
                    "--distribution", "white", "-o", "drawn.npy", "--points-out", "points.npy"],
                   cwd=folder, check=True)


class Alone:
    """A process of one's own."""

    def __init__(self, program, threads):
        self.command = [program]
        self.threads = threads

    def start(self, arguments, folder):
        self.process = subprocess.Popen([*self.command, *arguments, "--threads", str(self.threads)],
                                        cwd=folder)
        return self.process

    def kill(self, _):
        self.process.kill()
        self.process.wait()


class Together:
    """Several processes of mpirun's: all of them have a mark."""
    slowest_end = 0
    victims = {}

    def __init__(self, program, mpirun, ranks, threads):
        self.command = [mpirun, "-n", str(ranks), program]
        self.program = program
        self.threads = threads

    def start(self, arguments, folder):
        self.checkpoint = folder / "run/ccvt.checkpoint"
        self.first = self.kept_at()
        self.mark = f"CCVT_KILLS={time.monotonic_ns()}"
        name, value = self.mark.split("=")
        # What killed processes leave goes with the folder.
        own = {name: value, "TMPDIR": str(folder), "OMPI_MCA_btl_vader_backing_directory": str(folder)}
        with (folder / "said").open("w") as said:
            self.process = subprocess.Popen(
                [*self.command, *arguments, "--threads", str(self.threads)], cwd=folder,
                env={**os.environ, **MPI_ENVIRONMENT, **own}, stderr=said)
        return self.process

    def marked(self):
        """The processes, and whether each is a rank."""
        found = {}
        for entry in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if self.mark.encode() in (entry / "environ").read_bytes().split(b"\0"):
                    found[int(entry.name)] = os.readlink(entry / "exe") == self.program
            except OSError:
                pass  # it has ended, or is another's
        return found

    def kept_at(self):
        return self.checkpoint.stat().st_mtime_ns if self.checkpoint.exists() else 0

    def kill(self, chance):
        ranks = sorted(number for number, is_rank in self.marked().items() if is_rank)
        if self.kept_at() == self.first:
            ranks = []  # Open MPI's mpirun waits for ever if one dies while it greets mpirun
        victim = chance.choice(["rank", "mpirun", "all"] if ranks else ["mpirun", "all"])
        for number in ([chance.choice(ranks)] if victim == "rank" else
                       [self.process.pid] if victim == "mpirun" else sorted(self.marked())):
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.victims[victim] = self.victims.get(victim, 0) + 1
        start = time.monotonic()
        while time.monotonic() - start < MOST_SECONDS:
            if self.process.poll() is not None and not self.marked():
                Together.slowest_end = max(self.slowest_end, time.monotonic() - start)
                return
            time.sleep(.02)
        sys.exit(f"{victim} was killed, and these went on: {self.marked()}")


class Runs:
    """A command in a folder."""

    def __init__(self, folder, line):
        self.folder, self.line = folder, line

    def arguments(self, out):
        return [*self.line.replace("OUT", out).split(), "-q"]

    def whole(self, way, out, *more):
        if way.start([*self.arguments(out), *more], self.folder).wait() != 0:
            self.fail(way)

    def killed(self, way, delay, chance):
        """Whether a process was killed so long after its start, before its end."""
        process = way.start([*self.arguments("killed"), *EVERY], self.folder)
        try:
            status = process.wait(timeout=delay)
        except subprocess.TimeoutExpired:
            way.kill(chance)
            return process.returncode != 0
        if status != 0:
            self.fail(way)
        return False

    def fail(self, way):
        said = self.folder / "said"
        sys.exit(f"{way.command} {self.line}: status {way.process.returncode}\n"
                 + (said.read_text() if said.exists() else ""))

    def outputs(self, out):
        return {file.name[len(out):]: file.read_bytes() for file in self.folder.glob(f"{out}.*")}


def check(runs, ways, kills, chance):
    """After each kill a copy of what is kept goes on to the end, and the next one is killed again.
    `ways`: of which each run takes one; the first is the program alone."""
    runs.whole(ways(0), "expected")
    expected = runs.outputs("expected")
    start = time.monotonic()
    runs.whole(ways(1), "kept", *EVERY)
    duration = time.monotonic() - start
    if runs.outputs("kept") != expected:
        sys.exit(f"{runs.line}: checkpoints change the result")
    done, resumed = 0, 0
    kept = runs.folder / "run"
    while done < kills:
        if not runs.killed(ways(1 + done), duration * chance.random(), chance):
            duration *= .9  # others may have slowed down the first one
            continue  # ran to its end: the next one begins anew
        done += 1
        for name, content in runs.outputs("killed").items():
            if content != expected[name]:
                sys.exit(f"{runs.line}: kill {done}: {name} is not whole")
        copy = runs.folder / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        if kept.exists():
            shutil.copytree(kept, copy)
        resumed += (copy / "ccvt.checkpoint").exists()
        runs.whole(ways(2 + done), "resumed", "--checkpoint", "copy")
        if runs.outputs("resumed") != expected:
            sys.exit(f"{runs.line}: kill {done}: another result")
        if any(copy.iterdir()):
            sys.exit(f"{runs.line}: kill {done}: {list(copy.iterdir())} left")
    return resumed


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("kills", type=int, nargs="?", default=30)
    parser.add_argument("seed", type=int, nargs="?", default=1)
    parser.add_argument("--mpi", nargs=2)
    given = parser.parse_args()
    program = str(given.program.resolve())
    chance = random.Random(given.seed)

    def ways(k):
        return Alone(program, 1 + k % 3)

    def ways_of_ranks(k):
        ranks = chance.randrange(5) if k > 1 else 2 * k
        if ranks == 0:
            return Alone(program, 1 + k % 3)
        return Together(str(pathlib.Path(given.mpi[0]).resolve()), given.mpi[1], ranks, 1 + k % 2)

    commands = COMMANDS_OF_RANKS if given.mpi else COMMANDS
    after_a_checkpoint = 0
    for name, line in commands.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            write_inputs(program, folder, chance)
            resumed = check(Runs(folder, line), ways_of_ranks if given.mpi else ways, given.kills, chance)
            after_a_checkpoint += resumed
            print(f"{name}: {given.kills} kills, {resumed} after a first checkpoint: the same bits",
                  flush=True)
    if after_a_checkpoint == 0:
        sys.exit("all were killed before their first checkpoint: nothing was shown")
    if given.mpi:
        print(f"victims: {Together.victims}; all had ended after {Together.slowest_end:.1f} s at most")


main()
