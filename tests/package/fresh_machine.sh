#!/bin/bash
# README's two commands on machines that have nothing: `./marco demo --batch` and `./marco test` from a clone on a bare Debian,
# then `./marco demo`, live. As root, with network; an hour on two cores for each kind of machine.
# usage: fresh_machine.sh [--out DIR] [--ccache DIR] [--busy] [--times N] [KIND...]
#   KIND      root       root in a chroot, who may make network namespaces, but no user namespaces
#             user       an ordinary user with sudo, and user namespaces
#             container  root with what a container leaves of root's rights, and no namespaces
#             default: all three, one after the other
#   --out     for what the commands print, and results.txt (default: out/fresh_machine)
#   --ccache  a compiler cache that the machines share (ccache is installed then); without it each builds everything
#   --busy    a program beside them keeps one core busy
#   --times   so often the test is run (default 1)
set -euo pipefail
project="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
. "$project/tests/package/bare_root.sh"
arguments=("$@") out=$PWD/out/fresh_machine cache="" busy=no times=1 kinds=()
while [ $# -gt 0 ]; do
  case $1 in
    --out) out=$2; shift 2 ;;
    --ccache) cache=$(realpath "$2"); shift 2 ;;
    --busy) busy=yes; shift ;;
    --times) times=$2; shift 2 ;;
    root | user | container) kinds+=("$1"); shift ;;
    *) sed -n '4,/^set/s/^# //p' "$0"; exit 2 ;;
  esac
done
if [ "${BARE_DEBIAN:-}" != inside ]; then BARE_DEBIAN=inside exec unshare -m --propagation private "$0" "${arguments[@]}"; fi
mkdir -p "$out"
out=$(cd "$out" && pwd)
: >"$out/results.txt"
work=$(mktemp -d)
root=$work/debian
started=()
finish() {
  [ ${#started[@]} = 0 ] || kill "${started[@]}" 2>/dev/null || true
  remove_bare_root "$root"
  rm -rf "$work"
}
trap finish EXIT

# The network of the machines: an interface that leads nowhere, and apt through a proxy whose one end lies in it.
unshare -n sleep infinity &
network=$!
started+=($network)
sleep 0.5
in_network() { nsenter --net="/proc/$network/ns/net" "$@"; }
in_network ip link set lo up
in_network ip link add eth0 type veth peer name nowhere
in_network ip address add 10.79.0.2/24 dev eth0
in_network ip link set nowhere up
in_network ip link set eth0 up multicast on
in_network ip route add default dev eth0
cat >"$work/proxy.py" <<'PY'
"""An HTTP proxy that listens on 127.0.0.1:3142 of the network of a process, and asks from this one. usage: proxy.py PID"""
import ctypes, http.server, shutil, socketserver, sys, urllib.error, urllib.request

def enter(network):
    if ctypes.CDLL(None).setns(network.fileno(), 0x40000000) != 0:
        sys.exit("cannot enter the network")

class Proxy(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    def do_GET(self):
        kept = {name: value for name, value in self.headers.items() if name.lower() in ("range", "if-modified-since", "if-range")}
        try:
            answer = urllib.request.urlopen(urllib.request.Request(self.path, headers=kept), timeout=60)
        except urllib.error.HTTPError as error:
            answer = error
        body = answer.read()
        self.send_response(answer.status)
        for name in ("Content-Type", "Last-Modified", "Content-Range"):
            if answer.headers[name]: self.send_header(name, answer.headers[name])
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)
    def log_message(self, *_): pass

class Server(socketserver.ThreadingMixIn, socketserver.TCPServer):
    daemon_threads = allow_reuse_address = True

here = open("/proc/self/ns/net")
enter(open(f"/proc/{sys.argv[1]}/ns/net"))
server = Server(("127.0.0.1", 3142), Proxy)
enter(here)
server.serve_forever()
PY
python3 "$work/proxy.py" $network &
started+=($!)
if [ $busy = yes ]; then
  while :; do :; done &
  started+=($!)
fi

# As the kind of machine has it: $kind, then a command. Capabilities are those that a container has by default.
as_on() {
  local kind=$1 enter=(nsenter "--net=/proc/$network/ns/net") tree
  shift
  case $kind in
    root) "${enter[@]}" chroot "$root" "${clean[@]}" "$@" ;;
    user)  # a root of its own, not a chroot: there users may make namespaces
      "${enter[@]}" unshare -m bash -c 'mount --rbind "$1" "$1" && cd "$1" && mkdir -p old && pivot_root . old && shift &&
        umount -l /old && exec /usr/bin/setpriv --reuid=1234 --regid=1234 --clear-groups "$@"' entered \
        "$root" "${clean[@]}" HOME=/home/user USER=user "$@" ;;
    container)
      local kept=-all,+chown,+dac_override,+fowner,+fsetid,+kill,+setgid,+setuid,+setpcap,+net_bind_service,+net_raw,+sys_chroot,+mknod,+audit_write,+setfcap
      "${enter[@]}" chroot "$root" /usr/bin/setpriv --bounding-set $kept --inh-caps -all "${clean[@]}" "$@" ;;
  esac
}

# $1 kind, $2 name of the log, then a ./marco command.
try() {
  local kind=$1 log="$out/$1_$2.txt" said=0 begin=$SECONDS
  shift 2
  as_on "$kind" sh -c 'cd /srv/marco && exec "$@"' try "$@" >"$log" 2>&1 </dev/null || said=$?
  printf '%-9s %-40s exit %d, %d min\n' "$kind" "$*" $said $(((SECONDS - begin + 30) / 60)) | tee -a "$out/results.txt"
  sed -n '/== skipped, and why/,$p' "$log" | tee -a "$out/results.txt"
  if [ $said != 0 ]; then tail -n 40 "$log"; failed=yes; fi
}

if [ -n "$cache" ]; then
  clean+=(CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=/ccache CCACHE_SLOPPINESS=pch_defines,time_macros)
fi
failed=no
for kind in "${kinds[@]:-root}" $([ ${#kinds[@]} -gt 0 ] || echo user container); do
  packages=(git ca-certificates)
  [ "$kind" != user ] || packages+=(sudo)
  [ -z "$cache" ] || packages+=(ccache)
  make_bare_root "$root" "${packages[@]}"
  echo 'Acquire::http::Proxy "http://127.0.0.1:3142";' >"$root/etc/apt/apt.conf.d/91proxy"
  home=$root/root
  if [ "$kind" = user ]; then
    home=$root/home/user
    within useradd -u 1234 -m user
    echo 'user ALL=(ALL) NOPASSWD: ALL' >"$root/etc/sudoers.d/user"
  fi
  git clone -q --no-hardlinks "$project" "$root/srv/marco"
  if [ -n "$cache" ]; then
    mkdir -p "$root/ccache"
    mount --bind "$cache" "$root/ccache"
    [ "$kind" != user ] || chown -R 1234 "$cache"
  fi
  [ "$kind" != user ] || chown -R 1234:1234 "$home" "$root/srv/marco"
  try $kind demo_batch ./marco demo --batch
  for ((round = 1; round <= times; ++round)); do try $kind test_$round ./marco test; done
  try $kind demo ./marco demo
  [ -z "$cache" ] || umount "$root/ccache"
  remove_bare_root "$root"
done
echo "logs: $out"
[ $failed = no ] || fail "a command failed"
