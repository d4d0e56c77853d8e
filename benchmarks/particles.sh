#!/bin/sh
# The figures of src/docs/particles.md: ten loads of 16^3 sites x 1000 points for each kind of
# points under the cells, white noise and a grid beside them, and the picture of their spectra.
# usage: benchmarks/particles.sh PROGRAM DIR     (about two minutes; the picture needs librsvg2-bin)
set -eu
program=$(realpath "$1")
mkdir -p "$2"
cd "$2"

make() {  # name, seed, arguments
  name=$1 seed=$2
  shift 2
  [ -f "${name}_$seed.npy" ] ||
    "$program" sample --dim 3 --sites 4096 --periodic --seed "$seed" -q -o "${name}_$seed.npy" "$@"
}

seeds="1 2 3 4 5 6 7 8 9 10"
for seed in $seeds; do
  for kind in jittered white square hexagonal; do
    make $kind "$seed" --points-per-site 1000 --distribution $kind
  done
  make stable "$seed" --points-per-site 1000 --until stable
  # A point for each site, and no step taken: the points.
  make noise "$seed" --points-per-site 1 --distribution white --max-iterations 0
done
make grid 1 --points-per-site 1 --distribution square --max-iterations 0

runs() {  # name: its files
  for seed in $seeds; do printf '%s_%s.npy ' "$1" "$seed"; done
}
# shellcheck disable=SC2046  # one argument a file
"$program" analyze --periodic -o kinds --compare jittered=$(runs jittered) white=$(runs white) \
  square=$(runs square) hexagonal=$(runs hexagonal) jittered,stable=$(runs stable)
# shellcheck disable=SC2046
"$program" analyze --periodic -o picture --compare ccvt=$(runs jittered) \
  "ccvt, white points"=$(runs white) "random points"=$(runs noise) grid=grid_1.npy
if command -v rsvg-convert >/dev/null; then
  rsvg-convert -w 960 picture/power_law.svg -o picture/particles.png
fi
