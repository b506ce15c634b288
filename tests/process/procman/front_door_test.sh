#!/bin/bash
# ./marco run while another run is open: the second one says so and touches nothing, its checkpoint least of all.
#   front_door_test.sh BIN-FOLDER SOURCE-FOLDER      (within lcm_tools/tests/support/isolated.sh)
set -u
folder=$(mktemp -d)
started=()
trap 'for pid in "${started[@]}"; do kill "$pid" 2>/dev/null; wait "$pid" 2>/dev/null; done; rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*"; cat "$folder"/*.log 2>/dev/null; exit 1; }
export XDG_RUNTIME_DIR="$folder/runtime" XDG_STATE_HOME="$folder/state" MARCO_RUN="$folder/run"

# The front door's own function, with the programs that are to be tested.
eval "$(sed -n '/^run_script()/,/^}/p; /^set_lcm_url()/,/^}/p; /^choose_map()/,/^}/p; /^say()/,/^}/p; /^set_run_folder()/p' "$2/marco")"
declare -f run_script >/dev/null || fail 'the front door has no run_script'
root="$2" bin="$1" name=./marco here="$folder"
mkdir -p "$MARCO_RUN"
cat >"$folder/robot.procman" <<TEXT
cmd "base" { exec = "bash -c 'echo \$\$ >$folder/base.pid; mkdir -p $MARCO_RUN/recordings/now; touch $MARCO_RUN/recordings/now/live.lcm.00; exec sleep 1000'"; deputy = "localhost"; }
cmd "spare" { exec = "sleep 1000"; deputy = "localhost"; }
script "drive" { start cmd "base" wait "running"; }
TEXT

echo 'the old map' >"$MARCO_RUN/slam.checkpoint"
# A service manager kills the sheriff when its heartbeat stops.
python3 -c 'import socket, sys
ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
ear.bind(sys.argv[1])
while True: print(ear.recv(4096).decode(), flush=True)' "$folder/notify" >"$folder/beats.txt" &
started+=("$!")
for _ in $(seq 100); do [ -S "$folder/notify" ] && break; sleep 0.05; done
(export NOTIFY_SOCKET="$folder/notify"; run_script "$folder/robot.procman" drive) >"$folder/first.log" 2>&1 </dev/null &
first=$!
started+=("$first")
for _ in $(seq 400); do grep -q 'these keep running: base' "$folder/first.log" && break; sleep 0.1; done
grep -q 'these keep running: base' "$folder/first.log" || fail 'the first run did not start'
[ ! -e "$MARCO_RUN/slam.checkpoint" ] || fail 'a new run begins with the old map'
old=$(sed -n 's/.*MARCO_RESUME=\([^ ]*\) .*/\1/p' "$folder/first.log")
[ "$(cat "$old")" = 'the old map' ] || fail 'the old map is gone, or where it is was not said'
for _ in $(seq 100); do [ -s "$folder/base.pid" ] && break; sleep 0.05; done  # it runs before it writes
base=$(cat "$folder/base.pid")
beats=$(wc -l <"$folder/beats.txt")
sleep 2
[ "$(wc -l <"$folder/beats.txt")" -ge $((beats + 4)) ] || fail 'the sheriff has no heartbeat'

# One command of a run is given orders from outside, as the page does.
order() { "$bin/marco-procman-order" "$@" >>"$folder/orders.log" 2>&1; }
order restart base || fail 'base was not restarted'
for _ in $(seq 100); do [ "$(cat "$folder/base.pid")" != "$base" ] && [ -s "$folder/base.pid" ] && break; sleep 0.05; done
[ "$(cat "$folder/base.pid")" != "$base" ] && ! kill -0 "$base" 2>/dev/null || fail 'base is the same after a restart'
base=$(cat "$folder/base.pid")
order start spare || fail 'spare was not started'
order list || fail 'the commands are not listed'
grep -qE '^spare +Running +localhost' "$folder/orders.log" || fail 'spare does not run'
order stop spare || fail 'spare was not stopped'
order list
[ "$(grep -cE '^spare +Stopped' "$folder/orders.log")" = 1 ] || fail 'spare still runs'
order start nobody && fail 'a command that there is not was started'
grep -q 'there is no command "nobody"' "$folder/orders.log" || fail 'the refusal does not say why'
kill -0 "$base" || fail 'an order to another command disturbed base'
echo 'single commands obey orders from outside'

touch "$MARCO_RUN/slam.checkpoint"  # now it is the live run's
(run_script "$folder/robot.procman" drive) >"$folder/second.log" 2>&1 </dev/null && fail 'a second run was let in'
grep -q "a deputy 'localhost' is already active here and runs base" "$folder/second.log" || fail 'the second run does not say why'
[ -e "$MARCO_RUN/slam.checkpoint" ] || fail 'the second run deleted the checkpoint of the live one'
kill -0 "$base" 2>/dev/null && [ "$(cat "$folder/base.pid")" = "$base" ] || fail 'the first run was disturbed'
echo 'a second run touched nothing'

kill -TERM "$first"
wait "$first" || fail 'the first run ended with an error'
kill -0 "$base" 2>/dev/null && fail 'a command outlived the run'
grep -q 'stopping: base' "$folder/first.log" || fail 'what still ran was not said'
grep -q "recorded: $MARCO_RUN/recordings/now/live.lcm.00" "$folder/first.log" || fail 'where the recording lies was not said'
echo 'SIGTERM stopped all, and said what and where'

echo 'the new map' >"$MARCO_RUN/slam.checkpoint"
MARCO_RESUME=$old choose_map
[ "$(cat "$MARCO_RUN/slam.checkpoint")" = 'the old map' ] && grep -q 'the new map' "$MARCO_RUN"/slam.checkpoint.* || fail 'the old map is not resumed, or the new one is lost'
MARCO_RESUME=$MARCO_RUN/slam.checkpoint choose_map
[ "$(cat "$MARCO_RUN/slam.checkpoint")" = 'the old map' ] || fail 'the last map is not resumed'
(MARCO_RESUME=$folder/none choose_map) >/dev/null 2>&1 && fail 'a map that is not there was taken'
echo 'maps are resumed as asked'
