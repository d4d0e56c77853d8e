#!/usr/bin/python3
"""The session of src/python/README.md, as a new user would type it, with its pictures.

    session.py DIGITS FOLDER

DIGITS: an .npy file of 28 x 28 pictures, such as MNIST's, one a row; "-": pictures made up here. FOLDER: where
the pictures go.
"""

import pathlib
import sys

import numpy as np

import ccvt

HERE = pathlib.Path(__file__).resolve().parent
BRAIN = pathlib.Path("/usr/share/mricron/templates/ch2bet.nii.gz")


def made_up_digits(count=1000):
    """Strokes at random places: what a user without MNIST can try with."""
    random = np.random.default_rng(1)
    y, x = np.mgrid[:28, :28]
    centre = random.uniform(8, 20, (count, 2, 1, 1))
    angle = random.uniform(0, np.pi, (count, 1, 1))
    along = (x - centre[:, 0]) * np.cos(angle) + (y - centre[:, 1]) * np.sin(angle)
    across = (y - centre[:, 1]) * np.cos(angle) - (x - centre[:, 0]) * np.sin(angle)
    return (255 * np.exp(-((across / 2) ** 2) - (along / 8) ** 4)).reshape(count, 784)


def made_up_scan():
    """An ellipsoid with a dense core, for machines without the brain scan."""
    z, y, x = (axis / 20 - 1 for axis in np.mgrid[:41, :41, :41])
    radius = np.sqrt(x**2 + (1.2 * y) ** 2 + (1.5 * z) ** 2)
    affine = np.diag([2.0, 2.0, 2.0, 1.0])
    affine[:3, 3] = -40
    return np.clip(1 - radius, 0, 1), affine


def cluster(digits, folder):
    model = ccvt.BalancedKMeans(64, random_state=0).fit(digits)
    sizes = np.unique(np.bincount(model.labels_))
    plain = ccvt.BalancedKMeans(64, random_state=0, method="lloyd").fit(digits)
    print(f"clusters of {sizes} pictures, gap {model.gap_:.1e}, in {model.n_iter_} iterations")
    print(f"inertia {model.inertia_ / plain.inertia_:.4f} of plain k-means, whose clusters have "
          f"{np.bincount(plain.labels_).min()} to {np.bincount(plain.labels_).max()}")  # fmt: skip
    assert sizes[-1] - sizes[0] <= 1
    mosaic = model.cluster_centers_.reshape(8, 8, 28, 28).swapaxes(1, 2).reshape(224, 224)
    ccvt.write_png(folder / "mosaic.png", mosaic / 255)


def sample_scan(folder):
    scan, affine = ccvt.read_volume(BRAIN) if BRAIN.exists() else made_up_scan()
    samples = ccvt.sample_volume(scan, 20_000, affine, seed=1)
    print(f"scan of {scan.shape}: {samples.summary.brief}")
    ccvt.write_samples(folder / "brain.ply", samples)
    slab = samples.sites[np.abs(samples.sites[:, 2]) < 4]
    low, high = samples.sites.min(axis=0), samples.sites.max(axis=0)
    size = np.ceil(6 * (high - low)[:2]).astype(int)
    place = 6 * (slab - low)[:, :2]
    dots = ccvt.Stippling(place, size[0] + 1, size[1] + 1, 3.0, samples.summary)
    ccvt.write_png(folder / "slab.png", ccvt.render(dots, scale=1)[::-1])


def stipple_photo(folder):
    picture = ccvt.stipple(HERE.parent / "data" / "camera.png", 20_000, seed=1)
    print(picture)
    ccvt.write_png(folder / "dots.png", ccvt.render(picture))
    ccvt.write_svg(folder / "dots.svg", picture)


def blue_noise():
    sites = ccvt.sample(1024, 2, periodic=True, seed=1).sites
    found = ccvt.analyze(sites, periodic=True)
    print(f"smallest distance {found.smallest_distance:.3f} of the hexagonal lattice's, "
          f"low-frequency power {found.spectrum.low_frequency_power:.5f}")  # fmt: skip
    assert found.smallest_distance > 0.65 and found.spectrum.low_frequency_power < 0.001


def main():
    digits, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    vectors = made_up_digits() if digits == "-" else np.load(digits).reshape(-1, 784)
    cluster(vectors.astype(np.float32), folder)
    sample_scan(folder)
    stipple_photo(folder)
    blue_noise()


if __name__ == "__main__":
    main()
