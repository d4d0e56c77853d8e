#!/bin/bash
# A user's program under a dozen sets of flags of its own, linked with the library as it was
# installed (and, as a sub-project, with one that was compiled for this very processor): every
# program prints the same bits. Of two libraries the spectrum may differ in its last bits: its sums
# are Eigen's products, whose order depends on the vectors that the library itself is compiled for.
#   flags.sh [--short] WORK_DIR PREFIX...   with the prefixes that libraries were installed to; the
#                                           compilers are g++ and, where it is there, clang++
set -euo pipefail
short=
if [ "$1" = --short ]; then
  short=yes
  shift
fi
work=$1
shift
source_dir=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$work"

flag_sets=(
  "g++ -O2"
  "g++ -O0"
  "g++ -O0 -march=native"
  "g++ -O2 -march=native"
  "g++ -O1 -mavx"
  "g++ -O2 -mavx2 -mfma"
  "g++ -O1 -DEIGEN_MAX_ALIGN_BYTES=16"
  "g++ -O1 -DEIGEN_MAX_ALIGN_BYTES=32"
  "g++ -O1 -DEIGEN_MAX_ALIGN_BYTES=64 -march=native"
  "g++ -O1 -DEIGEN_DONT_VECTORIZE"
  "g++ -O2 -ffast-math -march=native"
  "g++ -O1 -fno-rtti -DEIGEN_DEFAULT_DENSE_INDEX_TYPE=int"
  "g++ -O1 -fsanitize=address -D_GLIBCXX_ASSERTIONS -march=native"
)
if [ -n "$short" ]; then flag_sets=("${flag_sets[@]:0:1}" "${flag_sets[@]:2:1}" "${flag_sets[@]: -1}"); fi
if [ -z "$short" ] && grep -qw avx512f /proc/cpuinfo; then flag_sets+=("g++ -O2 -march=x86-64-v4"); fi
if [ -z "$short" ] && command -v clang++ >/dev/null; then
  flag_sets+=("clang++ -O1 -march=native" "clang++ -O1 -fno-rtti -DEIGEN_DEFAULT_DENSE_INDEX_TYPE=int" "clang++ -O1 -fsanitize=address -march=native")
fi

failed=0
expected=
expected_of_all=
# The first program of a library: the same bits as with the first library, but for the spectrum.
compare_libraries() {  # name
  local bits
  bits=$(grep -v '^metrics' <<<"$expected")
  [ -n "$expected_of_all" ] || expected_of_all=$bits
  if [ "$bits" = "$expected_of_all" ]; then
    echo "passed  $1"
  else
    echo "FAILED  $1: other bits than with the first library:"
    diff <(echo "$expected_of_all") <(echo "$bits") || true
    failed=$((failed + 1))
  fi
}

# A compiled program: the bits that it printed, or why there are none.
compare() {  # name, program
  local printed
  if ! printed=$("$2" 2>&1); then
    echo "FAILED  $1: $(tail -n 1 <<<"$printed")"
    failed=$((failed + 1))
  elif [ -z "$expected" ]; then
    expected=$printed
    echo "$printed"
    compare_libraries "$1"
  elif [ "$printed" = "$expected" ]; then
    echo "passed  $1"
  else
    echo "FAILED  $1: other bits:"
    diff <(echo "$expected") <(echo "$printed") || true
    failed=$((failed + 1))
  fi
}

count=0
for prefix in "$@"; do
  expected=
  pc_dir=$(dirname "$(find "$prefix" -name ccvt.pc | head -n 1)")
  for flags in "${flag_sets[@]}"; do
    object=$work/$(tr -c 'a-zA-Z0-9\n' _ <<<"$flags").o
    read -ra command <<<"$flags"
    read -ra compile < <(PKG_CONFIG_PATH=$pc_dir pkg-config --cflags ccvt)
    read -ra link < <(PKG_CONFIG_PATH=$pc_dir pkg-config --libs ccvt)
    # The headers are the same for all: compiled once, linked with each library.
    [ -e "$object" ] ||
      "${command[@]}" -std=c++20 "${compile[@]}" -c -o "$object" \
        "$source_dir/everything.cpp"
    "${command[@]}" -o "$object.program" "$object" "${link[@]}" \
      -Wl,-rpath,"$(dirname "$pc_dir")"
    compare "$(basename "$prefix"): $flags" "$object.program"
    count=$((count + 1))
  done
done
echo "$((count - failed)) passed, $failed failed"
[ "$failed" -eq 0 ]
