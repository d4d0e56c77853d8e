#!/bin/bash
# Compares the binary interface of a shared ccvt, compiled with -g, with the one in libccvt.abi,
# which was made with Debian 12's g++ and abigail-tools.
#   check.sh LIBRARY HEADERS_DIR            fails where they differ
#   check.sh --update LIBRARY HEADERS_DIR   writes a new libccvt.abi
# HEADERS_DIR is where the public headers lie: what they do not declare is not compared.
set -euo pipefail
update=
if [ "$1" = --update ]; then
  update=yes
  shift
fi
library=$(realpath "$1")
headers=$2
baseline=$(dirname "$0")/libccvt.abi

# libccvt.so.MAJOR.MINOR, as long as a minor version may break programs (see src/CMakeLists.txt).
soname=$(readelf --dynamic "$library" | sed -n 's/.*soname: \[\(.*\)\]/\1/p')
if ! [[ $soname =~ ^libccvt\.so\.[0-9]+\.[0-9]+$ ]]; then
  echo "$library has the SONAME \"$soname\", not libccvt.so.MAJOR.MINOR" >&2
  exit 1
fi
if ! readelf --sections "$library" | grep -q '\.debug_info'; then
  echo "$library is without debug information: compile it with -g" >&2
  exit 1
fi

how_to_update() {
  cat >&2 <<END
After a compatible change (functions were added), or a step of the version that gave the library a
new SONAME, or as long as no release has had this SONAME, make the baseline anew, and commit it:
  tests/abi/check.sh --update $library $headers
END
}

if [ -n "$update" ]; then
  abidw --headers-dir "$headers" --drop-private-types --drop-undefined-syms --no-show-locs \
    --no-corpus-path --no-comp-dir-path --type-id-style hash --out-file "$baseline" "$library"
  echo "$baseline holds the interface of $soname"
  exit 0
fi
if ! grep -q "soname='$soname'" "$baseline"; then
  echo "$baseline is not of $soname." >&2
  how_to_update
  exit 1
fi

# What is more than added functions may break programs that were linked before, so any such report
# of abidiff's fails: its own verdict counts a changed size of a structure as harmless.
compare() {
  abidiff --headers-dir2 "$headers" --drop-private-types "$@" "$baseline" "$library"
}
if ! compare --no-added-syms; then
  cat >&2 <<END

The binary interface of $soname has changed: programs that were linked with it may break.
It needs a new SONAME, which is a step of the minor version in CMakeLists.txt.
END
  how_to_update
  exit 1
fi
compare >/dev/null || {
  compare --stat || true
  echo "Functions were added to $soname, which are not in the baseline yet." >&2
  how_to_update
}
echo "$soname keeps its binary interface"
