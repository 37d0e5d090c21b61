#!/usr/bin/env bash
# Installs what the build needs and builds the program, build/release/tools/kiln/kiln, without tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/install_packages.sh build

configure=(-DKILN_TESTS=OFF)
if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake --preset release "${configure[@]}"
cmake --build --preset release -j "$(nproc)"
