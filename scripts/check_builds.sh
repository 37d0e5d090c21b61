#!/usr/bin/env bash
# Builds Kiln as README says, by hand, and checks what a user meets: check_builds.sh [--configure]
#   --configure  only configures: with and without each optional package, with required packages missing, and with a
#                shared library. Needs the packages of `build mpi test`, and takes seconds.
#   otherwise    in a bare Debian (mmdebstrap, as root), from a fresh clone of this repository's last commit: configures
#                with MPI's runtime but no headers, then builds with and without MPI, with and without GTest, and each
#                time installs the build and has another project find and use it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source=$PWD
# shellcheck source=scripts/bare_debian.sh
source scripts/bare_debian.sh

fail() { echo "check_builds.sh: $*" >&2; exit 1; }
step() { echo "== $*, after $SECONDS s"; }

# The two commands under "By hand" in README.md, and the one that installs.
readme_commands() { sed -n '/^cmake --preset release/s/ *#.*//p; /^cmake --install/p' README.md; }
[ "$(readme_commands | wc -l)" = 2 ] || fail "README.md: the commands of a build by hand were not found"

check_configure() {
  local scratch
  scratch=$(mktemp -d)
  # shellcheck disable=SC2064  # the folder's name of now
  trap "rm -rf '$scratch'" EXIT

  # configure NAME PATTERN [CMake's arguments]: the output has PATTERN, and no run path in the build files is unsafe.
  local known=()
  configure() {
    local name=$1 pattern=$2 expected=0
    shift 2
    [[ $name != missing* ]] || expected=1
    local code=0
    cmake --preset release -B "$scratch/$name" "${known[@]}" "$@" >"$scratch/$name.log" 2>&1 || code=1
    [ $code = $expected ] || { cat "$scratch/$name.log"; fail "$name: cmake ended with $code"; }
    # CMake wraps long lines of errors.
    tr -s ' \n' ' ' <"$scratch/$name.log" | grep -E -- "$pattern" >/dev/null || { cat "$scratch/$name.log"; fail "$name: '$pattern' was not printed"; }
    if grep -q 'COMPONENT = ' "$scratch/$name.log"; then fail "$name: OpenVDB's find module prints"; fi
    if [ $code = 0 ]; then
      if grep -oE -- '-rpath,[^ ]*' "$scratch/$name/build.ninja" | tr -d '"\\' | grep -E -- '-rpath,(:|[^$/])|:(:|$)'; then
        fail "$name: a run path has an empty or relative element"
      fi
    fi
    echo "$name: as it should be"
  }
  has() { ninja -C "$scratch/$1" -t inputs "$2" | grep "$3" >/dev/null; }

  configure all ', MPI, HDF5, OpenJPEG, NanoVDB, Beast, Freetype, pybind11 for Python [0-9.]+, GTest '
  has all kiln_tool kiln_gdcm_reader || fail "kiln_tool does not build the worker for GDCM"
  has all kiln_tool kiln_hdf5_reader || fail "kiln_tool does not build the reader of HDF5"
  has all kiln_tool kiln_openjpeg_reader || fail "kiln_tool does not build the worker for OpenJPEG"
  has all kiln_tool libkiln_view.so || fail "kiln_tool does not build the module of the viewer"
  has all kiln_tool libkiln_mpi.so || fail "kiln_tool does not build the module for MPI"
  # Answers of trial compilations and of Python stay: asking again takes 4 of a configuration's 9 s of processor time. No
  # package is found by them alone.
  local answers
  mapfile -t answers < <(grep -E '^(LIBLZMA_HAS_|BZIP2_NEED_|CMAKE_HAVE_|_?Python3_)' "$scratch/all/CMakeCache.txt")
  known=("${answers[@]/#/-D}")
  configure without_mpi 'MPI was not found \(Debian: libopenmpi-dev\)' -D CMAKE_DISABLE_FIND_PACKAGE_MPI=ON
  ! has without_mpi kiln_tool libkiln_mpi.so || fail "without MPI its module is built"
  configure without_gtest 'GTest was not found \(Debian: libgtest-dev\)' -D CMAKE_DISABLE_FIND_PACKAGE_GTest=ON
  configure without_hdf5 'HDF5 was not found \(Debian: libhdf5-dev\)' -D HDF5_READER_LIBRARY=
  ! has without_hdf5 kiln_tool kiln_hdf5_reader || fail "without HDF5 its reader is built"
  configure without_openjpeg 'OpenJPEG was not found \(Debian: libopenjp2-7-dev\)' -D OPENJPEG_READER_LIBRARY=
  ! has without_openjpeg kiln_tool kiln_openjpeg_reader || fail "without OpenJPEG its worker is built"
  configure without_nanovdb 'NanoVDB was not found \(Debian: libnanovdb-dev\)' -D NANOVDB_INCLUDE_DIR=
  configure without_beast 'Beast was not found \(Debian: libboost-iostreams-dev\)' -D BEAST_INCLUDE_DIR=
  ! has without_beast kiln_tool libkiln_view.so || fail "without Beast the viewer's module is built"
  has all kiln_tool libkiln_font.so || fail "kiln_tool does not build the module with the font"
  configure without_font 'DejaVu Sans was not found \(Debian: fonts-dejavu-core\)' -D KILN_FONT_FILE=
  ! has without_font kiln_tool libkiln_font.so || fail "without the font its module is built"
  configure without_python 'pybind11 was not found \(Debian: pybind11-dev python3-dev\)' -D PYBIND11_INCLUDE_DIR=
  configure without_any 'GDCM -- Configuring done' -D KILN_MPI=OFF -D KILN_TESTS=OFF -D KILN_HDF5=OFF -D KILN_OPENJPEG=OFF -D KILN_NANOVDB=OFF -D KILN_VIEW=OFF -D KILN_FREETYPE=OFF -D KILN_PYTHON=OFF
  configure shared 'Packages: ' -D BUILD_SHARED_LIBS=ON
  # A compiler wrapper of MPI whose headers are absent is no MPI, until they are installed.
  printf '#!/bin/sh\necho "mpi.h: No such file" >&2\nexit 1\n' >"$scratch/mpicxx"
  chmod +x "$scratch/mpicxx"
  configure headers 'MPI was not found' -D MPI_CXX_COMPILER="$scratch/mpicxx"
  ln -sf "$(command -v mpicxx)" "$scratch/mpicxx"
  configure headers ', MPI, HDF5, OpenJPEG, NanoVDB, Beast, Freetype, pybind11 for Python [0-9.]+, GTest '
  # Missing packages are named together, each with Debian's name.
  local required=(TBB Boost OpenEXR Imath glm fmt nlohmann_json PNG TIFF ZLIB JPEG BZip2 LibLZMA EXPAT CLI11 MPI Freetype GTest benchmark) disabled=() pattern='not found: '
  for package in "${required[@]}"; do
    disabled+=(-D "CMAKE_DISABLE_FIND_PACKAGE_$package=ON")
  done
  for library in XXHASH HIGHWAY BLOSC LZ4 ZSTD LIBDEFLATE HDF5_READER OPENJPEG_READER; do disabled+=(-D "${library}_LIBRARY="); done
  configure missing_all 'not found: TBB, Boost, OpenEXR, Imath, glm, fmt, nlohmann_json, PNG, TIFF, ZLIB, JPEG, BZip2, LibLZMA, EXPAT, xxHash, Highway, Blosc, LZ4, Zstd, Libdeflate, CLI11, GDCM, MPI, HDF5, OpenJPEG, NanoVDB, Beast, Freetype, DejaVu Sans, pybind11, GTest, benchmark; install them \(Debian: apt-get install libtbb-dev .* libcli11-dev libgdcm-dev libopenmpi-dev libhdf5-dev libopenjp2-7-dev libnanovdb-dev libboost-iostreams-dev libfreetype-dev fonts-dejavu-core pybind11-dev python3-dev libgtest-dev libbenchmark-dev\)' \
    "${disabled[@]}" -D GDCM_INCLUDE_DIR= -D KILN_MPI=ON -D KILN_HDF5=ON -D KILN_OPENJPEG=ON -D KILN_NANOVDB=ON -D NANOVDB_INCLUDE_DIR= -D KILN_VIEW=ON -D BEAST_INCLUDE_DIR= -D KILN_FREETYPE=ON -D KILN_FONT_FILE= -D KILN_PYTHON=ON -D PYBIND11_INCLUDE_DIR= -D KILN_TESTS=ON -D KILN_BENCH=ON
  configure missing_openvdb 'not found: OpenVDB; install them \(Debian: apt-get install libopenvdb-dev\)' \
    -D CMAKE_DISABLE_FIND_PACKAGE_OpenVDB=ON
}

check_chroot() {
  [ "$(id -u)" = 0 ] || fail "a bare Debian needs root"
  local root
  root=$(mktemp -d /var/tmp/kiln_chroot.XXXXXX)
  # shellcheck disable=SC2064
  trap "if [ \$? = 0 ]; then rm -rf --one-file-system '$root'; else echo 'the bare Debian is left in $root' >&2; fi" EXIT

  step "a bare Debian"
  make_bare_debian "$root"

  # fresh: a clone without what was built or installed before.
  fresh() {
    rm -rf "${root:?}/kiln" "${root:?}/usr/local"/*
    mkdir -p "$root/kiln"
    git archive HEAD | tar -x -C "$root/kiln"
  }
  install() { inside "$root" /kiln/scripts/install_packages.sh "$@" >/dev/null; }

  # as_readme_says NAME: README's commands, then Kiln is used as a program and as a library.
  as_readme_says() {
    step "$1"
    # A compiler cache of the host's saves the time of compiling the same files again; the commands are README's.
    (cd "$source" && readme_commands | sed 's/$/ || exit 1/') >"$root/kiln/commands"
    # Prints wall, user and system time: the processor's time is comparable on a busy machine.
    TIMEFORMAT='%R s, processor %U + %S s'
    time { inside "$root" sh -c "cd /kiln && export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=/ccache && sh commands" >"$root/kiln/log" 2>&1 ||
      { tail -50 "$root/kiln/log"; fail "$1: README's commands failed"; }; }
    inside "$root" sh -c 'cd /tmp && rm -rf used && mkdir used && cd used && kiln convert phantom:head:48x48x48 h.kiln && kiln render h.kiln -o h.png --size 48x48 --progress none' >/dev/null ||
      fail "$1: the installed program failed"
    inside "$root" sh -c 'cmake -G Ninja -S /kiln/tests/consumer -B /tmp/used/consumer -D CMAKE_BUILD_TYPE=Release && cmake --build /tmp/used/consumer && /tmp/used/consumer/consumer /tmp/used/c.png' >"$root/kiln/log" 2>&1 ||
      { tail -50 "$root/kiln/log"; fail "$1: a program that uses the installed library failed"; }
    ! grep -q 'COMPONENT = ' "$root/kiln/log" || fail "$1: find_package(kiln) prints"
    for folder in /kiln/build/release /usr/local; do
      inside "$root" bash /kiln/scripts/check_run_paths.sh $folder $([ $folder = /kiln/build/release ] || echo /kiln/build)
    done
  }
  built() { [ -e "$root/kiln/build/release/$1" ]; }

  step "packages of the build"
  fresh
  inside "$root" apt-get -qq update
  inside "$root" apt-get -qq install -y --no-install-recommends ccache >/dev/null 2>&1
  ! inside "$root" sh -c 'cd /kiln && cmake --version' >/dev/null 2>&1 || fail "the Debian is not bare"
  install build

  as_readme_says "without MPI, without GTest"
  ! built tools/lib/kiln/libkiln_mpi.so && ! built tests || fail "what is absent was built"

  # The runtime alone is no MPI; headers that are installed later are found in the same build tree.
  inside "$root" apt-get -qq install -y --no-install-recommends openmpi-bin >/dev/null 2>&1
  inside "$root" sh -c 'cd /kiln && cmake --preset release' | grep 'MPI was not found' >/dev/null || fail "MPI's runtime without headers is taken for MPI"
  install mpi
  as_readme_says "with MPI, installed later, without GTest"
  built tools/lib/kiln/libkiln_mpi.so && ! built tests || fail "the module for MPI was not built"

  install test
  fresh
  as_readme_says "with MPI, with GTest"
  built tools/lib/kiln/libkiln_mpi.so || fail "the module for MPI was not built"
  inside "$root" sh -c 'cd /kiln && ctest --preset release -L cli -R "Help|Ranks.One" --no-tests=error' >"$root/kiln/log" 2>&1 ||
    { tail -50 "$root/kiln/log"; fail "tests failed"; }

  inside "$root" apt-get -qq purge -y libopenmpi-dev openmpi-bin >/dev/null 2>&1
  inside "$root" apt-get -qq autoremove -y >/dev/null 2>&1
  fresh
  as_readme_says "without MPI, with GTest"
  ! built tools/lib/kiln/libkiln_mpi.so && built tests/kiln_unit_tests || fail "the tests were not built"
  step "all four ways are built, installed and used"
}

case ${1-} in
  --configure) [ $# = 1 ] || fail "usage: check_builds.sh [--configure]"; check_configure ;;
  '') check_chroot ;;
  *) echo "usage: scripts/check_builds.sh [--configure]" >&2; exit 2 ;;
esac
