#!/bin/bash
# Runs the tests, and those of HDF5, with recorder.cpp: RECORD gets the text of all that is thrown.
# usage: record.sh BUILD RECORD     (needs python3-h5py)
set -euo pipefail
build=$(cd "$1" && pwd)
record=$2
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)  # a path without blanks, as LD_PRELOAD wants
trap 'rm -r "$work"' EXIT
library=$work/error_recorder.so
"${CXX:-c++}" -std=c++20 -O1 -shared -fPIC "$here/recorder.cpp" -o "$library"
: > "$record"
CCVT_ERROR_RECORD=$(realpath "$record")
export CCVT_ERROR_RECORD
# Those of children want a process without threads: one of their own.
LD_PRELOAD=$library "$build/tests/ccvt_tests" --minimal --test-case-exclude="*child*"
LD_PRELOAD=$library /usr/bin/python3 "$here/../hdf5/load.py" "$build/bin/ccvt"
