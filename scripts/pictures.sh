#!/usr/bin/env bash
# Draws the pictures of the manual's page tools/kiln/manual/pictures.md with the commands of that page: a block that
# opens with "```sh picture" is run as it stands there.
#   pictures.sh PROGRAM FOLDER [SIZE]   with the Kiln PROGRAM into FOLDER; SIZE, such as 160x120, in place of the page's
set -euo pipefail

if [ $# -lt 2 ]; then echo "pictures.sh: expected PROGRAM FOLDER [SIZE] (found $# words)" >&2; exit 2; fi
program=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")
size=${3:-}
root=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
export templates=/usr/share/mricron/templates

"$root/scripts/install_packages.sh" pictures
"$root/scripts/example_head.sh" "$folder"
/usr/bin/python3 "$root/scripts/pictures_data.py" "$templates" "$folder"

kiln() { "$program" "$@"; }
cd "$folder"
# Without SIZE the option is replaced by itself.
source <(awk '/^```/ { inside = !inside && $0 == "```sh picture"; next } inside' "$root/tools/kiln/manual/pictures.md" |
  sed -E "s/--size [0-9x]+/${size:+--size }${size:-&}/")
