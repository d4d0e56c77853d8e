#!/usr/bin/python3
"""Runs the commands of the guides: each document's, in their order, in a folder of its own.

Run are the lines of ```sh blocks that begin with `ccvt`, and those that prepare files for them (cat,
seq, awk, printf), with inputs of inputs.py, the mesh and the photograph of the repository under the
names that the guides use. Numbers of sites above 3000 are lowered to that; the scan of a Debian
package that need not be here is replaced by a made one.

usage: commands.py PROGRAM DOCUMENT...
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
RUN = re.compile(r"(ccvt|cat|seq|awk|printf) ")
SCAN = "/usr/share/mricron/templates/ch2bet.nii.gz"


WITHOUT = {"architecture", "contributing", "cplusplus", "python", "reference"}  # no commands


def commands(text):
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, flags=re.M | re.S)
    return [line for block in blocks for line in block.splitlines() if RUN.match(line)]


def lowered(command):
    fewer = re.sub(r"--sites (\d+)", lambda m: f"--sites {min(3000, int(m.group(1)))}", command)
    return fewer.replace(SCAN, "head.nii.gz")


def prepare(folder):
    here = pathlib.Path(__file__).parent
    subprocess.run([sys.executable, here / "inputs.py", folder], check=True)
    subprocess.run([sys.executable, ROOT / "benchmarks/figures/trefoil.py", folder / "knot.obj"], check=True)
    for name in ("photo.jpg", "photo.png"):
        shutil.copy(ROOT / "tests/data/camera.png", folder / name)


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    ran = failed = 0
    with tempfile.TemporaryDirectory() as made:
        made = pathlib.Path(made)
        (made / "bin").mkdir()
        (made / "bin/ccvt").symlink_to(program)
        prepare_in = made / "inputs"
        prepare_in.mkdir()
        prepare(prepare_in)
        paths = {**os.environ, "PATH": f"{made / 'bin'}:{os.environ['PATH']}"}
        for document in map(pathlib.Path, sys.argv[2:]):
            work = made / document.stem
            shutil.copytree(prepare_in, work)
            wanted = commands(document.read_text())
            if bool(wanted) == (document.stem in WITHOUT):
                failed += 1
                print(f"{document}: has {len(wanted)} commands to run")
            for command in wanted:
                ran += 1
                done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", lowered(command)], cwd=work, env=paths,
                                      stdin=subprocess.DEVNULL, capture_output=True, text=True)  # fmt: skip
                if done.returncode != 0:
                    failed += 1
                    print(f"{document}: {command}\n  exits with {done.returncode}: {done.stderr.strip()}")
            shutil.rmtree(work)
    print(f"commands: {ran} run, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
