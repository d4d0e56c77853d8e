# Samples of an array of three dimensions, with a mask, in millimetres, and what their weights are for.
#   python3 python_volume.py FOLDER
# %%
import pathlib
import sys

import numpy as np

import ccvt

folder = pathlib.Path(sys.argv[1])  # in a notebook: where the results are to go
folder.mkdir(parents=True, exist_ok=True)

# %% Two bright lumps in a block of 60 x 60 x 30 cells of 1 x 1 x 2 mm. A scan would be
# array, affine = ccvt.read_volume("head.nii.gz").
affine = np.diag([1.0, 1.0, 2.0, 1.0])
affine[:3, 3] = [-29.5, -29.5, -29]
x, y, z = np.einsum("ij,jabc->iabc", affine[:3, :3], np.indices((60, 60, 30))) + affine[:3, 3, None, None, None]
array = np.exp(-((x - 8) ** 2 + y**2 + z**2) / 60) + np.exp(-((x + 12) ** 2 + y**2 + z**2) / 120)
mask = np.hypot(x, y) < 28

# %% Samples are as dense as the array is bright, and none lies outside the mask.
samples = ccvt.sample_volume(array, 3000, affine, mask=mask, seed=1)
print(samples)
ccvt.write_samples(folder / "lumps.ply", samples)  # x, y, z, radius, capacity, weight

# %% The sum of weight * f(site) estimates the integral of density * f: here the mass and its centre.
mass = samples.weights.sum()
centre = samples.weights @ samples.sites / mass
print("mass", mass, "centre", centre)
cells = np.where(mask, array, 0) * 2  # cubic millimetres a cell
print("mass", cells.sum(), "x of the centre", (cells * x).sum() / cells.sum(), "cell by cell")

# %% A slab of the samples over the middle of the array, eight pixels a millimetre.
near = samples.sites[np.abs(samples.sites[:, 2]) < 2, :2]
dots = ccvt.Stippling(8 * (near + 30), 480, 480, 3.0, samples.summary)
shade = 1 - 0.6 * np.kron(array[:, ::-1, 15].T / array.max(), np.ones((8, 8)))
ccvt.write_png(folder / "slab.png", np.minimum(shade, ccvt.render(dots, scale=1)[::-1]))
