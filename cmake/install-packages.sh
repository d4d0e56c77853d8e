#!/bin/sh
# Installs the Debian packages that are missing: those in debian-packages.txt, and any named as
# arguments. Does nothing, and needs no root, when all are there. When it cannot, it fails and says
# what is missing and how to get it.
set -eu
cd "$(dirname "$0")"
wanted="$(sed 's/#.*//' debian-packages.txt | tr '\n' ' ') $*"

# Another system: CMake will say which libraries it does not find.
if ! command -v apt-get >/dev/null; then
  missing=
  for tool in cmake ninja "${CXX:-g++}"; do
    command -v "$tool" >/dev/null || missing="$missing $tool"
  done
  echo "No apt-get here. Install, by this system's own means, what Debian calls" >&2
  # shellcheck disable=SC2086  # one line
  echo $wanted >&2
  [ -n "$missing" ] || exit 0
  echo "Not found:$missing" >&2
  exit 1
fi

# Prints those of $wanted that are missing, each after a blank.
missing() {
  for package in $wanted; do
    case $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true) in
      installed) ;;
      *) printf ' %s' "$package" ;;
    esac
  done
}

missing=$(missing)
[ -n "$missing" ] || exit 0

give_up() {  # why
  echo "These Debian packages are missing:$(missing)" >&2
  echo "$1" >&2
  echo "To install them by hand, as root: apt-get update && apt-get install$(missing)" >&2
  exit 1
}

if [ "$(id -u)" -eq 0 ]; then
  as_root=
elif command -v sudo >/dev/null; then
  as_root=sudo
else
  give_up "Run this script as root, or install sudo first."
fi

echo "== Installing Debian packages:$missing"
# shellcheck disable=SC2086  # one argument a package
{ $as_root apt-get update -q &&
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends $missing </dev/null; } ||
  give_up "What sudo or apt-get says above is why. All of them are in Debian 12's main: is there a \
network, and does /etc/apt name a mirror?"
