#!/bin/sh
# From a fresh clone to Debian packages: installs what is missing, builds, and leaves the four
# packages in build/package/packages.
set -eu
cd "$(dirname "$0")/.."

cmake/install-packages.sh dpkg-dev file gzip pybind11-dev python3-dev

echo "== Building into build/package"
cmake --preset package
cmake --build --preset package
rm -rf build/package/packages  # of other versions
cpack --preset package
ls -l build/package/packages/*.deb
