#!/usr/bin/env bash
# Makes of a build a tarball that runs wherever it is unpacked, on machines with glibc alone: make_tarball.sh BUILD OUT
# OUT/kiln-VERSION-linux-MACHINE.tar.xz holds the program, its modules and workers, the libraries that these link, and the
# libraries' licences. MPI is not among the libraries: a cluster's own Open MPI is loaded.
# Paths of libraries are DT_RPATH, which the loader obeys before LD_LIBRARY_PATH: modules of a cluster do not replace the
# libraries that Kiln was tested with. For machines with an older glibc there is a second command, which runs the same
# files with the loader and the glibc of the machine that built the tarball.
set -euo pipefail

[ $# = 2 ] && [ -e "$1/cmake_install.cmake" ] || { echo "usage: make_tarball.sh BUILD OUT" >&2; exit 2; }
build=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:.*=//p' "$build/CMakeCache.txt")
name=kiln-$version-linux-$(uname -m)
root=$out/$name
rm -rf "$root"

for component in program mpi; do
  cmake --install "$build" --component $component --prefix "$root" --strip >/dev/null
done
modules=$(dirname "$(find "$root" -name libkiln_view.so)")
[ -e "$modules/kiln_gdcm_reader" ] || { echo "make_tarball.sh: $build: has no modules; configure with -DKILN_VIEW=ON" >&2; exit 1; }
workers=("$modules"/kiln_*_reader)
linked=()  # modules, but for MPI's
for module in "$modules"/libkiln_*.so; do
  [[ $module == */libkiln_mpi.so ]] || linked+=("$module")
done
documents=$root/share/doc/kiln
licences=$documents/licences
mkdir -p "$licences"

package_of() {  # Debian has moved /lib to /usr/lib, but its lists of files have not
  { dpkg -S "$1" 2>/dev/null || dpkg -S "/usr$1" 2>/dev/null || dpkg -S "${1#/usr}"; } | sed -n '1s/:.*//p'
}
# add_licence PACKAGE
add_licence() {
  cp -L "/usr/share/doc/$1/copyright" "$licences/$1"
  dpkg-query -W -f='${Package} ${Version}\n' "$1" | sed 's/:[^ ]* / /' >>"$licences/versions"
}

# The libraries of the program, the workers and the modules, and the libraries of these.
while read -r library; do
  package=$(package_of "$library")
  case $package in
    libc6) continue ;;
    '') echo "make_tarball.sh: $library: belongs to no package, so that its licence is unknown" >&2; exit 1 ;;
  esac
  cp -L "$library" "$modules/"
  [ -e "$licences/$package" ] || add_licence "$package"
done < <(ldd "$root/bin/kiln" "${workers[@]}" "${linked[@]}" | awk '$2 == "=>" { print $3 }' | sort -u)
# Libraries that are headers are inside the program.
for header in nanovdb/NanoVDB.h glm/glm.hpp nlohmann/json.hpp CLI/CLI.hpp boost/beast/http.hpp; do
  add_licence "$(package_of "/usr/include/$header")"
done

# The loader searches the paths of whichever file brings a library in, so that only Kiln's files need one.
for file in "${workers[@]}" "$modules"/libkiln_*.so; do
  patchelf --force-rpath --set-rpath "\$ORIGIN" "$file"
done
patchelf --force-rpath --set-rpath "\$ORIGIN/$(realpath --relative-to="$root/bin" "$modules")" "$root/bin/kiln"
chmod 644 "$modules"/*.so*

# The newest version of glibc that any file asks for.
needed=$(for file in "$root/bin/kiln" "$modules"/*; do objdump -T "$file"; done | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -1)

# The loader and the libraries of glibc, with which a program of any age is run. Workers are started through the loader, too.
glibc=$modules/glibc
mkdir "$glibc"
loader=$(readelf -lW "$root/bin/kiln" | sed -n 's/.*program interpreter: \(.*\)\]/\1/p')
for library in $(dpkg -L libc6 | grep -E '/(libc|libm|libmvec|libdl|libpthread|librt|libresolv|libutil|libnss_(files|dns))\.so\.[0-9]+$') "$loader"; do
  cp -L "$library" "$glibc/"
done
add_licence libc6
font=$(sed -n 's/^KILN_FONT_FILE:.*=//p' "$build/CMakeCache.txt")
[ ! -e "$font" ] || add_licence "$(package_of "$font")"
sort -u -o "$licences/versions" "$licences/versions"
# Debian's files refer to one copy of each common licence.
mkdir "$licences/common-licenses"
for text in $(grep -hoE '/usr/share/common-licenses/[A-Za-z0-9.-]*[A-Za-z0-9]' -r "$licences" | sort -u); do
  [ ! -e "$text" ] || cp -L "$text" "$licences/common-licenses/"
done
loader=$(basename "$loader")
# starter FILE PROGRAM UP: a script that runs PROGRAM, a path from the tarball's folder on, with the loader of the tarball.
# UP leads from FILE's folder to the tarball's. The loader knows the program by an empty name, which the colon ends: without
# the program's own path the folder of glibc comes first, and in it the scripts that start workers.
up=$(realpath --relative-to="$glibc" "$root")
starter() {
  cat >"$1" <<SCRIPT
#!/bin/sh
# Runs $2 with the glibc of this folder, where the machine's own is older than ${needed/_/ }.
here=\$(dirname "\$(readlink -f "\$0")")
root=\$here/$3
glibc=\$root/$(realpath --relative-to="$root" "$glibc")
exec "\$glibc/$loader" --argv0 "\$0" --inhibit-rpath : \\
  --library-path "\$glibc:\$root/$(realpath --relative-to="$root" "$modules")\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}" "\$root/$2" "\$@"
SCRIPT
  chmod 755 "$1"
}
starter "$root/bin/kiln-with-glibc" bin/kiln ..
for worker in "${workers[@]}"; do
  starter "$glibc/$(basename "$worker")" "$(realpath --relative-to="$root" "$worker")" "$up"
done

cat >"$root/README" <<TEXT
Kiln $version for Linux on $(uname -m)

Unpack the folder anywhere and run bin/kiln. It needs ${needed/_/ } or later (ldd --version). On an older machine run
bin/kiln-with-glibc instead, which brings its own. Nothing else of the machine is used.

On a cluster, load Open MPI 3 or later (libmpi.so.40) and start the ranks: mpirun -n 4 bin/kiln render ...
Without Open MPI, Kiln works on one machine.

Manual: share/doc/kiln/manual, share/man. Licences of the libraries in $(realpath --relative-to="$root" "$modules"): share/doc/kiln/licences.
TEXT
"$(dirname "${BASH_SOURCE[0]}")/check_run_paths.sh" "$root" "$build"
tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner -cf - "$name" | xz -T0 -5 >"$root.tar.xz"
echo "$root.tar.xz: $(stat -c %s "$root.tar.xz") bytes, unpacked $(du -sb "$root" | cut -f1), needs $needed"
