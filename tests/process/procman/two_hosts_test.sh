#!/bin/bash
# Two hosts, as two network namespaces joined by a pair of virtual cables: a deputy in each, one sheriff. The drivers
# (a recording being played) run on one, SLAM on the other. The link is cut for ten seconds and comes back: nothing may
# end, nothing may be started twice, and then data and orders must flow again.
#   two_hosts_test.sh BIN-FOLDER SOURCE-FOLDER
set -u
bin=$1
root=$2
source "$root/tests/support/two_networks.sh"
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=1&recv_buf_size=2097152'

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
start_on_other "$bin/marco-procman-deputy" -i mapper --script "$folder/robot.procman" -l "$folder/mapper.log"
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
