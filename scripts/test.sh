#!/usr/bin/env bash
# Builds and runs the tests: test.sh [--nightly] [--only dev|asan|tsan].
# The sanitizers first and `dev` last, so that the last thing printed is the summary of the build nearest to what users run.
# The first stage that fails ends the script with its exit code; what is built is not built again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() { echo "usage: scripts/test.sh [--nightly] [--only dev|asan|tsan]" >&2; exit 2; }

presets=(asan tsan dev)
nightly=OFF
while [ $# -gt 0 ]; do
  case $1 in
    --nightly) nightly=ON; shift ;;
    --only)
      case ${2-} in dev | asan | tsan) presets=("$2") ;; *) usage ;; esac
      shift 2 ;;
    *) usage ;;
  esac
done

scripts/install_packages.sh build test
scripts/check_includes.sh

configure=(-DKILN_TESTS=ON "-DKILN_NIGHTLY=$nightly")
if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi

export ASAN_OPTIONS=detect_leaks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/tests/support/tsan.supp"

for preset in "${presets[@]}"; do
  echo "== $preset"
  # Threads meet in the unit and property tests; the others, and of these what one thread does or others show faster, would
  # take long under the thread sanitizer and show nothing more.
  chosen=()
  targets=()
  # The largest of the real files, and those that sum up many pictures, take minutes under the address sanitizer, and
  # smaller ones go the same ways.
  if [ "$preset" = asan ] && [ "$nightly" = OFF ]; then chosen=(-E 'RealExport.*(smoke|sphere)|RealData.*vhm_head|LatticeWeights|HasItsClosedForm|PictureQuality'); fi
  if [ "$preset" = tsan ]; then
    chosen=(-L 'unit|property' -E 'ReferenceRenderer|Phantom|RealExactness|HiddenBricks|VisitingOrder|VisibilityMethods|ImageFile|Bench')
    targets=(--target kiln_unit_tests kiln_property_tests)
  fi
  cmake --preset "$preset" "${configure[@]}"
  cmake --build --preset "$preset" -j "$(nproc)" "${targets[@]}"
  ctest --preset "$preset" -j 2 --no-tests=error "${chosen[@]}"
done
