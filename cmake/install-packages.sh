#!/bin/sh
# Installs the Debian packages that are missing: those in debian-packages.txt, and any named as
# arguments. Does nothing, and needs no root, when all are there.
set -eu
cd "$(dirname "$0")"

if ! command -v apt-get >/dev/null; then
  echo "No apt-get here: install the equivalents of cmake/debian-packages.txt yourself." >&2
  exit 0
fi

missing=
for package in $(sed 's/#.*//' debian-packages.txt) "$@"; do
  case $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true) in
    installed) ;;
    *) missing="$missing $package" ;;
  esac
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" -eq 0 ]; then
  as_root=
elif command -v sudo >/dev/null; then
  as_root=sudo
else
  echo "These Debian packages are missing:$missing" >&2
  echo "Run this script as root, or install sudo first." >&2
  exit 1
fi

echo "== Installing Debian packages:$missing"
$as_root apt-get update -q
# shellcheck disable=SC2086  # one argument a package
$as_root env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends $missing </dev/null
