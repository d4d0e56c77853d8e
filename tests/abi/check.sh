#!/bin/bash
# Compares the binary interface of a shared ccvt, compiled with -g, with the one in libccvt.abi.gz,
# which was made with Debian 12's g++ and abigail-tools.
#   check.sh LIBRARY HEADERS_DIR            fails where they differ, but for added functions
#   check.sh --update LIBRARY HEADERS_DIR   writes a new libccvt.abi.gz
# HEADERS_DIR is where the public headers lie: types that they do not define are not compared.
set -euo pipefail
[ $# -ge 2 ] || { sed -n 's/^# \{0,1\}//;2,6p' "$0"; exit 2; }
update=
if [ "$1" = --update ]; then
  update=yes
  shift
fi
library=$(realpath "$1")
headers=$2
own=$(dirname "$0")
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

fail() {
  echo "$*" >&2
  exit 1
}

how_to_update() {
  cat <<END
After a compatible change (functions were added), or a step of the version that gave the library a
new SONAME, or as long as no release has had this SONAME, make the baseline anew, and commit it:
  tests/abi/check.sh --update $library $headers
END
}

# libccvt.so.MAJOR.MINOR, as long as a minor version may break programs (see src/CMakeLists.txt).
soname=$(readelf --dynamic "$library" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')
[[ $soname =~ ^libccvt\.so\.[0-9]+\.[0-9]+$ ]] ||
  fail "$library has the SONAME \"$soname\", not libccvt.so.MAJOR.MINOR"
sections=$(readelf --sections "$library")
[[ $sections == *.debug_info* ]] ||
  fail "$library is without debug information: compile it with -g"

abidw --exported-interfaces-only --headers-dir "$headers" --drop-private-types \
  --suppressions "$own/foreign.suppr" --no-show-locs --no-corpus-path --no-comp-dir-path \
  --no-parameter-names --no-elf-needed --type-id-style hash --out-file "$work/raw" "$library"
sed "s| path='[^']*/src/| path='src/|" "$work/raw" >"$work/now.abi"  # wherever it was compiled
functions=$(grep -c '<function-decl ' "$work/now.abi") || true
[ "$functions" -ge 100 ] || fail "abidw finds $functions functions only: is this the library?"

if [ -n "$update" ]; then
  gzip -9n <"$work/now.abi" >"$own/libccvt.abi.gz"
  echo "$own/libccvt.abi.gz holds the interface of $soname"
  exit 0
fi
gzip -dc "$own/libccvt.abi.gz" >"$work/before.abi"
architecture() { sed -n "1s/.* architecture='\([^']*\)'.*/\1/p" "$1"; }
[ "$(architecture "$work/before.abi")" = "$(architecture "$work/now.abi")" ] ||
  fail "The baseline is of $(architecture "$work/before.abi"), the library of $(architecture "$work/now.abi")."
head -n 1 "$work/before.abi" | grep -qF "soname='$soname'" ||
  fail "$own/libccvt.abi.gz is not of $soname.
$(how_to_update)"

# abidiff's status: 4 and 8 are changes; 1, 2 and signals are failures of its own.
changes() {  # options
  local status=0
  abidiff "$@" "$work/before.abi" "$work/now.abi" >"$work/changes" || status=$?
  if [ $((status & 3)) -ne 0 ] || [ "$status" -ge 128 ]; then
    fail "abidiff failed with status $status"
  fi
  [ "$status" -ne 0 ]
}

# All but added functions fails: abidiff itself counts a changed size of a structure as harmless.
if changes --no-added-syms; then
  cat "$work/changes"
  fail "The binary interface of $soname has changed: programs that were linked with it may break.
It needs a new SONAME, which is a step of the minor version in CMakeLists.txt.
$(how_to_update)"
fi
if changes; then
  cat "$work/changes"
  echo "The baseline does not know these functions yet."
  how_to_update
fi
echo "$soname keeps its binary interface: $functions functions"
