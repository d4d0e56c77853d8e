# What .ci/run and .ci/full are made of; they source this file. A failed stage does not keep the
# later ones from running.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
jobs=$(nproc)
passed=0
failed=0

stage() {  # name, command
  local name=$1 start=$SECONDS
  shift
  echo "=== $name"
  if "$@"; then
    passed=$((passed + 1))
    echo "=== $name: passed in $((SECONDS - start)) s"
  else
    failed=$((failed + 1))
    echo "=== $name: FAILED after $((SECONDS - start)) s"
  fi
}

# The last line of the output, and the exit status.
close() {
  echo "=== all stages: $SECONDS s"
  echo "$passed passed, $failed failed"
  [ "$failed" -eq 0 ]
}

build() {  # preset, further arguments for the build
  local preset=$1
  shift
  cmake --preset "$preset" && cmake --build --preset "$preset" -j "$jobs" "$@"
}

build_and_test() {  # preset, further arguments for ctest
  local preset=$1
  shift
  build "$preset" && ctest --preset "$preset" -j "$jobs" "$@"
}

# The command as it stands; warnings of g++ are errors here, not for users.
readme_test_command() {
  env CXXFLAGS=-Werror cmake/test.sh
}

public_headers() {  # each alone
  cmake --build --preset release --target all_verify_interface_header_sets
}

quick_benchmarks() {
  build/release/bin/ccvt-bench all --quick -o build/release/quick-benchmarks >/dev/null
}

# No Eigen type in what the library compiles.
border() {
  python3 tests/install/border.py clang++-14 -Iinclude -Ibuild/release/include \
    -isystem /usr/include/eigen3
}

# Codebooks as inverted files of FAISS.
faiss_lists() {
  /usr/bin/python3 tests/faiss/ivf.py build/release/bin/ccvt
}

# Particle loads, as another reader of HDF5 sees them.
hdf5_loads() {
  /usr/bin/python3 tests/hdf5/load.py build/release/bin/ccvt
}

# A shared library as part of another project, compiled for this very processor.
sub_project() {
  cmake --preset release -DCCVT_TEST_SUB_PROJECT=ON &&
    ctest --preset release -R '^install\.sub_project$'
}

# A user's program under all kinds of flags, with the libraries that the tests installed, and with
# the sub-project's.
consumers() {
  local work=build/release/tests/install
  tests/install/flags.sh "$work/all_flags" \
    "$PWD/$work/installed/installed" "$PWD/$work/sub_project/shared"
}

# The Python package, as pip makes it, in an environment of its own, with the library and the program
# that the release preset built. Its tests, scikit-learn's, doctests and types.
python_package() {
  local work=$PWD/build/release/python
  cmake/install-packages.sh mypy pybind11-dev python3-dev python3-numpy python3-pip python3-pytest \
    python3-setuptools python3-sklearn python3-tqdm python3-venv python3-wheel || return 1
  rm -rf "$work" && cmake --install build/release --prefix "$work/ccvt" >/dev/null &&
    /usr/bin/python3 -m venv --system-site-packages "$work/venv" &&
    "$work/venv/bin/pip" install --no-index --no-build-isolation \
      --config-settings "prefix=$work/ccvt" . &&
    CCVT_PROGRAM=$work/ccvt/bin/ccvt PYTHONDONTWRITEBYTECODE=1 \
      "$work/venv/bin/python" -m pytest -q -p no:cacheprovider tests/python
}

developer_packages() {
  cmake/install-packages.sh \
    chromium clang clang-14 clang-format-14 clang-tidy-14 libclang-rt-14-dev libopenmpi-dev python3 python3-faiss python3-h5py
}

# The page of errors has what tests throw.
errors() {
  local record=build/release/tests/errors.txt
  tests/errors/record.sh build/release "$record" && tests/errors/check.py --record "$record"
}

# The binary interface of the sub-project's shared library, beside that of programs.
binary_interface() {
  local shared=build/release/tests/install/sub_project/shared
  cmake/install-packages.sh abigail-tools &&
    tests/abi/check.sh "$(find "$shared" -name libccvt.so)" "$shared/include/ccvt"
}

# What README says of Debian packages, without errors of lintian's.
debian_packages() {
  cmake/install-packages.sh lintian && cmake/package.sh &&
    lintian --fail-on error build/package/packages/*.deb
}

# Manual pages and completions.
pages() {
  cmake/install-packages.sh fish groff-base zsh &&
    tests/pages/check.sh build/release/bin/ccvt build/release/pages
}

# By MPI, with the library and the program that the release preset built.
several_processes() {  # which tests
  cmake/install-packages.sh libopenmpi-dev openmpi-bin fish groff-base zsh &&
    cmake --preset release -DCCVT_BUILD_MPI=ON && cmake --build --preset release -j "$jobs" &&
    tests/pages/check.sh build/release/bin/ccvt build/release/pages build/release/bin/ccvt-mpi &&
    ctest --preset release -R "$1"
}

# By the other MPI, whose ranks wait by polling: few of them.
several_processes_mpich() {
  cmake/install-packages.sh libmpich-dev mpich &&
    cmake --preset release -B build/mpich -DCCVT_BUILD_MPI=ON -DCCVT_BUILD_BENCHMARKS=OFF \
      -DMPI_CXX_COMPILER=/usr/bin/mpicxx.mpich -DMPIEXEC_EXECUTABLE=/usr/bin/mpiexec.mpich &&
    cmake --build build/mpich -j "$jobs" --target ccvt_cli ccvt_mpi_cli ccvt_mpi_tests &&
    ctest --test-dir build/mpich --output-on-failure -R '^mpi\.(ranks_[12]|kills)$' &&
    python3 -B tests/mpi/program.py build/mpich/bin /usr/bin/mpiexec.mpich --ranks 2 --short
}

# The documentation site, its guides' commands, links and layers, by README's command.
documents() {
  cmake/install-packages.sh doxygen graphviz python3 &&
    cmake --preset release -DCCVT_BUILD_DOCS=ON && cmake --build --preset release --target ccvt_docs
}

format() {
  find include src tests benchmarks \( -name '*.h' -o -name '*.cpp' \) -print0 |
    xargs -0 clang-format-14 --dry-run --Werror
}

# From valid files on.
fuzz() {  # preset, seconds for each kind of file
  local tests=build/$1/tests seconds=$2 corpus=build/$1/corpus
  python3 tests/fuzz/volume_corpus.py "$corpus/volumes" &&
    fuzz_from "$tests" "$corpus/volumes" "$seconds" volume_fuzzer -malloc_limit_mb=64 &&
    python3 tests/fuzz/mesh_corpus.py "$corpus/meshes" &&
    fuzz_from "$tests" "$corpus/meshes" "$seconds" mesh_fuzzer -malloc_limit_mb=64 &&
    "$tests/image_seeds" "$corpus/pictures" &&
    fuzz_from "$tests" "$corpus/pictures" "$seconds" image_fuzzer -malloc_limit_mb=512 &&
    python3 tests/fuzz/cloud_corpus.py "$corpus/clouds" &&
    fuzz_from "$tests" "$corpus/clouds" "$seconds" cloud_fuzzer -malloc_limit_mb=64
}

fuzz_from() {  # the fuzzers' folder, corpus, seconds, fuzzer, its options
  local tests=$1 corpus=$2 seconds=$3 fuzzer=$4
  shift 4
  "$tests/$fuzzer" -max_len=4096 -max_total_time="$seconds" "$@" \
    -print_final_stats=1 -verbosity=0 "$corpus"
}

tidy_all() {
  build tidy
}

# The sources that differ from where this branch left the main one; on that itself, those of the
# last commits; first what is not committed. Those that changed last: time is short where this is
# used.
changed_sources() {  # how many
  local base
  base=$(git merge-base HEAD origin/main 2>/dev/null || git merge-base HEAD main 2>/dev/null ||
    git rev-parse HEAD) || return 1
  if [ "$base" = "$(git rev-parse HEAD)" ]; then
    base=$(git rev-list --max-count=20 HEAD | tail -n 1)
  fi
  {
    git diff --name-only HEAD -- 'src/*.cpp'
    git log --format= --name-only "$base..HEAD" -- 'src/*.cpp'
  } | awk '!seen[$0]++ && !system("test -e " $0)' | sed -n "1,$1p"
}

tidy_changed() {  # how many sources
  local sources
  sources=$(changed_sources "$1") && cmake --preset tidy || return 1
  echo "clang-tidy: $(echo "$sources" | grep -c .) sources"
  [ -n "$sources" ] || return 0
  echo "$sources" | xargs -P "$jobs" -n 1 clang-tidy-14 --quiet -p build/tidy
}
