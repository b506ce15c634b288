#!/bin/bash
# Wi-Fi goes and comes back: lasers and SLAM live on and say what mends it; a base, which nobody could stop any more, ends. Run in
# a network of its own (isolated.sh), whose route this test takes away.
# Usage: network_gone.sh BIN_FOLDER PROJECT_FOLDER
set -u
bin=$(cd "$1" && pwd)
root=$(cd "$2" && pwd)
export LCM_DEFAULT_URL="udpm://239.255.76.67:7667?ttl=0"
ip route show 224.0.0.0/4 2>/dev/null | grep -q lo || { echo 'SKIPPED: no network namespace of its own'; exit 0; }
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; wait; rm -rf "$folder"' EXIT
fail() { echo "FAILED: $1"; tail -n 20 "$folder"/*.log; exit 1; }
wait_for() { for ((i = 0; i < 200; ++i)); do grep -qE "$2" "$folder/$1.log" && return; sleep 0.1; done; fail "$1 did not say '$2'"; }

# The simulator must outlive the network: its laser and base are asked for on pseudo-terminals alone.
"$bin/marco-sim" --config "$root/config/robots/create.toml" --world "$root/config/worlds/lab.toml" --start 2 3 0 --ports "$folder/ports" \
  --lcm-url memq:// >"$folder/sim.log" 2>&1 &
for ((i = 0; i < 200; ++i)); do [ -e "$folder/ports/laser" ] && [ -e "$folder/ports/base" ] && break; sleep 0.1; done
"$bin/marco-ldlidar" --device "$folder/ports/laser" >"$folder/laser.log" 2>&1 &
laser=$!
"$bin/marco-slam" >"$folder/slam.log" 2>&1 &
slam=$!
"$bin/marco-create" --device "$folder/ports/base" >"$folder/base.log" 2>&1 &
base=$!
wait_for laser "is open"
wait_for base "is open"
sleep 2

ip route del 224.0.0.0/4 dev lo
mends='no route leads to 239.255.76.67.*'
for one in laser slam base; do
  wait_for $one "could not send on .*$mends"
  wait_for $one "sudo ip link set lo multicast on && sudo ip route add 224.0.0.0/4 dev lo"
done
wait $base
[ $? = 1 ] || fail "the base did not end with 1"
sleep 3
kill -0 $laser || fail "the laser's process ended"
kill -0 $slam || fail "SLAM ended"
[ "$(grep -c 'could not send' "$folder/laser.log")" = 1 ] || fail "it repeats itself"

ip route add 224.0.0.0/4 dev lo
wait_for laser "LCM can send again; [0-9]+ messages were not sent"
wait_for slam "LCM can send again"
kill -TERM $laser
wait $laser || fail "the laser's process ended with $?"
echo "lasers and SLAM live on without a network; a base ends"
