#!/usr/bin/env bash
# Builds and runs the tests: test.sh [--nightly] [--only dev|asan|tsan].
# The library's tests under the address and undefined-behaviour sanitizers; those of what threads wait for each other in
# under the thread sanitizer instead; and in the build nearest to what users run the program's own tests, those that draw
# many pictures or large ones or with many threads, every change of a failing disk, and Kiln's use as a library. With
# --nightly the address sanitizer sees the program and threads, too, and the thread sanitizer frames, long tests are run,
# and the last build runs everything, as it does with --only dev. The first stage that fails ends the script with its
# exit code; what is built is not built again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { echo "usage: scripts/test.sh [--nightly] [--only dev|asan|tsan]" >&2; exit 2; }

presets=(asan tsan dev)
nightly=OFF
whole_dev=OFF
while [ $# -gt 0 ]; do
  case $1 in
    --nightly) nightly=ON; whole_dev=ON; shift ;;
    --only)
      case ${2-} in dev | asan | tsan) presets=("$2") ;; *) usage ;; esac
      whole_dev=ON
      shift 2 ;;
    *) usage ;;
  esac
done

scripts/install_packages.sh build mpi test
scripts/check_includes.sh
scripts/check_definitions.sh

configure=(-DKILN_TESTS=ON "-DKILN_NIGHTLY=$nightly")
if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

export ASAN_OPTIONS=detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp"

for preset in "${presets[@]}"; do
  echo "== $preset, after $SECONDS s"
  case $preset in
    asan) labels=(unit property format fault) ;;
    tsan) labels=(threads) ;;
    dev) labels=(frames fault known_answer cli consumer) ;;
  esac
  if [ "$nightly" = ON ] && [ "$preset" = asan ]; then labels+=(threads frames cli); fi
  if [ "$nightly" = ON ] && [ "$preset" = tsan ]; then labels+=(frames); fi
  if [ "$whole_dev" = ON ] && [ "$preset" = dev ]; then labels+=(unit threads property format); fi
  targets=()
  for label in "${labels[@]}"; do
    # An installed Kiln has the program, too.
    if [ "$label" = consumer ]; then targets+=(kiln_tool); else targets+=("kiln_${label}_tests"); fi
  done
  cmake --preset "$preset" "${configure[@]}"
  cmake --build --preset "$preset" -j "$(nproc)" --target "${targets[@]}"
  ctest --preset "$preset" -j 2 --no-tests=error -L "^($(IFS='|' && echo "${labels[*]}"))$"
done
