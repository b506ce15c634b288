# Sourced by the scripts that try Marco on a bare Debian. Wants $project; needs root, mmdebstrap and Debian's packages.
#   make_bare_root ROOT [PACKAGE...]   the smallest Debian of this suite, with these packages
#   within COMMAND...                  in $root as root, with a clean environment
skip() { echo "SKIPPED: $*"; exit 0; }
fail() { echo "FAILED: $*" >&2; exit 1; }
[ "$(id -u)" = 0 ] || skip "only root can make a bare Debian"
command -v mmdebstrap >/dev/null || skip "mmdebstrap is not installed"

clean=(/usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive)
within() { chroot "$root" "${clean[@]}" "$@"; }

make_bare_root() {
  local root=$1 sources=(/etc/apt/sources.list.d/debian.sources) include=""
  shift
  [ -e "${sources[0]}" ] || sources=(/etc/apt/sources.list)
  [ $# = 0 ] || include="--include=$(IFS=,; echo "$*")"
  sed '/^#/d' "${sources[@]}" | mmdebstrap --quiet --variant=minbase $include "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$root" -
  [ -e "$root/etc/resolv.conf" ] || cp /etc/resolv.conf "$root/etc/resolv.conf"
  apt-config dump | grep -E '^Acquire::https?::' >"$root/etc/apt/apt.conf.d/90host" || true  # a proxy
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
}

# Also the mounts, which `trap` calls in the end.
remove_bare_root() {
  local place
  for place in proc dev; do umount -R "$1/$place" 2>/dev/null || true; done
  rm -rf --one-file-system "$1"
}
