# `./marco package`; read by ./marco, whose root, here, need, say, build and fail it uses.

# Sorted as the commits are: 0.1.0+20261125.1329.c64709cf. Without git the project's version alone.
package_version() {
  local version commit
  version=$(sed -n 's/^project(marco VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
  commit=$(TZ=UTC git -c safe.directory='*' -C "$root" log -1 --date=format-local:%Y%m%d.%H%M --format=%cd.%h --abbrev=8 2>/dev/null || true)
  echo "$version${commit:++$commit}"
}

# $1: the folder of a build, $2: where the packages go, then more options of cpack.
pack() {
  local folder=$1 out=$2 seconds
  shift 2
  MARCO_PACKAGE_VERSION=$(package_version)
  seconds=$(git -c safe.directory='*' -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)
  MARCO_PACKAGE_DATE=$(LC_ALL=C date -u -R -d "@$seconds")
  MARCO_MAINTAINER="${DEBFULLNAME:-The Marco developers} <${DEBEMAIL:-developers@marco-robot.invalid}>"
  export MARCO_PACKAGE_VERSION MARCO_PACKAGE_DATE MARCO_MAINTAINER SOURCE_DATE_EPOCH=$seconds
  mkdir -p "$out"
  cpack --config "$folder/CPackConfig.cmake" -G DEB -B "$out" -R "$MARCO_PACKAGE_VERSION" \
    -D CPACK_PACKAGE_CONTACT="$MARCO_MAINTAINER" "$@" >"$folder/package.log" 2>&1 ||
    { tail -40 "$folder/package.log" >&2; fail "cpack failed; all it said is in $folder/package.log"; }
  rm -rf "$out/_CPack_Packages"
}

# What dpkg-shlibdeps and strip have to know of another architecture, found before this machine's own.
for_arm64() {
  local tools="$root/build/arm64/tools" debian="$root/build/arm64_root"
  mkdir -p "$tools"
  printf '#!/bin/sh\nexec /usr/bin/dpkg-shlibdeps --admindir=%s "$@"\n' "$debian/var/lib/dpkg -l$debian/usr/lib/aarch64-linux-gnu" \
    >"$tools/dpkg-shlibdeps"
  chmod +x "$tools/dpkg-shlibdeps"
  export PATH="$tools:$PATH" DEB_HOST_ARCH=arm64 STRIP=aarch64-linux-gnu-strip
}

run_package() {
  need_checkout
  local out="" arch
  arch=$(dpkg --print-architecture)
  while [ $# -gt 0 ]; do
    case $1 in
      --arch) value_of "$@"; arch=$2; shift 2 ;;
      --*) unknown option "$1" --arch ;;
      *) [ -z "$out" ] || fail "one folder, please"; out=$1; shift ;;
    esac
  done
  out="${out:-$here/out/packages}"
  need viewer simulator network bridge page python package
  if [ "$arch" = "$(dpkg --print-architecture)" ]; then
    build release programs libraries
    say "packing"
    pack "$root/build/release" "$out"
  elif [ "$arch" = arm64 ]; then
    build_arm64 programs libraries
    say "packing"
    for_arm64
    pack "$root/build/arm64" "$out"
  else
    fail "packages are made for $(dpkg --print-architecture) and arm64"
  fi
  (cd "$out" && du -h -- *_"$(package_version)"_*.deb) >&2
}

# The same libraries as here, of arm64; then ninja's targets.
build_arm64() {
  local name packages=()
  need cross
  install_packages
  if [ ! -d "$root/build/arm64_root" ]; then
    for name in core viewer simulator bridge page python test; do packages+=(${packages_for[$name]//|/ }); done
    mapfile -t packages < <(printf '%s\n' "${packages[@]}" | grep -E '^lib.*-dev$|^(nlohmann-json3|pybind11|python3)-dev$' | sort -u)
    say "unpacking an arm64 Debian into build/arm64_root"
    "$root/tools/arm64_root.sh" "$root/build/arm64_root" libc6-dev libstdc++-12-dev "${packages[@]}"
  fi
  build arm64 "$@"
}
