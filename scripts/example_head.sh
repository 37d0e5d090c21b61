#!/usr/bin/env bash
# Writes the CT of a head of InVesalius' examples as a volume file: example_head.sh FOLDER makes FOLDER/cranium.nhdr and
# FOLDER/matrix.dat, if they are not there.
set -euo pipefail
out=$1
study=/usr/share/doc/invesalius-examples/examples/Cranium.inv3

mkdir -p "$out"
if [ ! -e "$out/matrix.dat" ]; then
  if [ ! -e "$study" ]; then
    # Small images of Debian tell dpkg to leave /usr/share/doc out: then the package is unpacked by hand.
    rm -rf "$out/package" && mkdir "$out/package"
    # As root, apt would fetch as a user who may not write here.
    (cd "$out/package" && apt-get -qq -o APT::Sandbox::User=root download invesalius-examples)
    dpkg-deb -x "$out"/package/invesalius-examples_*.deb "$out/package"
    study=$out/package$study
  fi
  # The voxels are one file of the archive, in a folder of any name. A file half written must not look whole.
  tar -xzf "$study" --wildcards --no-anchored --to-stdout '*/matrix.dat' >"$out/matrix.dat.part"
  size=$(stat -c %s "$out/matrix.dat.part")
  [ "$size" -eq $((256 * 256 * 108 * 2)) ] || { echo "example_head.sh: matrix.dat has $size bytes, not 256 x 256 x 108 of int16" >&2; exit 1; }
  mv "$out/matrix.dat.part" "$out/matrix.dat"
  rm -rf "$out/package"
fi

# Orientation. Drawn as a raw volume with +z up, the head is upright and its face looks along +y, the head rest
# behind it: +y is anterior, +z superior. Left and right cannot be seen in a head; they follow from how InVesalius stores
# DICOM's axial slices, with the rows reversed and the columns as they were: +x is the patient's left. The voxels are thus
# in left-anterior-superior order, which LPS says with a negative second direction. The origin puts the world's zero in
# the middle of the volume.
header=$(cat <<'NRRD'
NRRD0005
# CT of a head, Cranium.inv3 of InVesalius' examples.
type: int16
dimension: 3
sizes: 256 256 108
encoding: raw
endian: little
space: left-posterior-superior
space directions: (0.95703125,0,0) (0,-0.95703125,0) (0,0,1.5)
space origin: (-122.021484375,122.021484375,-80.25)
space units: "mm" "mm" "mm"
data file: matrix.dat
NRRD
)
# An equal header keeps its time, and with it the store and the picture.
if [ "$header" != "$(cat "$out/cranium.nhdr" 2>/dev/null || true)" ]; then printf '%s\n' "$header" >"$out/cranium.nhdr"; fi
