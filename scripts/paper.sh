#!/usr/bin/env bash
# Repeats the experiments of Lee and Ihm's paper and prints its numbers beside ours: paper.sh [--quick] [OUT_DIR].
# Builds the program, measures, and writes OUT_DIR/report.html; out/paper if no directory is named. Over the volumes of
# ../shared/data where they are, over procedural ones of the paper's sizes where they are not. --quick is a look of a
# few minutes at smaller pictures, without the whole body; the whole takes half an hour on two cores.
set -euo pipefail

usage() { echo "usage: scripts/paper.sh [--quick] [OUT_DIR]" >&2; exit 2; }

options=()
out=
while [ $# -gt 0 ]; do
  case $1 in
    --quick) options+=(--quick) ;;
    -*) usage ;;
    *) [ -z "$out" ] || usage; out=$(realpath -m -- "$1") ;;
  esac
  shift
done

cd "$(dirname "${BASH_SOURCE[0]}")/.."
out=${out:-$PWD/out/paper}

scripts/build_release.sh

suite=scripts/paper_suite.json
if [ ! -d ../shared/data ]; then
  echo "../shared/data is not there: procedural volumes of the paper's sizes are drawn instead"
  suite=scripts/paper_suite_phantom.json
fi
mkdir -p "$(dirname "$out")"
build/release/tools/kiln/kiln bench "$suite" -o "$out" "${options[@]}"
