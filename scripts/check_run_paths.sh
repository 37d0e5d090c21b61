#!/usr/bin/env bash
# Checks the folders in which the programs and libraries below FOLDER look for libraries (DT_RUNPATH and DT_RPATH):
# check_run_paths.sh FOLDER [BUILD]. An element is absolute or begins with $ORIGIN, and nobody else can write to it: an
# empty or relative element is the working directory, whose owner would choose the code that runs. With BUILD, FOLDER is
# an install tree, whose elements lie outside the build tree BUILD.
set -euo pipefail

[ $# -ge 1 ] && [ -d "$1" ] || { echo "usage: check_run_paths.sh FOLDER [BUILD]" >&2; exit 2; }
root=$(realpath "$1")
build=${2:+$(realpath "$2")}

# Prints why others can put files into a folder, or nothing. An absent folder can be made by whoever can write to the
# nearest one above it; a folder can be replaced by whoever can write to the one above it, unless its sticky bit is set.
# The search ends at FOLDER: whoever can write there can replace the programs themselves.
writable() {
  local folder=$1 mode
  while [ ! -e "$folder" ]; do folder=$(dirname "$folder"); done
  mode=$(stat -L -c %a "$folder")
  if (( 8#$mode & 2 )); then echo "anyone can write to $folder"; return; fi
  while [ "$folder" != / ] && [ "$folder" != "$root" ]; do
    folder=$(dirname "$folder")
    mode=$(stat -L -c %a "$folder")
    if (( 8#$mode & 2 && !(8#$mode & 8#1000) )); then echo "anyone can write to $folder"; return; fi
  done
}

files=0
faults=0
complain() { echo "$1: run path '$2': $3"; faults=$((faults + 1)); }

while IFS= read -r -d '' file; do
  dynamic=$(readelf -dW "$file" 2>/dev/null) || continue
  [[ $dynamic == *'Dynamic section'* ]] || continue
  files=$((files + 1))
  while IFS= read -r path; do
    # A colon more at the end keeps an empty last element.
    IFS=: read -ra elements <<<"$path:"
    for element in "${elements[@]}"; do
      folder=${element/#'$ORIGIN'/$(dirname "$file")}
      case $element in
        '') complain "$file" "$path" "an empty element is the working directory" ; continue ;;
        /* | '$ORIGIN' | '$ORIGIN'/*) ;;
        *) complain "$file" "$path" "'$element' is relative to the working directory"; continue ;;
      esac
      folder=$(realpath -m "$folder")
      why=$(writable "$folder")
      [ -z "$why" ] || complain "$file" "$path" "$why"
      if [ -n "$build" ] && [[ $folder/ != "$root"/* ]] && [[ $folder/ == "$build"/* ]]; then
        complain "$file" "$path" "'$element' is in the build tree $build"
      fi
    done
  done < <(sed -nE 's/.*\((RUNPATH|RPATH)\).*\[(.*)\]$/\2/p' <<<"$dynamic")
done < <(find "$root" -name test_output -prune -o -type f \( -name '*.so' -o -name '*.so.*' -o -perm /111 \) -print0)

[ "$files" -gt 0 ] || { echo "$root: no program or library was found"; exit 1; }
[ "$faults" -eq 0 ] || exit 1
echo "$files programs and libraries below $root look for libraries in safe folders"
