#!/usr/bin/env bash
# Not run (README.md of the folder above).
set -euo pipefail
# CMAKE_ARGS, PREFIX, SP_DIR and PYTHON are conda's. OpenVDB's find module lies beside its library.
# shellcheck disable=SC2086
cmake -G Ninja -B build $CMAKE_ARGS -D CMAKE_BUILD_TYPE=Release -D CMAKE_INSTALL_LIBDIR=lib \
  -D CMAKE_MODULE_PATH="$PREFIX/lib/cmake/OpenVDB" -D Python3_EXECUTABLE="$PYTHON" -D KILN_PYTHON_DIR="${SP_DIR#"$PREFIX"/}" \
  -D KILN_TESTS=OFF -D KILN_MPI=ON -D KILN_HDF5=ON -D KILN_OPENJPEG=ON -D KILN_VIEW=ON -D KILN_FREETYPE=AUTO -D KILN_PYTHON=ON
cmake --build build
cmake --install build
