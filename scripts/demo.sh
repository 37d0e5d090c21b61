#!/usr/bin/env bash
# From a bare machine to a picture: installs what is missing, builds, converts a CT head and draws it to out/demo/head.png.
# What is done is not done again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/install_packages.sh build demo

kiln=build/release/tools/kiln/kiln
if [ ! -f build/release/build.ninja ]; then
  configure=(-DKILN_TESTS=OFF)
  if command -v ccache >/dev/null; then configure+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  cmake --preset release "${configure[@]}"
fi
cmake --build --preset release --target kiln_tool -j "$(nproc)"

out=out/demo
mkdir -p "$out"

# The head of Debian's invesalius-examples: a tar archive with the voxels as they lie in memory, i16 little-endian.
archive=/usr/share/doc/invesalius-examples/examples/Cranium.inv3
bytes=$((256 * 256 * 108 * 2))
if [ "$(stat -c %s "$out/matrix.dat" 2>/dev/null || echo 0)" -ne $bytes ]; then
  tar -xzOf "$archive" --wildcards '*/matrix.dat' >"$out/matrix.dat.tmp"
  [ "$(stat -c %s "$out/matrix.dat.tmp")" -eq $bytes ] || { echo "demo.sh: $archive does not hold $bytes bytes of voxels" >&2; exit 1; }
  mv "$out/matrix.dat.tmp" "$out/matrix.dat"
fi

# The archive gives the spacing (main.plist) and no directions. These are read off the voxels: the teeth are in the first
# slices and the crown in the last, so z runs to superior; in a slice the scanner's table is at the first rows and the nose
# at the last, so y runs to anterior, against LPS. A head does not tell left from right: x runs to the left, as in DICOM's
# axial slices, whose rows alone the program that wrote the archive turns round.
header='NRRD0005
type: short
dimension: 3
sizes: 256 256 108
endian: little
encoding: raw
space: left-posterior-superior
space directions: (0.957032,0,0) (0,-0.957032,0) (0,0,1.5)
space origin: (0,244.04316,0)
space units: "mm" "mm" "mm"
data file: matrix.dat'
if [ "$(cat "$out/cranium.nhdr" 2>/dev/null || true)" != "$header" ]; then
  printf '%s\n' "$header" >"$out/cranium.nhdr"
fi

store=$out/cranium.kiln
if [ "$store/manifest.json" -nt "$out/cranium.nhdr" ] && [ "$store/manifest.json" -nt "$out/matrix.dat" ] && "$kiln" verify "$store"; then
  echo "The store is there already."
else
  "$kiln" convert "$out/cranium.nhdr" "$store" --overwrite
fi

if [ "$out/head.png" -nt "$store/manifest.json" ] && [ "$out/head.png" -nt "$kiln" ]; then
  echo "The picture is there already."
else
  "$kiln" render "$store" -o "$out/head.png" --size 1024x1024 --view front --azimuth 25 --elevation 10
fi
echo "The picture: $PWD/$out/head.png"
