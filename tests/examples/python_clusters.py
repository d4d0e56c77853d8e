# Districts of equal size: 3000 addresses in and around three towns, 12 carriers.
#   python3 python_clusters.py FOLDER
# %%
import pathlib
import sys

import numpy as np

import ccvt

folder = pathlib.Path(sys.argv[1])  # in a notebook: where the results are to go
folder.mkdir(parents=True, exist_ok=True)


def addresses(count, seed):
    random = np.random.default_rng(seed)
    towns = np.array([[2.0, 2.0], [7.0, 3.0], [4.0, 8.0]])
    town = random.choice(3, count, p=[0.6, 0.3, 0.1])
    return towns[town] + random.normal(size=(count, 2))


# %% As with scikit-learn's KMeans, but every district has 250 addresses. The gap is the proof that no
# other way to give each carrier 250 of them has a smaller inertia for these centres.
known = addresses(3000, seed=1)
model = ccvt.BalancedKMeans(12, random_state=0).fit(known)
print("addresses a district:", np.unique(np.bincount(model.labels_)))
print(f"gap {model.gap_:.1e}")

# %% Plain k-means has nearer centres, and districts of very different size.
plain = ccvt.BalancedKMeans(12, random_state=0, method="lloyd").fit(known)
sizes = np.bincount(plain.labels_)
print(f"plain k-means: {sizes.min()} to {sizes.max()}, inertia {plain.inertia_ / model.inertia_:.2f} of it")

# %% New addresses go where weights, which come with the districts, keep these about equally full.
new = addresses(3000, seed=2)
print("new ones a district:", np.sort(np.bincount(model.predict(new))))

# %% Two carriers have less time.
shifts = ccvt.BalancedKMeans(12, random_state=0, capacities=[270] * 10 + [150] * 2).fit(known)
print("with two short shifts:", np.bincount(shifts.labels_))

# %% A picture: an address a square of 3 x 3 pixels, a district a colour.
picture = np.full((500, 500, 3), 255, dtype=np.uint8)
colours = np.random.default_rng(6).integers(0, 220, (12, 3), dtype=np.uint8)
place = np.clip(((known + 2) * 40).astype(int), 1, 498)
for dx in (-1, 0, 1):
    for dy in (-1, 0, 1):
        picture[499 - place[:, 1] + dy, place[:, 0] + dx] = colours[model.labels_]
ccvt.write_png(folder / "districts.png", picture)
