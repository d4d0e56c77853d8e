#!/bin/sh
# As root on a bare Debian 12, with the repository's clone around: installs the four packages, uses
# each, and removes them. bare-machine.sh calls this.
#   check.sh DIRECTORY   with the packages
set -eu
packages=$(cd "$1" && pwd)
clone=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
cd "$work"
export DEBIAN_FRONTEND=noninteractive
install() {
  apt-get install -y -q --no-install-recommends "$@" </dev/null
}
apt-get update -q

echo "== The program and the Python module"
install "$packages"/libccvt0.1_*.deb "$packages"/ccvt_*.deb "$packages"/python3-ccvt_*.deb
ccvt --version
ccvt sample --dim 2 --sites 64 --seed 1 -o sites.csv
[ "$(wc -l <sites.csv)" -ge 64 ]
for page in ccvt ccvt-sample ccvt-stipple; do
  gzip -t "/usr/share/man/man1/$page.1.gz"
done
[ -s /usr/share/bash-completion/completions/ccvt ]
[ -s /usr/share/zsh/site-functions/_ccvt ]
[ -s /usr/share/fish/vendor_completions.d/ccvt.fish ]
cd /  # where no ccvt lies that Python could take
python3 - "$work/sites.csv" <<'END'
import importlib.metadata
import sys

import ccvt
import numpy

assert importlib.metadata.version("ccvt") == ccvt.__version__, ccvt.__version__
assert ccvt.__file__.startswith("/usr/lib/python3/dist-packages/ccvt/"), ccvt.__file__
program = ccvt.read_points(sys.argv[1])
assert program.shape == (64, 2), program.shape
result = ccvt.tessellate(numpy.random.default_rng(1).random((6400, 2)), 64)
assert (numpy.bincount(result.owners) == 100).all()
print("ccvt", ccvt.__version__, "in Python:", result.summary)
END
cd "$work"

echo "== The development files, with compilers of Debian's"
install "$packages"/libccvt-dev_*.deb
install cmake g++ ninja-build pkgconf
sed -n '/^```cpp/,/^```/{/^```/!p;/^```$/q}' "$clone/README.md" >start.cpp
# shellcheck disable=SC2046  # one argument a flag
g++ -std=c++20 -O1 start.cpp -o start $(pkgconf --cflags --libs ccvt)
./start >said
grep "first site" said
cmake -S "$clone/tests/install" -B consumer -G Ninja
cmake --build consumer
consumer/consumer

echo "== Removal"
apt-get purge -y -q ccvt python3-ccvt libccvt-dev libccvt0.1 </dev/null
left=$(find /usr /etc /var/lib/dpkg/info -name '*ccvt*')
[ -z "$left" ] || { echo "left behind: $left" >&2; exit 1; }
