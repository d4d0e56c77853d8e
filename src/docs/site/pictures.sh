#!/bin/bash
# Makes the pictures of the guides, with the program, from what the repository holds and inputs.py
# makes up. Takes some seconds.
# usage: pictures.sh PROGRAM OUT
set -euo pipefail
program=$(realpath "$1")
mkdir -p "$2"
out=$(cd "$2" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
root=$here/../../..
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

ccvt() { "$program" "$@" -q; }
draw() { python3 "$here/draw.py" "$@"; }
python3 "$here/inputs.py" .

# Blue noise: four runs of the program beside points at random, and the report on them.
for seed in 1 2 3 4; do
  ccvt sample --dim 2 --sites 1024 --periodic --seed $seed -o run$seed.csv
  python3 -c "import random; r = random.Random($seed); print('\n'.join(f'{r.random()},{r.random()}' for _ in range(1024)))" >white$seed.csv
done
ccvt analyze run?.csv --periodic --compare white=white1.csv white2.csv white3.csv white4.csv -o report
draw sites "$out/blue_noise.svg" run1.csv white1.csv
for picture in radial.svg anisotropy.svg pair_correlation.svg power_law.svg spectrum.png; do
  cp "report/$picture" "$out/report_$picture"
done
mkdir -p "$out/report" && cp report/* "$out/report/"

# Stippling.
photo=$root/tests/data/camera.png
ccvt stipple "$photo" --sites 8000 -o "$out/stipple_plain.png"
ccvt stipple "$photo" --sites 8000 --gamma 2 -o "$out/stipple_gamma.png"
ccvt stipple "$photo" --sites 8000 --invert --dot-radius 1.6 -o "$out/stipple_invert.png"

# Volumes and surfaces.
ccvt volume head.npy --spacing 1,1,1 --sites 6000 -o samples.ply --preview "$out/volume_preview.png"
python3 "$root/benchmarks/figures/trefoil.py" knot.obj
ccvt surface knot.obj --sites 3000 -o samples.ply --preview "$out/surface_preview.png"

# Thinning: the points as they are seen from above.
ccvt thin scan.ply --sites 1500 -o thin.csv --indices-out chosen.csv
python3 -c "
import random
rows = [line.split()[:2] for line in open('scan.ply').read().split('end_header\n')[1].splitlines()]
chosen = [rows[int(line)] for line in open('chosen.csv')]
for name, some in (('thinned', chosen), ('random', random.Random(2).sample(rows, 1500))):
    open(name + '.csv', 'w').write('\n'.join(','.join(row) for row in some) + '\n')"
draw sites "$out/thinned.svg" random.csv thinned.csv

# Particles.
ccvt sample --dim 3 --sites 4096 --periodic -o glass.csv
ccvt analyze glass.csv --periodic -o load
cp load/power_law.svg "$out/particles_power_law.svg"

# Codebooks: a photograph of 256 different blocks.
ccvt quantize "$photo" --image-blocks 4 --codewords 256 -o codebook.npy --image-out "$out/decoded.png"

# The method. A swap between two sites that stay; random owners, and what iterations make of them.
printf '.32,.5\n.68,.5\n' >two.csv
ccvt sample --dim 2 --sites 2 --points-per-site 512 --distribution square --points-out grid.csv -o s.csv
for made in 0 1; do
  ccvt tessellate grid.csv --sites 2 --fixed-sites two.csv --preset balzer2009 --max-iterations $made -o s.csv --owners-out swap$made.csv
done
draw cells "$out/method_swap.png" 32 swap0.csv swap1.csv
ccvt sample --dim 2 --sites 64 --points-per-site 256 --distribution square --points-out points.csv -o s.csv
for made in 0 1 4 100000; do
  ccvt tessellate points.csv --sites 64 --box 0 0 1 1 --preset balzer2009 --max-iterations $made -o s.csv --owners-out random$made.csv
done
draw cells "$out/method_random.png" 128 random0.csv random1.csv random4.csv random100000.csv
for points in 16 64 256; do
  ccvt sample --dim 2 --sites 64 --points-per-site $points --distribution square --seed 3 -o level.csv --owners-out level$points.csv
done
draw cells "$out/method_levels_16.png" 32 level16.csv
draw cells "$out/method_levels_64.png" 64 level64.csv
draw cells "$out/method_levels_256.png" 128 level256.csv
ccvt tessellate points.csv --sites 64 --box 0 0 1 1 -o sites.csv --owners-out owners.csv
draw circles "$out/method_pairs.svg" sites.csv points.csv owners.csv
for made in $(seq 0 2 60); do
  for preset in default one-level random; do
    ccvt tessellate points.csv --sites 64 --box 0 0 1 1 --preset $preset --max-iterations "$made" -o s.csv --summary "$preset$made.json"
  done
done
list() { seq -s, -f "$1%g.json" 0 2 60; }
draw energies "$out/method_energies.svg" \
  "random start, one level=$(list random)" "balanced start, one level=$(list one-level)" \
  "default: balanced start, levels=$(list default)"
for end in stable blue-noise; do
  ccvt sample --dim 2 --sites 400 --points-per-site 4096 --periodic --until $end -o $end.csv
done
draw sites "$out/method_ends.svg" stable.csv blue-noise.csv
