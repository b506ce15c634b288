#!/bin/bash
# marco-devices on real pseudo-terminals: a simulated robot's laser and base are found and named, a port that is held is not
# touched, and what --write makes starts the robot. Run in a network of its own (isolated.sh).
# Usage: devices_test.sh BIN_FOLDER PROJECT_FOLDER
set -u
bin=$(cd "$1" && pwd)
root=$(cd "$2" && pwd)
export LCM_DEFAULT_URL="${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}"
command -v lcm-logger >/dev/null || { echo 'SKIPPED: lcm-logger is not installed'; exit 0; }
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; wait; rm -rf "$folder"' EXIT
fail() { echo "FAILED: $1"; tail -n 20 "$folder"/*.log "$folder"/said; exit 1; }
expect() { grep -qE "$1" "$folder/said" || fail "it did not say '$1'"; }
export PATH="$bin:$PATH" MARCO_ROOT="$root" MARCO_RUN="$folder/run"
mkdir -p "$folder/run" "$folder/my robot"

marco-sim --config "$root/config/robots/homemade.toml" --world "$root/config/worlds/lab.toml" --start 2 3 0 --ports "$folder/ports" \
  >"$folder/sim.log" 2>&1 &
for ((i = 0; i < 200; ++i)); do [ -e "$folder/ports/laser" ] && [ -e "$folder/ports/base" ] && break; sleep 0.1; done

marco-devices "$folder/ports/laser" "$folder/ports/base" "$folder/nothing" --write "$folder/my robot" >"$folder/said" 2>&1 ||
  fail "exit code $?"
expect "^LDROBOT laser at 230400 on $folder/ports/laser, scans at (9.9|10.[01]) Hz, [0-9]+ beams \(marco-ldlidar\)$"
expect "^base with Marco's text protocol, '[a-z]+' at 115200 on $folder/ports/base \(marco-textbase\)$"
expect "^$folder/nothing: no such device"
expect "/laser.toml: measure the laser's height; until then the base drives at most 0.2 m/s$"
grep -q '^# position_m = ' "$folder/my robot/laser.toml" || fail "it invented a height"
marco-devices "$folder/nothing" >"$folder/said" 2>&1 && fail "a port that is not there is no failure"
marco-devices "$folder/ports/laser" --write "$folder/my robot" >"$folder/said" 2>&1 && fail "it overwrote files"
expect "already exists"

# Only a person can count the ticks of a wheel's turn.
cat "$root/config/robots/homemade/textbase.toml" | sed "s|^device = .*|device = \"$folder/ports/base\"|" >"$folder/my robot/base.toml"
marco-procman-sheriff -n -l --on-script-complete exit "$folder/my robot/robot.procman" go >"$folder/sheriff.log" 2>&1 ||
  fail "the script does not start: exit code $?"

# Held: neither opened nor asked.
marco-ldlidar --device "$folder/ports/laser" >"$folder/driver.log" 2>&1 &
for ((i = 0; i < 100; ++i)); do grep -q "is open" "$folder/driver.log" && break; sleep 0.1; done
marco-devices "$folder/ports/laser" >"$folder/said" 2>&1 || fail "a held port: exit code $?"
expect "ports/laser: held by marco-ldlidar \([0-9]+\); not touched$"

marco-devices --udev >"$folder/said" || fail "--udev: exit code $?"
[ "$(grep -vc '^\(#.*\|SUBSYSTEM=="tty", ATTRS{idVendor}==.*, TAG+="uaccess", .*\|\)$' "$folder/said")" = 0 ] || fail "a udev rule of another form"
echo "devices are found, named, and started"
