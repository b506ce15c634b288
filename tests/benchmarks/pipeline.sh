#!/bin/bash
# The whole main job: median scans a second of `map` over five runs, each a process of its own, pictures included.
# $1 folder of the programs. With MARCO_TEST_DATA also on real logs.
set -euo pipefail
bin=$1
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

median_of_runs() {
  local name=$1 input=$2 run
  for run in 1 2 3 4 5; do
    "$bin/marco-map" "$input" --out "$work/out" >/dev/null
    python3 - "$work/out/report.json" <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
pictures = sum(s["wall_s"] for s in report["stages"] if s["name"] == "pictures")
matching = sum(s["cpu_s"] for s in report["stages"] if s["name"].startswith("read and match"))
print(report["scans"]["posed"], report["wall_s"], report["wall_s"] - pictures, matching,
      report["cpu_s"], report["peak_memory_mb"])
PY
  done | sort -n -k2 | sed -n 3p |
    awk -v name="$name" '{printf "%-24s %6d scans  %6.0f scans/s  whole %.2f s, without pictures %.2f s, scan to pose %.2f s cpu, job %.2f s cpu, %.0f MB\n",
                          name, $1, $1 / $2, $2, $3, $4, $5, $6}'
}

"$bin/marco-simulate" --world "$root/config/worlds/lab.toml" --tour "$root/config/tours/lab.toml" \
  --out "$work/lab.lcm" >/dev/null
median_of_runs "map, simulated lab" "$work/lab.lcm"
if [ -n "${MARCO_TEST_DATA:-}" ]; then
  median_of_runs "map, intel.log" "$MARCO_TEST_DATA/intel/intel.log"
  median_of_runs "map, mbot_convex.lcmlog" "$MARCO_TEST_DATA/mbot/mbot_convex.lcmlog"
fi
