# Ten lines to start with: 25,600 random points become 100 cells of 256 points each.
#   python3 python_start.py FOLDER
# %%
import pathlib
import sys

import numpy as np

import ccvt

folder = pathlib.Path(sys.argv[1])  # in a notebook: where the results are to go

# %% Points are the rows of an array; the owner of each is the number of a site.
points = np.random.default_rng(1).random((25_600, 2))
result = ccvt.tessellate(points, 100, seed=7)
print(result.summary.brief)  # print(result.summary) says all
print("points a site:", np.unique(np.bincount(result.owners)))

# %% The same from the command line: ccvt tessellate points.npy --sites 100 --seed 7 -o sites.npy
folder.mkdir(parents=True, exist_ok=True)
ccvt.write_points(folder / "sites.npy", result.sites)
ccvt.write_owners(folder / "owners.npy", result.owners)
