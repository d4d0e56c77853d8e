# A picture that is an array becomes 4000 equal dots; then the same cells watched while they relax.
#   python3 python_stipple.py FOLDER
# %%
import pathlib
import sys

import numpy as np

import ccvt

folder = pathlib.Path(sys.argv[1])  # in a notebook: where the pictures are to go
folder.mkdir(parents=True, exist_ok=True)

# %% A ball in the light from the upper left: 0 is black, 1 is white. A photograph would be
# ccvt.read_image("photo.jpg"), or just its name.
y, x = np.mgrid[-1:1:256j, -1:1:256j]
inside = np.maximum(0.81 - x**2 - y**2, 0)
light = (-0.5 * x - 0.5 * y + 0.7 * np.sqrt(inside)) / 0.9
image = np.where(inside > 0, np.clip(light, 0.05, 1), 0.6)

# %% Dots cover as much as the picture's ink would. SVG for print, PNG to look at.
dots = ccvt.stipple(image, 4000, seed=1)
print(dots)
ccvt.write_svg(folder / "ball.svg", dots)
ccvt.write_png(folder / "ball.png", ccvt.render(dots))

# %% gamma above 1 leaves more white, invert puts the dots where it is light, for white ink on black.
night = ccvt.stipple(image, 4000, seed=1, invert=True, gamma=1.5)
ccvt.write_png(folder / "night.png", 1 - ccvt.render(night))

# %% A step at a time: the solver is an iterator, and its sites are an array at any time.
points = np.random.default_rng(1).random((64_000, 2))
solver = ccvt.Solver(points, 250, seed=1)
for record in solver:
    if record.iteration in (1, 10) or record.progress == 1:
        print(f"iteration {record.iteration}: {record.points} points have joined, energy {record.energy:.2f}")
print(solver.summary.brief)
