#!/usr/bin/python3
"""Particle loads of ccvt in HDF5, read by h5py: load.py PROGRAM

Writes loads with PROGRAM (ccvt) in a directory of its own, and checks what GADGET-4, SWIFT and
AREPO look for in them; then reads files that are no such loads. Needs python3-h5py.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy

SITES, REPEAT, BOX, DENSITY, REDSHIFT = 100, 3, 0.7, 8.5, 49
COUNT = SITES * REPEAT ** 3


def check(condition, message):
    if not condition:
        sys.exit("load.py: " + message)


def sample(program, directory, *arguments):
    subprocess.run(
        [program, "sample", "--dim", "3", "--sites", str(SITES), "--points-per-site", "64",
         "--periodic", "--quiet", *arguments], cwd=directory, check=True)


def check_header(header, kind):
    """Types and values: readers take them as they are, whatever they expect."""
    counts = [COUNT if t == kind else 0 for t in range(6)]
    mass = DENSITY * BOX ** 3 / COUNT
    for name in ("NumPart_ThisFile", "NumPart_Total"):
        check(header[name].dtype == numpy.uint32 and list(header[name]) == counts, name)
    check(list(header["NumPart_Total_HighWord"]) == [0] * 6, "NumPart_Total_HighWord")
    check(numpy.allclose(header["MassTable"], [mass if t == kind else 0 for t in range(6)],
                         rtol=1e-14), "MassTable")
    for name, value in {"NumFilesPerSnapshot": 1, "Dimension": 3, "Flag_Entropy_ICs": 0,
                        "Flag_DoublePrecision": 1, "Flag_Sfr": 0, "Flag_Cooling": 0,
                        "Flag_Feedback": 0, "Flag_StellarAge": 0, "Flag_Metals": 0}.items():
        check(header[name].dtype == numpy.int32 and header[name] == value, name)
    for name, value in {"BoxSize": BOX, "Time": 1 / (1 + REDSHIFT), "Redshift": REDSHIFT,
                        "Omega0": 0, "OmegaBaryon": 0, "OmegaLambda": 0, "HubbleParam": 1}.items():
        check(header[name].dtype == numpy.float64 and header[name] == value, name)
    return mass


def check_load(path, kind, sites):
    with h5py.File(path) as file:
        mass = check_header(file["Header"].attrs, kind)
        check(file["RuntimePars"].attrs["PeriodicBoundariesOn"] == 1, "PeriodicBoundariesOn")
        group = file[f"PartType{kind}"]
        check([t for t in range(6) if f"PartType{t}" in file] == [kind], "groups of other types")
        names = {"Coordinates", "Velocities", "Masses", "ParticleIDs"}
        if kind == 0:
            names |= {"SmoothingLength", "InternalEnergy"}
        check(set(group) == names, f"datasets {set(group)}")
        xyz = group["Coordinates"][...]
        check(xyz.dtype == numpy.float64 and xyz.shape == (COUNT, 3), "Coordinates")
        check(xyz.min() >= 0 and xyz.max() < BOX, "Coordinates outside the box")
        steps = numpy.arange(REPEAT)
        corners = [(i, j, k) for k in steps for j in steps for i in steps]
        expected = (sites + numpy.array(corners)[:, None, :]).reshape(-1, 3) * (BOX / REPEAT)
        check(numpy.abs(xyz - expected).max() < 1e-15, "Coordinates are not the tiles")
        check((group["ParticleIDs"][...] == numpy.arange(1, COUNT + 1)).all(), "ParticleIDs")
        check(group["Velocities"].shape == (COUNT, 3) and not group["Velocities"][...].any(),
              "Velocities")
        check(group["Masses"].shape == (COUNT,) and (group["Masses"][...] == mass).all(), "Masses")
        if kind == 0:
            check(not group["InternalEnergy"][...].any(), "InternalEnergy")
            check(numpy.allclose(group["SmoothingLength"][...], 1.2348 * BOX / COUNT ** (1 / 3)),
                  "SmoothingLength")


def check_refusals(program, directory):
    """Each file lacks one thing."""
    xyz = numpy.zeros((4, 3), numpy.float32)
    name = "PartType1/Coordinates"
    changes = {
        "has no group 'Header'": lambda file: file.__delitem__("Header"),
        "is one of several files; only all particles in one are supported":
            lambda file: file["Header"].attrs.__setitem__("NumFilesPerSnapshot", 2),
        "has no dataset 'PartType*/Coordinates' with particles":
            lambda file: file.__delitem__(name),
        f"'{name}' is no dataset":
            lambda file: (file.__delitem__(name), file.create_group(name)),
        f"'{name}' is not of shape (#particles, 3)":
            lambda file: (file.__delitem__(name), file.create_dataset(name, data=xyz[:, :2])),
        f"'{name}' holds no real numbers":
            lambda file: (file.__delitem__(name), file.create_dataset(name, data=xyz.astype(int))),
        f"'{name}' has a shape, but no values were ever written":
            lambda file: (file.__delitem__(name),
                          file.create_dataset(name, (2 ** 30, 3), numpy.float32)),
        f"has {2 ** 40} particles in '{name}' and 4 before; at most 2147483647 are supported":
            lambda file: (file.move(name, "PartType0/Coordinates"),
                          file.create_dataset(name, (2 ** 40, 3), numpy.float32, chunks=(1024, 3))
                              .__setitem__(slice(10), 1)),
        # A filter that h5py brings along.
        "its coordinates cannot be read: it is damaged or truncated":
            lambda file: (file.__delitem__(name),
                          file.create_dataset(name, data=xyz, compression="lzf")),
    }
    for message, change in changes.items():
        with h5py.File(directory / "bad.hdf5", "w") as file:
            file.create_group("Header").attrs["NumFilesPerSnapshot"] = 1
            file.create_dataset(name, data=xyz)
            change(file)
        run = subprocess.run([program, "tessellate", "bad.hdf5", "--sites", "2", "-o", "s.npy"],
                             cwd=directory, capture_output=True, text=True)
        check(run.returncode == 2 and run.stderr == f"ccvt: error: bad.hdf5: {message}\n",
              f"{message}: {run.returncode} {run.stderr}")
    return len(changes)


def check_virtual(program, directory):
    """Coordinates that are in another file."""
    name = "PartType1/Coordinates"
    with h5py.File(directory / "there.hdf5", "w") as file:
        file.create_dataset(name, data=numpy.random.default_rng(1).random((50, 3)))
    layout = h5py.VirtualLayout((50, 3), float)
    layout[:] = h5py.VirtualSource(str(directory / "there.hdf5"), name, (50, 3))
    with h5py.File(directory / "virtual.hdf5", "w") as file:
        file.create_group("Header").attrs["NumFilesPerSnapshot"] = 1
        file.create_virtual_dataset(name, layout)
    subprocess.run([program, "tessellate", "virtual.hdf5", "--sites", "50", "-q", "-o", "v.npy"],
                   cwd=directory, check=True)
    with h5py.File(directory / "there.hdf5") as file:
        check(set(map(tuple, numpy.load(directory / "v.npy"))) == set(map(tuple, file[name][...])),
              "a virtual dataset")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    program = Path(sys.argv[1]).resolve()
    options = ["--repeat", str(REPEAT), "--box-size", str(BOX), "--density", str(DENSITY),
               "--redshift", str(REDSHIFT), "--double"]
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        sample(program, directory, "--double", "-o", "sites.npy")
        sites = numpy.load(directory / "sites.npy")
        sample(program, directory, *options, "-o", "matter.hdf5")
        check_load(directory / "matter.hdf5", 1, sites)
        sample(program, directory, *options, "--gas", "-o", "gas.hdf5")
        check_load(directory / "gas.hdf5", 0, sites)
        refused = check_refusals(program, directory)
        check_virtual(program, directory)
    print(f"{COUNT} particles, dark matter and gas: as documented; {refused} files refused")


if __name__ == "__main__":
    main()
