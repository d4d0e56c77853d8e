#!/bin/bash
# Proves on a bare Debian 12 that README's two commands and the Debian packages do all they say.
# Needs root, debootstrap and a mirror; takes about an hour on two processors, and 8 GB.
#   bare-machine.sh DIRECTORY [STEP...]   MIRROR in the environment: http://deb.debian.org/debian
# Each step has a system of its own, made anew in DIRECTORY, and a clone of the last commit:
#   refusals   what is said when packages cannot be installed
#   root       cmake/demo.sh, cmake/test.sh and cmake/package.sh, as root
#   user       the first two as a user who has sudo
#   packages   the packages that the step root made, and nothing else, are installed and used
# Without any, all are taken.
set -euo pipefail
source_dir=$(cd "$(dirname "$0")/.." && pwd)
mirror=${MIRROR:-http://deb.debian.org/debian}
[ $# -ge 1 ] || { sed -n 's/^# \{0,1\}//;2,11p' "$0"; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "bare-machine.sh must be run as root" >&2; exit 2; }
# In mounts and processes of its own: with the script, however it ends, they are gone.
if [ -z "${CCVT_BARE_MACHINE:-}" ]; then
  CCVT_BARE_MACHINE=1 exec unshare --mount --pid --fork --kill-child "$0" "$@"
fi
mkdir -p "$1"
directory=$(cd "$1" && pwd)
shift

say() { echo "=== $* ($SECONDS s)"; }

fail() {
  echo "=== FAILED: $*" >&2
  exit 1
}

# A bare system in $directory/NAME, from one that is made once.
new_system() {  # name
  local base=$directory/base root=$directory/$1
  if [ ! -e "$base/complete" ]; then
    rm -rf "$base"
    debootstrap --variant=minbase bookworm "$base" "$mirror" >"$directory/debootstrap.log" ||
      fail "debootstrap: see $directory/debootstrap.log"
    touch "$base/complete"
  fi
  # What is mounted in the one of an earlier run is not ours.
  rm -rf --one-file-system "$root"
  cp -a "$base" "$root"
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  git clone -q --no-hardlinks "$source_dir" "$root/root/ccvt"
  say "$1: a bare system in $root"
}

# A command for the shell in a system that has nothing of ours, and no environment but this.
as_root() {  # name, command
  chroot "$directory/$1" /usr/bin/env -i HOME=/root LC_ALL=C.UTF-8 \
    PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    SOURCE_DATE_EPOCH="$(git -C "$source_dir" log -1 --format=%ct)" sh -euc "cd; $2"
}

as_user() {  # name, command
  chroot "$directory/$1" setpriv --reuid=builder --regid=builder --init-groups --reset-env \
    sh -euc "cd; $2"
}

add_user() {  # name
  as_root "$1" "useradd --create-home --shell /bin/sh builder"
  mv "$directory/$1/root/ccvt" "$directory/$1/home/builder/ccvt"
  as_root "$1" "chown -R builder: /home/builder"
}

# A command that must fail, and what it must say.
must_fail() {  # as_root or as_user, name, command, texts...
  local command=$3 said text
  if said=$("$1" "$2" "$command" 2>&1); then fail "$2: this passed: $command"; fi
  shift 3
  echo "\$ $command"
  tail -n 4 <<<"$said"
  for text; do
    grep -qF -- "$text" <<<"$said" || fail "$command does not say: $text"
  done
}

# The pictures of the demo: of 20,000 dots, whole, and in every system the same.
check_pictures() {  # name, the clone's folder in it
  local pictures=$directory/$1$2/pictures
  [ "$(grep -c '<circle' "$pictures/stipple.svg")" -eq 20000 ] || fail "$1: stipple.svg"
  as_root "$1" "cd $2
    ccvt/build/release/bin/ccvt stipple pictures/stipple.png --sites 100 -o /tmp/again.svg"
  if [ -e "$directory/stipple.png" ]; then
    cmp "$pictures/stipple.png" "$directory/stipple.png" || fail "$1: another picture"
  fi
  cp "$pictures/stipple.png" "$directory/stipple.png"
}

refusals() {
  local without="These Debian packages are missing: cmake g++" by_hand="apt-get install cmake g++"
  new_system refusals
  # No network.
  echo "deb http://127.0.0.1:9/debian bookworm main" >"$directory/refusals/etc/apt/sources.list"
  for script in demo test; do
    must_fail as_root refusals "ccvt/cmake/$script.sh" "$without" "$by_hand" "does /etc/apt name a mirror"
  done
  # Nobody who may install anything.
  add_user refusals
  must_fail as_user refusals ccvt/cmake/demo.sh "$without" "as root, or install sudo" "$by_hand"
  # Not a Debian.
  rm "$directory/refusals/usr/bin/apt-get"
  must_fail as_root refusals /home/builder/ccvt/cmake/test.sh \
    "No apt-get here" "libeigen3-dev libflann-dev" "Not found: cmake ninja g++"
}

root() {
  new_system root
  as_root root "ccvt/cmake/demo.sh pictures"
  check_pictures root /root
  say "root: cmake/demo.sh makes README's picture"
  as_root root ccvt/cmake/test.sh
  say "root: cmake/test.sh passes"
  as_root root ccvt/cmake/package.sh
  rm -rf "$directory/packages.made"
  cp -r "$directory/root/root/ccvt/build/package/packages" "$directory/packages.made"
  say "root: cmake/package.sh makes packages"
}

user() {
  new_system user
  add_user user
  as_root user "apt-get update -q && apt-get install -y -q --no-install-recommends sudo"
  echo "builder ALL=(ALL) NOPASSWD: ALL" >"$directory/user/etc/sudoers.d/builder"
  as_user user "ccvt/cmake/demo.sh pictures"
  check_pictures user /home/builder
  say "user: cmake/demo.sh makes README's picture"
  as_user user ccvt/cmake/test.sh
  say "user: cmake/test.sh passes"
}

packages() {
  new_system packages
  cp -r "$directory/packages.made" "$directory/packages/root/packages"
  as_root packages "sh ccvt/tests/package/check.sh packages"
  say "packages: installed, used, and removed without a trace"
}

rm -f "$directory/stipple.png"  # of another commit
steps=("$@")
[ $# -gt 0 ] || steps=(refusals root user packages)
[ "$(printf '%s\n' "${steps[@]}" | sort | uniq -d)" = "" ] || fail "a step is named twice"
for step in "${steps[@]}"; do
  case $step in
    refusals | root | user | packages) "$step" ;;
    *) fail "\"$step\" is no step: there are refusals, root, user and packages" ;;
  esac
done
say "passed: ${steps[*]}"
