#!/usr/bin/python3
"""Kills runs that are kept at random moments; each must go on to the bits of one that was left alone.

usage: kills.py PROGRAM [KILLS [SEED]]
"""
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


def write_inputs(folder, chance):
    points, sites = 30000, 300
    lines = [f"{chance.random()} {chance.random()}" for _ in range(points)]
    (folder / "points.csv").write_text("\n".join(lines) + "\n")
    sizes = [points // sites + (s % 7 - 3) * (s < 294) for s in range(sites)]
    (folder / "capacities.csv").write_text("\n".join(map(str, sizes)) + "\n")
    (folder / "masses.csv").write_text("\n".join(str(1 + chance.random()) for _ in range(points)) + "\n")
    (folder / "volume.raw").write_bytes(bytes(chance.randrange(256) for _ in range(16 ** 3)))


class Runs:
    """A command in a folder."""

    def __init__(self, program, folder, line):
        self.program, self.folder, self.line = program, folder, line

    def arguments(self, out, threads):
        return [self.program, *self.line.replace("OUT", out).split(), "--threads", str(threads), "-q"]

    def whole(self, out, threads, *more):
        subprocess.run([*self.arguments(out, threads), *more], cwd=self.folder, check=True)

    def killed(self, delay, threads):
        """Whether a process was killed so long after its start, before its end."""
        process = subprocess.Popen([*self.arguments("killed", threads), *EVERY], cwd=self.folder)
        time.sleep(delay)
        process.kill()
        status = process.wait()
        if status not in (0, -signal.SIGKILL):
            sys.exit(f"{self.line}: status {status}")
        return status != 0

    def outputs(self, out):
        return {file.name[len(out):]: file.read_bytes() for file in self.folder.glob(f"{out}.*")}


def check(runs, kills, chance):
    """After each kill a copy of what is kept goes on to the end, and the next one is killed again."""
    runs.whole("expected", 1)
    expected = runs.outputs("expected")
    start = time.monotonic()
    runs.whole("kept", 1, *EVERY)
    duration = time.monotonic() - start
    if runs.outputs("kept") != expected:
        sys.exit(f"{runs.line}: checkpoints change the result")
    done, resumed = 0, 0
    kept = runs.folder / "run"
    while done < kills:
        if not runs.killed(duration * chance.random(), 1 + done % 3):
            continue  # ran to its end: the next one begins anew
        done += 1
        copy = runs.folder / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        if kept.exists():
            shutil.copytree(kept, copy)
        resumed += (copy / "ccvt.checkpoint").exists()
        runs.whole("resumed", 1 + (done + 1) % 3, "--checkpoint", "copy")
        if runs.outputs("resumed") != expected:
            sys.exit(f"{runs.line}: kill {done}: another result")
        if any(copy.iterdir()):
            sys.exit(f"{runs.line}: kill {done}: {list(copy.iterdir())} left")
    return resumed


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    kills = int(sys.argv[2]) if len(sys.argv) > 2 else 30
    chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    for name, line in COMMANDS.items():
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            write_inputs(folder, chance)
            resumed = check(Runs(program, folder, line), kills, chance)
            print(f"{name}: {kills} kills, {resumed} after a first checkpoint: the same bits", flush=True)


main()
