#!/bin/sh
# From a fresh clone to a picture: installs the packages that are missing, builds the program, and
# stipples a photograph with 20,000 dots. Pictures go to the folder named as argument (default: .).
set -eu
mkdir -p "${1:-.}"
out=$(cd "${1:-.}" && pwd)
cd "$(dirname "$0")/.."

cmake/install-packages.sh

echo "== Building into build/release"
cmake --preset release
cmake --build --preset release --target ccvt_cli

echo "== Stippling tests/data/camera.png with 20,000 dots"
for picture in "$out/stipple.png" "$out/stipple.svg"; do
  build/release/bin/ccvt stipple tests/data/camera.png --sites 20000 -o "$picture"
done
echo "The picture is in $out/stipple.png, and for printing in $out/stipple.svg."
