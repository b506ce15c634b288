#!/bin/bash
# The robot two_lasers driven once through the live simulator: both lasers' scans are taken by SLAM live, the recording
# is mapped again, and its way agrees with the truth. Run in a network of its own (isolated.sh).
# Usage: two_lasers_test.sh BIN_FOLDER PROJECT_FOLDER
set -u
bin=$(cd "$1" && pwd)
root=$(cd "$2" && pwd)
command -v lcm-logger >/dev/null || { echo 'SKIPPED: lcm-logger is not installed'; exit 0; }
export LCM_DEFAULT_URL="${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}"
folder=$(mktemp -d)
started=()

finish() {
  for pid in "${started[@]}"; do kill "$pid" 2>/dev/null; done
  wait
  rm -rf "$folder"
}
trap finish EXIT

run() {
  local name=$1
  shift
  "$@" >"$folder/$name.log" 2>&1 &
  started+=($!)
}

fail() {
  echo "FAILED: $1"
  tail -n 5 "$folder"/*.log
  exit 1
}

# $1 what, $2 seconds, then a command that must come true
await() {
  local what=$1 left=$(($2 * 5))
  shift 2
  until "$@" >/dev/null 2>&1; do
    left=$((left - 1))
    [ $left -gt 0 ] || fail "$what never came"
    sleep 0.2
  done
}

cat >"$folder/tour.toml" <<'TOML'
start_m = [2.0, 3.0]
[[steps]]
to_m = [5.0, 2.4]
[[steps]]
to_m = [5.4, 4.4]
[[steps]]
to_m = [3.0, 4.4]
TOML
cd "$root" || exit 2
robot=config/robots/two_lasers
run sim "$bin/marco-sim" --config "$robot.toml" --world config/worlds/lab.toml --tour "$folder/tour.toml" --ports "$folder/ports"
await 'the ports' 60 test -e "$folder/ports/laser_rear"
run logger lcm-logger --force "$folder/live.lcm"
run slam "$bin/marco-slam"
run base "$bin/marco-base" --config "$robot/base.toml" --device "$folder/ports/base"
run front "$bin/marco-sick" --config "$robot/sick_front.toml" --device "$folder/ports/laser_front"
run rear "$bin/marco-sick" --config "$robot/sick_rear.toml" --device "$folder/ports/laser_rear"
has() { "$bin/marco-spy" --once --json --duration 1 | grep -q "\"$1\""; }
for channel in LIDAR_FRONT LIDAR_REAR ODOMETRY SLAM_POSE; do await "$channel" 60 has "$channel"; done
"$bin/marco-tour" "$folder/tour.toml" --pose slam >"$folder/tour.log" 2>&1 </dev/null || fail 'the tour did not end well'
sleep 1
for pid in "${started[@]}"; do kill -INT "$pid"; done
wait "${started[@]}"
started=()

"$bin/marco-log" info "$folder/live.lcm" >"$folder/info.log" || fail 'the recording cannot be read'
grep -E 'LIDAR_FRONT|LIDAR_REAR|SLAM_POSE|channel' "$folder/info.log"
tail -n 3 "$folder/slam.log"
"$bin/marco-map" "$folder/live.lcm" --out "$folder/map" >"$folder/map.log" 2>&1 || fail 'it cannot be mapped'
error=$("$bin/marco-evaluate" "$folder/map/trajectory.tum" --truth "$folder/live.lcm") || fail "no truth: $error"
echo "mapped again: $error"
# Both lasers' scans are poses of the way: about twice as many as one laser gives.
python3 - "$error" "$folder/info.log" <<'PY'
import re, sys
error, info = sys.argv[1], open(sys.argv[2]).read()
rms, most = (float(re.search(name + r'=([\d.]+)', error).group(1)) for name in ('rms', 'max'))
counts = {c: int(re.search(r'^\s*' + c + r'\b\D*(?:\S+\s+)*?(\d+)', info, re.M).group(1)) for c in ('LIDAR_FRONT', 'LIDAR_REAR')}
print('rms %.3f m, largest %.3f m, scans %s' % (rms, most, counts))
sys.exit(0 if rms < 0.05 and most < 0.15 and min(counts.values()) > 100 else 'FAILED: off the truth, or a laser is missing')
PY
