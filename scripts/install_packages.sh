#!/usr/bin/env bash
# Installs the Debian packages that are missing: install_packages.sh [build|mpi|python|test|browser|bench|demo|pictures|peers|chroot|packages ...], `build` if nothing is named.
# Where all are there it changes nothing and needs no root. Debian 12 and its successors.
set -euo pipefail

# blosc, zlib, boost and pkg-config are what OpenVDB's own FindOpenVDB.cmake asks for. With boost come Beast's headers.
build=(g++ cmake ninja-build pkg-config
       libopenvdb-dev libnanovdb-dev libtbb-dev libboost-iostreams-dev libblosc-dev liblz4-dev libzstd-dev libdeflate-dev zlib1g-dev
       libopenexr-dev libimath-dev libpng-dev libtiff-dev libjpeg-dev libbz2-dev liblzma-dev libexpat1-dev libgdcm-dev libhdf5-dev libopenjp2-7-dev libfreetype-dev fonts-dejavu-core libxxhash-dev libhwy-dev
       libglm-dev libfmt-dev libcli11-dev nlohmann-json3-dev)
mpi=(libopenmpi-dev openmpi-bin)
python=(pybind11-dev python3-dev python3-numpy)
demo=(invesalius-examples tar)
# Volumes of scripts/pictures.sh: a head, brains and an atlas.
pictures=("${demo[@]}" mricron-data python3-numpy)
# Tests hold Kiln's files and its schema against other programs, draw the manual's pictures, and forward a port by ssh.
test=(libgtest-dev openimageio-tools ffmpeg lowdown libopenjp2-tools "${python[@]}" "${pictures[@]}" python3-pytest
      openssh-server openssh-client
      python3-jsonschema python3-zarr python3-h5py python3-mrcfile python3-nibabel python3-tifffile python3-openvdb python3-vtk9)
# Tests of the page of kiln view (tests/browser/viewer.mjs).
browser=(chromium nodejs npm)
bench=(libbenchmark-dev)
# Other renderers, to compare with.
peers=(libvolpack1-dev libopenvdb-tools python3-vtk9 python3-numpy xvfb xauth libgl1-mesa-dri)
# A bare Debian, for scripts/check_builds.sh and check_packages.sh.
chroot=(mmdebstrap)
# Packages, for scripts/check_packages.sh.
packages=(dpkg-dev file lintian patchelf xz-utils lowdown libopenjp2-tools python3-h5py)

[ $# -gt 0 ] || set -- build
wanted=()
for group in "$@"; do
  case $group in
    build) wanted+=("${build[@]}") ;;
    mpi) wanted+=("${mpi[@]}") ;;
    python) wanted+=("${python[@]}") ;;
    test) wanted+=("${test[@]}") ;;
    browser) wanted+=("${browser[@]}") ;;
    bench) wanted+=("${bench[@]}") ;;
    demo) wanted+=("${demo[@]}") ;;
    pictures) wanted+=("${pictures[@]}") ;;
    peers) wanted+=("${peers[@]}") ;;
    chroot) wanted+=("${chroot[@]}") ;;
    packages) wanted+=("${packages[@]}") ;;
    *) echo "install_packages.sh: '$group' is not one of build mpi python test browser bench demo pictures peers chroot packages" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${wanted[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  # A package of several architectures answers once for each.
  case $status in *installed*) [[ $status != *not-installed* ]] || missing+=("$package") ;; *) missing+=("$package") ;; esac
done
[ ${#missing[@]} -gt 0 ] || exit 0

root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "install_packages.sh: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
  root=(sudo)
fi
echo "Installing ${missing[*]}"
# sudo drops the environment, so env sets the variable behind it.
apt=("${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq)
"${apt[@]}" update
"${apt[@]}" install -y --no-install-recommends "${missing[@]}"
