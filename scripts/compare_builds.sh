#!/usr/bin/env bash
# Draws, converts and exports with two builds of the program and compares their files: compare_builds.sh KILN_A KILN_B
# Each line names a job and its result: "same bytes", "same pixels" (headers differ) or "DIFFERS". Exits with 1 if a job
# differs. Volumes are phantoms and small files that the script writes. The folder is kept where KEEP names it.
set -euo pipefail
[ $# = 2 ] || { echo "usage: compare_builds.sh KILN_A KILN_B" >&2; exit 2; }
programs=("$(realpath "$1")" "$(realpath "$2")")
work=${KEEP:-$(mktemp -d)}
mkdir -p "$work"
[ -n "${KEEP:-}" ] || trap 'rm -rf "$work"' EXIT
cd "$work"

failed=0 jobs=0
report() { printf '%-28s %s\n' "$1" "$2"; jobs=$((jobs + 1)); case $2 in DIFFERS*) failed=$((failed + 1)) ;; esac; }

# Whether two pictures have equal pixels. Headers may hold versions and times.
same_pixels() { "${programs[0]}" compare --json "$1" "$2" | grep -q '"differing_pixels": 0,'; }
# A manifest without the time and the version of the program.
manifest() { grep -vE '"(time|version|program|kiln|checksum)"' "$1"; }

# run NAME EXTENSION ARGUMENT...: {OUT} among the arguments stands for the output.
run() {
  local name=$1 ending=$2 side
  shift 2
  for side in 0 1; do
    rm -rf "$side.$name" && mkdir -p "$side.$name"
    (cd "$side.$name" && "${programs[side]}" "${@//\{OUT\}/out.$ending}" >out.txt 2>err.txt && rc=0 || rc=$?; echo "$rc" >exit_code.txt)
  done
  compare_folders "$name"
}

# An OpenVDB file without its first bytes, which hold a random name of the file.
vdb_tail() { tail -c +101 "$1"; }

# Compares all files of a job and the exit code; not the text that the program prints, which holds times.
compare_folders() {
  local name=$1 file result="same bytes"
  for file in $(cd "0.$name" && find . -type f ! -name err.txt ! -name out.txt | sort); do
    cmp -s "0.$name/$file" "1.$name/$file" && continue
    case $file in
      *manifest.json) [ "$(manifest "0.$name/$file")" = "$(manifest "1.$name/$file")" ] && continue ;;
      *.vdb) cmp -s <(vdb_tail "0.$name/$file") <(vdb_tail "1.$name/$file") && continue ;;
      *.exr | *.png) same_pixels "0.$name/$file" "1.$name/$file" && result="same pixels" && continue ;;
    esac
    result="DIFFERS ($file)" && break
  done
  [ "$(cd "0.$name" && find . -type f | sort)" = "$(cd "1.$name" && find . -type f | sort)" ] || result="DIFFERS (other files)"
  [ "$(cat "0.$name/exit_code.txt")" = 0 ] || result="$result, exit code $(cat "0.$name/exit_code.txt")"
  report "$name" "$result"
}

a=${programs[0]}
make() { [ -d "$1" ] || "$a" convert "${@:2}" "$1" >/dev/null 2>&1; }
make head.kiln --brick-size 32 phantom:head:96x96x96
make body.kiln --brick-size 32 phantom:body:64x48x200
make brain.kiln --brick-size 64 phantom:brain:80x80x80
make engine.kiln --brick-size 16 phantom:engine:64x64x64
# Labels in blocks of 8 voxels: eight values in 64 voxels cubed.
[ -f labels.nrrd ] || {
  printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 64 64 64\nspacings: 1 1 1\nencoding: raw\n\n'
  for ((z = 0; z < 64; ++z)); do
    for ((y = 0; y < 64; ++y)); do
      n=$(((z / 8 * 5 + y / 8 * 3) % 8))
      for ((x = 0; x < 8; ++x)); do
        c="\\x0$(((n + x) % 8))"
        printf "$c$c$c$c$c$c$c$c"
      done
    done
  done
} >labels.nrrd
make labels.kiln --labels --brick-size 32 labels.nrrd

s=(--size 160x120 --fit box)  # cameras that do not depend on what each build counts as visible
gradient='{"points": [{"value": 900, "opacity": 0, "color": [1, 1, 1]}, {"value": 1400, "opacity": 0.6, "color": [1, 0.8, 0.6]}], "gradientOpacity": [{"gradient": 0, "factor": 0}, {"gradient": 60, "factor": 1}]}'
printf '{"kiln": 2, "volume": "%s/head.kiln", "camera": {"fit": "box"}, "image": {"width": 160, "height": 120}, "transferFunction": %s}' "$work" "$gradient" >gradient.json

run skin_orthographic exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --projection orthographic
run bone_perspective exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone --projection perspective --fov 60
run near_perspective exr render ../body.kiln -o {OUT} "${s[@]}" --tf ct-skin --projection perspective --fov 110 --zoom 4
run fog_tiny_memory exr render ../body.kiln -o {OUT} "${s[@]}" --tf fog --memory 40M --samples 1
run threads_one png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone-and-skin --threads 1
run tile_whole png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --tile 0
run mip exr render ../head.kiln -o {OUT} "${s[@]}" --mode mip --aov value
run minip exr render ../body.kiln -o {OUT} "${s[@]}" --mode minip --projection perspective
run average exr render ../brain.kiln -o {OUT} "${s[@]}" --mode average --tf viridis --samples 4
run voxel exr render ../head.kiln -o {OUT} "${s[@]}" --lattice voxel --tf ct-skin --aov depth,normal
run voxel_perspective png render ../body.kiln -o {OUT} "${s[@]}" --lattice voxel --tf ct-bone --projection perspective --samples 4 --clip 1,0,0.2,-20
run voxel_cubes exr render ../engine.kiln -o {OUT} "${s[@]}" --lattice voxel --test-nodes-only --visibility range-tree --level 0
run labels exr render ../labels.kiln -o {OUT} "${s[@]}" --projection perspective
run labels_voxel png render ../labels.kiln -o {OUT} "${s[@]}" --lattice voxel
run several exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone --add ../brain.kiln --add-tf mr-head --aov depth,normal
run several_labels exr render ../engine.kiln -o {OUT} "${s[@]}" --labels ../labels.kiln --projection perspective --memory 48M
run panorama png render ../head.kiln -o {OUT} --size 128x64 --tf ct-bone --projection equirectangular --fit box
run stereo exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --projection perspective --stereo both --interocular 6
run aovs exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone --aov depth,normal --samples 2
run deep exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone-and-skin --deep --samples 1
run deep_several exr render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --add ../brain.kiln --deep
run crop png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --crop 31,17,63,55 --samples 2
run clip png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --clip 1,0.3,0,5 --clip 0,0,1,40 --region 8,0,0,96,90,96
run cubic exr render ../brain.kiln -o {OUT} "${s[@]}" --tf mr-head --interpolation cubic
run catmull png render ../engine.kiln -o {OUT} "${s[@]}" --interpolation catmull-rom --sample-distance 0.25 --samples 16
run gradient_opacity exr render ../gradient.json -o {OUT}
run quadtree png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-skin --visibility quadtree --quadtree-epsilon 1
run no_visibility png render ../head.kiln -o {OUT} "${s[@]}" --tf ct-bone --visibility none --shading none
run turntable png render ../head.kiln -o 'f_####.png' --size 80x80 --tf ct-bone --turntable 3 --fit box
run checkpoint exr render ../head.kiln -o {OUT} --size 600x600 --samples 1 --tf ct-skin --checkpoint --fit box
run slice png slice ../head.kiln -o {OUT}
run foreign png render ../labels.nrrd -o {OUT} --size 80x60 --mode mip --fit box

# Partial images and their composite.
for side in 0 1; do
  rm -rf "$side.parts" && mkdir -p "$side.parts"
  (cd "$side.parts" && for i in 1 2 3; do "${programs[side]}" render ../head.kiln -o "p$i.exr" "${s[@]}" --tf ct-bone-and-skin --part $i/3 --aov depth >out.txt 2>err.txt; done
    "${programs[side]}" composite p1.exr p2.exr p3.exr -o whole.exr >out.txt 2>err.txt && rc=0 || rc=$?; echo "$rc" >exit_code.txt)
done
compare_folders parts

# A store and a foreign file made of it. Dates and versions of a manifest may differ.
for side in 0 1; do
  rm -rf "$side.store" && mkdir -p "$side.store"
  (cd "$side.store" && "${programs[side]}" convert --brick-size 32 phantom:engine:48x40x36 s.kiln >/dev/null 2>err.txt && "${programs[side]}" export s.kiln s.vdb >/dev/null 2>>err.txt
    rc=$?; echo "$rc" >exit_code.txt)
done
compare_folders store

echo "$jobs jobs, $failed differ"
[ "$failed" = 0 ]
