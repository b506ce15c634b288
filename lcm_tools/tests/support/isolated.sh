#!/bin/bash
# Runs a test where its LCM multicast can reach nobody: in a network namespace of its own with only
# the loopback device. Where the system forbids namespaces: a private port and ttl 0.
set -u
if unshare -rmn true 2>/dev/null; then
  exec unshare -rmn bash -c '
    ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"' isolated "$@"
fi
export LCM_DEFAULT_URL="udpm://239.255.76.67:$((20000 + $$ % 20000))?ttl=0"
exec "$@"
