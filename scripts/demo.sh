#!/usr/bin/env bash
# From nothing to a picture: installs what is missing, builds the program, converts a CT of a head and draws it.
# What is already there and newer than what it was made from is left alone. Everything but the build goes to out/demo/.
#   demo.sh [PROGRAM [FOLDER]]   with a Kiln that is installed, PROGRAM, nothing is built; FOLDER in place of out/demo/
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

kiln=${1:-build/release/tools/kiln/kiln}
out=${2:-out/demo}
picture=$out/head.png

scripts/install_packages.sh demo
[ $# -gt 0 ] || scripts/build_release.sh

scripts/example_head.sh "$out"
store=$out/cranium.kiln
if [ ! "$store/manifest.json" -nt "$out/cranium.nhdr" ]; then
  "$kiln" convert "$out/cranium.nhdr" "$store" --overwrite
fi
if [ ! "$picture" -nt "$store/manifest.json" ] || [ ! "$picture" -nt "$kiln" ]; then
  "$kiln" render "$store" -o "$picture" --size 1024x1024 --view front --azimuth 25 --elevation 10 \
    --tf ct-skin --look studio --background 0.01,0.012,0.016
fi
echo "The picture: $(realpath "$picture")"
