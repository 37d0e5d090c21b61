#!/usr/bin/env bash
# Kiln beside the renderers that Debian ships, in turn and in one run: bench_peers.sh [--quick] [OUT_DIR], out/peers if none
# is named. VTK's CPU ray caster (what ParaView draws with where there is no GPU), VolPack's shear-warp and OpenVDB's
# vdb_render; pictures side by side are OUT_DIR/*.png. Volumes are those of ../shared/data, else a phantom. It takes some
# minutes, wants a quiet machine and is not part of CI. Exit code 1 where pictures do not show the same thing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

quick=()
if [ "${1-}" = --quick ]; then quick=(--quick); shift; fi
out=${1-out/peers}
case $out in -*) echo "usage: scripts/bench_peers.sh [--quick] [OUT_DIR]" >&2; exit 2 ;; esac

scripts/install_packages.sh build peers
configure=()
if command -v ccache >/dev/null; then configure=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake --preset release "${configure[@]}" >/dev/null
cmake --build --preset release -j "$(nproc)" --target kiln_tool
mkdir -p "$out"
cc -O3 -std=gnu11 -o "$out/volpack_frames" tests/bench/peers/volpack_frames.c -lvolpack -lm

# VTK's pictures come out of a window, which has a display of its own here. Debian's own Python has its packages.
export PYTHONDONTWRITEBYTECODE=1
xvfb-run --auto-servernum -s "-screen 0 1280x1024x24" /usr/bin/python3 tests/bench/peers/run.py --kiln build/release/tools/kiln/kiln \
  --volpack "$out/volpack_frames" --data ../shared/data --out "$out" "${quick[@]}"
