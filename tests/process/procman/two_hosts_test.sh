#!/bin/bash
# Two hosts, as two network namespaces joined by a pair of virtual cables: a deputy in each, one sheriff. The drivers
# (a recording being played) run on one, SLAM on the other. The link is cut for ten seconds and comes back: nothing may
# end, nothing may be started twice, and then data and orders must flow again.
#   two_hosts_test.sh BIN-FOLDER SOURCE-FOLDER
set -u
bin=$1
root=$2
if [ "${3:-}" != inside ]; then
  if ! unshare -rn true 2>/dev/null; then
    echo 'SKIPPED: this system forbids network namespaces'
    exit 0
  fi
  exec unshare -rn "$0" "$bin" "$root" inside
fi
for program in lcm-logplayer nsenter pgrep; do
  if ! command -v $program >/dev/null; then
    echo "SKIPPED: $program is not installed"
    exit 0
  fi
done

folder=$(mktemp -d)
export XDG_RUNTIME_DIR=$folder/run XDG_STATE_HOME=$folder/state
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152'
started=()
finish() {
  kill -TERM "${started[@]}" 2>/dev/null
  sleep 1
  kill -KILL "${started[@]}" 2>/dev/null
  rm -rf "$folder"
}
trap finish EXIT
fail() {
  echo "FAILED: $*"
  tail -n 30 "$folder"/*.log
  exit 1
}

# The second host lives as long as this sleep.
unshare -n sleep 300 &
host_b=$!
started+=("$host_b")
on_b() { nsenter --net="/proc/$host_b/ns/net" "$@"; }
for _ in $(seq 100); do
  [ "$(readlink "/proc/$host_b/ns/net")" != "$(readlink /proc/self/ns/net)" ] && break
  sleep 0.02
done
if ! ip link add cable_a type veth peer name cable_b netns "$host_b" 2>/dev/null; then
  echo 'SKIPPED: this system has no virtual cables (veth)'
  exit 0
fi
ip link set lo up
on_b ip link set lo up
ip address add 10.77.0.1/24 dev cable_a
on_b ip address add 10.77.0.2/24 dev cable_b
connect() {
  ip link set cable_a up multicast on && ip route replace 224.0.0.0/4 dev cable_a
}
on_b ip link set cable_b up multicast on
on_b ip route replace 224.0.0.0/4 dev cable_b
connect || fail 'cannot join the two hosts'

"$bin/marco-simulate" --world "$root/config/worlds/lab.toml" --tour "$root/config/tours/lab.toml" --seed 1 \
  --out "$folder/lab.lcm" >/dev/null || fail 'cannot simulate'
cat >"$folder/robot.procman" <<TEXT
group "drivers" { cmd "player" { exec = "lcm-logplayer $folder/lab.lcm"; deputy = "base"; } }
group "mapping" { cmd "slam" { exec = "$bin/marco-slam"; deputy = "mapper"; } }
script "go" {
  start cmd "slam" wait "running" timeout ms 10000 then abort;
  start cmd "player" wait publishing "LIDAR" timeout ms 10000 then abort;
  wait cmd "slam" publishing "SLAM_POSE" timeout ms 10000 then abort;
  wait ms 12000;
  wait cmd "slam" publishing "SLAM_POSE" timeout ms 10000 then abort;
  restart cmd "slam" wait publishing "SLAM_POSE" timeout ms 10000 then abort;
  stop everything wait "stopped" timeout ms 10000 then abort;
}
TEXT

"$bin/marco-procman-deputy" -i base --script "$folder/robot.procman" -l "$folder/base.log" &
started+=($!)
nsenter --net="/proc/$host_b/ns/net" "$bin/marco-procman-deputy" -i mapper --script "$folder/robot.procman" \
  -l "$folder/mapper.log" &
started+=($!)
sleep 1

timeout 90 "$bin/marco-procman-sheriff" -n "$folder/robot.procman" go >"$folder/sheriff.log" 2>&1 &
sheriff=$!
started+=("$sheriff")
for _ in $(seq 300); do
  grep -q 'wait ms 12000' "$folder/sheriff.log" && break
  kill -0 "$sheriff" 2>/dev/null || fail 'the stack on two hosts did not start'
  sleep 0.1
done
echo 'drivers on one host, SLAM on the other'
# Of our own: a keeper's socket lies in our folder, and the command is its only child.
pid_of() { pgrep -P "$(pgrep -f "marco-procman-keeper $1 $folder")"; }
player=$(pid_of player)
slam=$(pid_of slam)
[ -n "$player" ] && [ -n "$slam" ] || fail 'player or SLAM is not there'

ip link set cable_a down
echo 'the link is cut'
sleep 10
kill -0 "$player" 2>/dev/null || fail 'the player ended with the link'
kill -0 "$slam" 2>/dev/null || fail 'SLAM ended with the link'
connect || fail 'cannot join the two hosts again'
echo 'the link is back'

wait "$sheriff" || fail 'data or orders do not flow again'
[ "$(grep -c "start 'player'" "$folder/base.log")" = 1 ] || fail 'the player was started twice'
[ "$(grep -c "start 'slam'" "$folder/mapper.log")" = 2 ] || fail 'SLAM was not started twice: at first, and by order'
kill -0 "$player" "$slam" 2>/dev/null && fail 'a stopped command is still there'
echo 'data and orders flow again; nothing ended, nothing was started twice'
