#!/usr/bin/env bash
# Makes packages of a release build and uses them where nothing of Kiln is installed: check_packages.sh [BUILD [OUT]]
#   BUILD  build/release; its program, library, modules and Python package are built, and lowdown has made the man pages
#   OUT    build/packages: the packages stay there
# Packages for Debian are installed in a bare Debian. The tarball runs in a folder with glibc alone, with a cluster's
# Open MPI, and in an older Debian with the glibc that it brings. All draw the demo's picture, bit for bit the same one,
# and read files whose formats are read by workers. Needs root, and a minute for each of three bare Debians.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=scripts/bare_debian.sh
source scripts/bare_debian.sh

fail() { echo "check_packages.sh: $*" >&2; exit 1; }
step() { echo "== $*, after $SECONDS s"; }
megabytes() { awk '{ printf "%.2f MB\n", $1 / 1e6 }'; }

build=${1:-build/release}
out=${2:-build/packages}
[ $# -le 2 ] && [ -e "$build/CPackConfig.cmake" ] || fail "usage: check_packages.sh [BUILD [OUT]]; $build is no configured build"
[ "$(id -u)" = 0 ] || fail "a bare Debian needs root"
build=$(realpath "$build")
rm -rf "$out"
mkdir -p "$out"
out=$(realpath "$out")
scratch=$(mktemp -d /var/tmp/kiln_packages.XXXXXX)
trap 'if [ $? = 0 ]; then rm -rf --one-file-system "$scratch"; else echo "the folders of the check are left in $scratch" >&2; fi' EXIT
debian=$scratch/debian bare=$scratch/bare old=$scratch/old
mkdir "$debian" "$bare" "$old"

# logged COMMAND...: shows the output of a command only if the command fails.
logged() { "$@" >"$scratch/log" 2>&1 || { tail -50 "$scratch/log"; fail "failed: $*"; }; }

# The files of formats that workers read: HDF5, and a folder of two JPEG 2000 slices.
make_inputs() {
  mkdir -p "$scratch/input/slices"
  /usr/bin/python3 - "$scratch/input" <<'PYTHON'
import sys, h5py, numpy
folder = sys.argv[1]
voxels = (numpy.arange(2 * 32 * 32, dtype=numpy.uint8) % 251).reshape(2, 32, 32)
with h5py.File(folder + "/array.h5", "w") as file:
    file.create_dataset("voxels", data=voxels, chunks=(1, 16, 16), compression="gzip")
for z in range(2):
    with open(f"{folder}/slice_{z}.pgm", "wb") as file:
        file.write(b"P5\n32 32\n255\n" + voxels[z].tobytes())
PYTHON
  for z in 0 1; do
    logged opj_compress -i "$scratch/input/slice_$z.pgm" -o "$scratch/input/slices/slice_$z.jp2"
  done
}

# use ROOT PROGRAM: draws the demo's picture to ROOT/demo/head.png and reads the inputs, with PROGRAM, a path in ROOT.
use() {
  local root=$1 program=$2
  # A path of the host leads to the same file in the root folder.
  mkdir -p "$root/$(dirname "$root")"
  ln -sfn / "$root/$root"
  rm -rf "$root/demo" "$root/input"
  cp -r "$scratch/input" "$root/input"
  printf '#!/usr/bin/env bash\nsource %q\ninside %q %q "$@"\n' "$PWD/scripts/bare_debian.sh" "$root" "$program" >"$scratch/program"
  chmod +x "$scratch/program"
  logged scripts/demo.sh "$scratch/program" "$root/demo"
  logged inside "$root" "$program" convert /input/array.h5 /input/hdf5.kiln
  logged inside "$root" "$program" convert /input/slices /input/slices.kiln --spacing 1,1,1
  for store in hdf5 slices; do
    logged inside "$root" "$program" export "/input/$store.kiln" "/input/$store.raw"
  done
  cmp "$root/input/hdf5.raw" "$root/input/slices.raw" || fail "$program: HDF5 and JPEG 2000 give different voxels"
  logged inside "$root" "$program" render /demo/cranium.kiln -o /demo/scale.png --size 128x128 --scale-bar
  # The viewer serves until it is ended.
  timeout 10 unshare --pid --fork --kill-child bash -c "source scripts/bare_debian.sh; inside '$root' '$program' view /demo/cranium.kiln --no-browser --port 0" >"$scratch/log" 2>&1 || true
  grep -q 'http://' "$scratch/log" || { cat "$scratch/log"; fail "$program: the viewer does not start"; }
  # Headers name the volume, which has another path.
  if [ -n "${picture-}" ]; then
    logged "$build/tools/kiln/kiln" compare "$picture" "$root/demo/head.png"
    grep -q '^equal colours' "$scratch/log" || { cat "$scratch/log"; fail "$program: draws another picture"; }
  fi
  echo "$program: converts, draws, letters, reads HDF5 and JPEG 2000, serves a viewer"
}

# ranks ROOT COMMAND...: two ranks draw the picture that one process draws.
ranks() {
  local root=$1
  shift
  logged inside "$root" "$@" render /demo/cranium.kiln -o /demo/one.png --size 128x128
  logged inside "$root" mpirun --allow-run-as-root --oversubscribe -n 2 "$@" render /demo/cranium.kiln -o /demo/two.png --size 128x128 --stats /demo/two.json
  cmp "$root/demo/one.png" "$root/demo/two.png" || fail "$*: two ranks draw another picture"
  grep -q '"imbalance"' "$root/demo/two.json" || fail "$*: mpirun started no ranks that work together"
  echo "$*: two ranks draw the same picture"
}

step "packages for Debian"
logged cpack -G DEB -B "$out" --config "$build/CPackConfig.cmake"
rm -rf "$out/_CPack_Packages"
lintian --allow-root --fail-on error --tag-display-limit 0 "$out"/*.deb >"$out/lintian.txt" || { cat "$out/lintian.txt"; fail "lintian finds errors"; }
echo "lintian: no errors, $(grep -c '^W:' "$out/lintian.txt" || true) warnings"
step "tarball"
scripts/make_tarball.sh "$build" "$out"
tarball=$(echo "$out"/kiln-*.tar.xz)
folder=/opt/$(basename "$tarball" .tar.xz)
make_inputs

step "bare Debian"
make_bare_debian "$debian"
inside "$debian" apt-get -qq update
# install PACKAGE...: by apt, which takes each dependency from Debian, and prints what they need on disk.
install() {
  local before
  before=$(du -sb "$debian/usr" | cut -f1)
  logged inside "$debian" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"
  echo "$*: $(($(du -sb "$debian/usr" | cut -f1) - before))" | awk '{ size = $NF; $NF = ""; printf "installed %s%.1f MB with dependencies\n", $0, size / 1e6 }'
}
cp "$out"/*.deb "$debian/tmp/"
package() { (cd "$debian" && echo tmp/"$1"_*.deb | sed 's|^|/|'); }
install "$(package kiln)"
use "$debian" /usr/bin/kiln
picture=$debian/demo/head.png
[ "$(inside "$debian" kiln --version)" = "kiln $(inside "$debian" dpkg-query -W -f='${Version}' kiln | sed 's/-.*//')" ] || fail "version of the package"
dpkg-deb -c "$out"/kiln_*.deb >"$scratch/files"
for page in man1/kiln.1 man1/kiln-render.1 man5/kiln-job.5 man7/kiln-render.7; do
  # A minimal Debian leaves manuals out: the package has them.
  grep -q "/usr/share/man/$page.gz" "$scratch/files" || fail "the man page $page is missing"
done
inside "$debian" bash -c 'source /usr/share/bash-completion/completions/kiln; COMP_WORDS=(kiln rend); COMP_CWORD=1; _kiln; [ "${COMPREPLY[*]}" = render ]' || fail "the completion does not work"
install "$(package python3-kiln)"
inside "$debian" python3 - <<'PYTHON' || fail "import kiln"
import numpy, time
start = time.perf_counter()
import kiln
print(f"import kiln: {time.perf_counter() - start:.2f} s")
image = kiln.open("/demo/cranium.kiln").render(size=(128, 128), tf="ct-skin")
image.save("/demo/python.png")
assert numpy.asarray(image).shape == (128, 128, 4)
PYTHON
logged inside "$debian" kiln render /demo/cranium.kiln -o /demo/program.png --size 128x128 --tf ct-skin
cmp "$debian/demo/python.png" "$debian/demo/program.png" || fail "Python draws another picture"
install "$(package kiln-mpi)"
ranks "$debian" kiln
install g++ cmake ninja-build
install "$(package libkiln-dev)"
cp -r tests/consumer "$debian/tmp/consumer"
logged inside "$debian" sh -c 'cd /tmp/consumer && cmake -G Ninja -B build -D CMAKE_BUILD_TYPE=Release && cmake --build build && build/consumer /tmp/c.png'
echo "libkiln-dev: a program is built and runs"
logged inside "$debian" apt-get purge -y kiln kiln-mpi libkiln-dev python3-kiln
left=$(find "$debian/usr" -path "*kiln*" ! -path '*/var/tmp/*')
[ -z "$left" ] || fail "packages leave files behind: $left"

step "glibc alone"
inside "$debian" sh -c 'dpkg -L libc6 | grep -E "^/(usr/)?lib(64)?/" | while read -r file; do [ -d "$file" ] || echo "${file#/}"; done | tar -C / -cf - -T -' | tar -xf - -C "$bare"
mkdir -p "$bare/opt" "$bare/tmp"
tar -xJf "$tarball" -C "$bare/opt"
use "$bare" "$folder/bin/kiln"

step "a cluster's Open MPI"
logged inside "$debian" apt-get autoremove --purge -y
logged inside "$debian" apt-get install -y --no-install-recommends openmpi-bin
cp -r "$bare/opt/." "$debian/opt/"
! inside "$debian" sh -c 'ldconfig -p | grep libopenvdb' || fail "Debian's OpenVDB is still installed"
ranks "$debian" "$folder/bin/kiln"
# Libraries of the same names, which no program can use, in a folder of LD_LIBRARY_PATH.
mkdir "$debian/modules"
for library in "$debian/$folder"/lib*/kiln/*.so.*; do
  : >"$debian/modules/$(basename "$library")"
done
for program in kiln kiln-with-glibc; do
  logged inside "$debian" env LD_LIBRARY_PATH=/modules "$folder/bin/$program" convert /input/array.h5 /input/modules.kiln --overwrite
done

step "an older Debian"
make_bare_debian "$old" bullseye
cp -r "$bare/opt/." "$old/opt/"
inside "$old" ldd --version | sed -n 1p
! inside "$old" "$folder/bin/kiln" --version >/dev/null 2>&1 || fail "the older Debian has a new glibc"
use "$old" "$folder/bin/kiln-with-glibc"
logged inside "$old" apt-get -qq update
logged inside "$old" apt-get install -y --no-install-recommends openmpi-bin
ranks "$old" "$folder/bin/kiln-with-glibc"

step "sizes"
for file in "$out"/*.deb "$tarball"; do
  echo "$(basename "$file"): $(stat -c %s "$file" | megabytes)"
done
step "all packages are installed and used"
