#!/usr/bin/env bash
# Builds and runs the tests: test.sh [--ci] [--nightly] [--only STAGE]. The stages:
#   configure  the build by hand with and without optional packages, as CMake configures it
#   release    what users build by hand, and in it the program's own tests, also while each system call fails, tests that draw
#              many or large pictures or draw with many threads, and Kiln's use as an installed library
#   dev        the release stage's tests with assertions, each file compiled by itself; nightly, or alone
#   asan       unit, property, format and fault tests (each change of a failing disk) under the address and undefined-behaviour sanitizers
#   tsan       tests of what threads wait for each other in, under the thread sanitizer
#   chroot     a fresh clone built by README's text in a bare Debian; nightly, or alone
#   packages   packages of the release build, installed and used in bare Debians; nightly, or alone
# With --nightly long tests are run, the address sanitizer sees the program and threads, too, the thread sanitizer frames,
# the release and dev stages run all tests, as they do alone, and the release stage builds everything, with the benchmarks.
# The first stage that fails ends the script with an exit code other than 0; what is built is not built again. Tests wait for
# disks and other processes: those of a stage run while the next stage is built. The last lines name each skipped test and why
# it was skipped. With --ci, or CI=true in the environment, only absent data (../shared/data) may skip a test: a skip for
# another reason is a failure.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { echo "usage: scripts/test.sh [--ci] [--nightly] [--only configure|asan|tsan|release|dev|chroot|packages]" >&2; exit 2; }

stages=(configure release asan tsan)
nightly=OFF
whole=OFF
ci=${CI:-false}
while [ $# -gt 0 ]; do
  case $1 in
    --ci) ci=true; shift ;;
    --nightly) nightly=ON; whole=ON; stages=(configure release dev asan tsan chroot packages); shift ;;
    --only)
      case ${2-} in configure | asan | tsan | release | dev | chroot | packages) stages=("$2") ;; *) usage ;; esac
      whole=ON
      shift 2 ;;
    *) usage ;;
  esac
done

scripts/install_packages.sh build mpi test
scripts/example_head.sh out/head  # for the test of the manual's pictures, which should need no network
# A reader of Zarr that judges Zarr files in a test. The test is left out where npm or the network is not there.
if command -v npm >/dev/null && [ ! -e out/zarrita/node_modules/zarrita ]; then
  timeout 60 npm install --silent --prefer-offline --no-audit --no-fund --prefix out/zarrita zarrita@0.7.5 ||
    { rm -rf out/zarrita; echo "zarrita cannot be installed: Zarr files are not judged by it"; }
fi
scripts/check_includes.sh
scripts/check_definitions.sh
scripts/check_documents.sh

configure=(-DKILN_TESTS=ON -DKILN_MPI=ON -DKILN_HDF5=ON -DKILN_OPENJPEG=ON -DKILN_NANOVDB=ON -DKILN_VIEW=ON -DKILN_PYTHON=ON "-DKILN_NIGHTLY=$nightly")
if [ "$nightly" = ON ]; then
  scripts/install_packages.sh bench
  configure+=(-DKILN_BENCH=ON)
fi
if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

export ASAN_OPTIONS=detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp"

mkdir -p build
logs=()
tests=       # the process that runs the tests of the last stage, and that stage
tests_of=
trap '[ -z "$tests" ] || kill "$tests" 2>/dev/null || true' EXIT

# Waits for the tests of the last stage and prints what they printed.
finish_tests() {
  [ -n "$tests" ] || return 0
  local code=0
  wait "$tests" || code=$?
  tests=
  cat "build/$tests_of.log"
  echo "== $tests_of: tests ended with exit code $code, after $SECONDS s"
  [ $code = 0 ] || exit "$code"
}

# Runs a command as the tests of a stage, while the next stage is built.
start_tests() {
  tests_of=$1
  shift
  "$@" >"build/$tests_of.log" 2>&1 &
  tests=$!
}

build_and_start_tests() {
  local preset=$1 labels targets=(--target)
  case $preset in
    asan) labels=(unit property format fault) ;;
    tsan) labels=(threads) ;;
    release | dev) labels=(frames known_answer cli calls consumer browser python) ;;
  esac
  if [ "$nightly" = ON ] && [ "$preset" = asan ]; then labels+=(threads frames cli calls); fi
  if [ "$nightly" = ON ] && [ "$preset" = tsan ]; then labels+=(frames); fi
  if [ "$whole" = ON ] && [[ $preset = release || $preset = dev ]]; then labels+=(unit threads property format fault); fi
  for label in "${labels[@]}"; do
    # An installed Kiln has the program, too.
    case $label in
      consumer | browser) targets+=(kiln_tool) ;;
      python) targets+=(kiln_python) ;;
      *) targets+=("kiln_${label}_tests") ;;
    esac
  done
  # Everything that README's command builds, and the benchmarks.
  if [ "$nightly" = ON ] && [ "$preset" = release ]; then targets=(); fi
  # Files that are compiled together do not show which of them lacks an include.
  local unity=ON
  if [ "$preset" = dev ]; then unity=OFF; fi
  # Programs with sanitizers take 4 s of processor time to link, and 2 s with lld; users' programs are linked as users do.
  local linker=()
  if [[ $preset = asan || $preset = tsan ]] && command -v ld.lld >/dev/null; then
    linker=(-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld -DCMAKE_MODULE_LINKER_FLAGS=-fuse-ld=lld)
  fi
  # No sanitizer sees NanoVDB's templates, which take 25 s of processor time to compile; the release stage tests them.
  local nanovdb=()
  if [[ $preset = asan || $preset = tsan ]] && [ "$nightly" = OFF ]; then nanovdb=(-DKILN_NANOVDB=OFF); fi
  cmake --preset "$preset" "${configure[@]}" "${linker[@]}" "${nanovdb[@]}" "-DCMAKE_UNITY_BUILD=$unity"
  cmake --build --preset "$preset" -j "$(nproc)" "${targets[@]}"
  echo "== $preset is built, after $SECONDS s"
  finish_tests
  start_tests "$preset" ctest --preset "$preset" -j 2 --no-tests=error -L "^($(IFS='|' && echo "${labels[*]}"))$"
  logs+=("build/$preset/Testing/Temporary/LastTest.log")
}

for stage in "${stages[@]}"; do
  echo "== $stage, after $SECONDS s"
  case $stage in
    configure) start_tests configure scripts/check_builds.sh --configure ;;
    chroot) finish_tests; scripts/install_packages.sh chroot; scripts/check_builds.sh ;;
    packages)
      finish_tests
      scripts/install_packages.sh demo chroot packages
      cmake --preset release "${configure[@]}"
      cmake --build --preset release -j "$(nproc)" --target kiln kiln_tool kiln_python
      scripts/check_packages.sh ;;
    *) build_and_start_tests "$stage" ;;
  esac
done
finish_tests

echo "== done after $SECONDS s"
if [ ${#logs[@]} -gt 0 ]; then
  if [ "$ci" = true ]; then logs=(--ci "${logs[@]}"); fi
  scripts/skipped_tests.sh "${logs[@]}"
fi
