#!/bin/sh
# From a fresh clone to tested: installs the packages that are missing, builds, runs all tests.
set -eu
cd "$(dirname "$0")/.."

cmake/install-packages.sh

echo "== Building into build/release"
cmake --preset release
cmake --build --preset release

echo "== Testing"
ctest --preset release -j "$(nproc)"
