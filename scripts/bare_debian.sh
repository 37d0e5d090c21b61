# shellcheck shell=bash
# A bare Debian in a folder, for scripts that source this file; as root. Release, mirror, keys and proxy are those of the host's apt.

# make_bare_debian FOLDER [RELEASE]: FOLDER is empty. A RELEASE other than the host's comes from the same mirror.
make_bare_debian() {
  local folder=$1 host release
  # shellcheck disable=SC1091
  host=$(. /etc/os-release && echo "$VERSION_CODENAME")
  release=${2:-$host}
  command -v mmdebstrap >/dev/null || { echo "mmdebstrap was not found; scripts/install_packages.sh chroot installs it" >&2; return 1; }
  # The host's updates and security fixes belong to its own release.
  apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' | sort -u |
    if [ "$release" = "$host" ]; then cat; else sed -n "s/ $host / $release /p"; fi >"$folder.list"
  { apt-config dump Acquire | grep -E '^Acquire::(http|https|ftp|Retries)' || true; echo 'Dpkg::Use-Pty "false";'; } >"$folder.apt"
  mmdebstrap --quiet --variant=apt --aptopt="$folder.apt" --skip=cleanup/apt/lists "$release" "$folder" "$folder.list"
  rm -f "$folder.list" "$folder.apt"
}

# inside FOLDER COMMAND...: runs a command in a root folder, which needs no program but COMMAND. /proc is there for the command alone.
inside() {
  local folder=$1
  shift
  mkdir -p "$folder/proc"
  unshare --mount sh -c 'mount -t proc proc "$0/proc" && exec env -i PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 chroot "$0" "$@"' "$folder" "$@"
}
