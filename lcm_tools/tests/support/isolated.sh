#!/bin/bash
# Runs a test where its LCM multicast reaches nobody and nobody's reaches it, with state and runtime folders of its own: in a
# network namespace that has only the loopback device. Where the system forbids namespaces: on a port of its own with ttl 0,
# which it holds until its last process ends, and with a second port for a second network.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/namespaces.sh"
if [ -n "$own" ]; then
  export MARCO_ISOLATED=namespace
  exec unshare $own bash -c '
    ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo &&
      mkdir -p /tmp/marco-isolated && mount -t tmpfs -o mode=700 marco /tmp/marco-isolated && mkdir -m 700 /tmp/marco-isolated/{run,state} &&
      XDG_RUNTIME_DIR=/tmp/marco-isolated/run XDG_STATE_HOME=/tmp/marco-isolated/state exec "$@"' isolated "$@"
fi
if ! ip route get 239.255.76.67 >/dev/null 2>&1; then
  echo "SKIPPED: no network namespaces here, and no route for multicast (ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo)"
  exit 77
fi
for ((port = 21000; port < 31000; ++port)); do
  folder=/tmp/marco-isolated-$(id -u)-$port
  mkdir -p -m 700 "$folder" && [ -O "$folder" ] || continue
  exec {lease}>"$folder/lease" || continue
  flock -n "$lease" && break
  exec {lease}>&-
done
rm -rf "$folder"/{run,state}
mkdir -m 700 "$folder"/{run,state}
export MARCO_ISOLATED=port LCM_DEFAULT_URL="udpm://239.255.76.67:$port?ttl=0"
export MARCO_SECOND_URL="udpm://239.255.76.67:$((port + 10000))?ttl=0"
export XDG_RUNTIME_DIR=$folder/run XDG_STATE_HOME=$folder/state
exec "$@"
