#!/bin/bash
# Unpacks an arm64 Debian with the libraries that Marco is built with, into a folder where cross compilers find them:
#   arm64_root.sh FOLDER PACKAGE...
# By mmdebstrap, from the mirror that this machine's apt uses. Nothing of this machine changes: its dpkg knows no arm64.
set -euo pipefail
root=${1:?usage: arm64_root.sh FOLDER PACKAGE...}
shift
suite=$(. /etc/os-release && echo "$VERSION_CODENAME")
made="$root.part"
rm -rf "$made"
debs=$(mktemp -d)
trap 'rm -rf "$debs"' EXIT

sources=(/etc/apt/sources.list.d/debian.sources)
[ -e "${sources[0]}" ] || sources=(/etc/apt/sources.list)
sed '/^#/d' "${sources[@]}" | mmdebstrap --quiet --variant=extract --arch=arm64 --include="$(IFS=,; echo "$*")" \
  --skip=download/empty --skip=cleanup/apt/cache \
  --setup-hook='mkdir -p "$1/usr/lib" && ln -s usr/lib "$1/lib"' "$suite" "$made" -

# Links that update-alternatives would make.
for library in blas lapack; do
  ln -sf $library/lib$library.so.3 "$made/usr/lib/aarch64-linux-gnu/lib$library.so.3"
done
# Links and paths from / would lead into this machine.
find "$made" -lname '/*' -print0 | while IFS= read -r -d '' link; do
  ln -sfn "$(realpath -ms --relative-to="${link%/*}" "$made$(readlink "$link")")" "$link"
done
rm -rf "$made/dev"  # programs under qemu find devices here before those of this machine
cmake="$made/usr/lib/aarch64-linux-gnu/cmake"
sed -i 's|"/usr/|"${CMAKE_SYSROOT}/usr/|' "$cmake"/draco/*.cmake
sed -i '/INTERFACE_LINK_LIBRARIES/s|\([:;"]\)/usr/|\1${CMAKE_SYSROOT}/usr/|g' "$cmake"/*/*.cmake

# dpkg-shlibdeps asks this root's dpkg which package has a library, and since when: what unpacking alone does not tell it.
info="$made/var/lib/dpkg/info"
mkdir -p "$info"
: >"$made/var/lib/dpkg/status"
for deb in "$made"/var/cache/apt/archives/*.deb; do
  package=$(dpkg-deb -f "$deb" Package)
  [ "$(dpkg-deb -f "$deb" Multi-Arch)" != same ] || package+=:arm64
  dpkg-deb -e "$deb" "$debs/control"
  for kind in shlibs symbols; do
    [ ! -e "$debs/control/$kind" ] || cp "$debs/control/$kind" "$info/$package.$kind"
  done
  rm -r "$debs/control"
  dpkg-deb --fsys-tarfile "$deb" | tar -t | sed -n "s|/\$||; s|^\./lib/|./usr/lib/|; s|^\./|$(realpath -m "$root")/|p" >"$info/$package.list"
  { dpkg-deb -f "$deb" Package Status Architecture Multi-Arch Version Maintainer Description | sed '/^Package:/a Status: install ok installed'
    echo; } >>"$made/var/lib/dpkg/status"
done
echo 1 >"$info/format"
rm -rf "$made"/var/cache/apt "$root"
mv "$made" "$root"
