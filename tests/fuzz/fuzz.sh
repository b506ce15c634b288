#!/bin/bash
# Runs the fuzzers of a build: fuzz.sh BIN WORK [--minutes N | --seconds N] [--jobs N] [--longest BYTES] [--ci GROUP]
# [TARGET...]
# Corpora grow in WORK/TARGET, seeded from tests/fuzz/corpus/TARGET; two targets at a time. What crashes is left in
# WORK and makes the exit code 1. --ci: 20 s each for three targets of one program, other ones every day, so that only
# that program need be built; fuzz.sh --todays-group says which.
set -u
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
day=$(($(date +%s) / 86400))
# Those that are built in seconds; the others link whole rooms, minutes of building with clang.
groups=(lasers procman messages network bases ros points)
[ "${1:-}" = --todays-group ] && { echo "${groups[$((day % ${#groups[@]}))]}"; exit 0; }
bin=$1 work=$2
shift 2
seconds=60 ci=no jobs=2 longest=8192 targets=()
while [ $# -gt 0 ]; do
  [[ $1 != -* || $# -ge 2 ]] || { echo "fuzz: $1 needs a value" >&2; exit 2; }
  case $1 in
    --minutes) seconds=$((60 * $2)); shift 2 ;;
    --seconds) seconds=$2; shift 2 ;;
    --jobs) jobs=$2; shift 2 ;;
    --longest) longest=$2; shift 2 ;;  # short inputs are run many times as often
    --ci) ci=$2 seconds=20; shift 2 ;;
    -*) echo "usage: ./marco fuzz [--minutes N] [TARGET...]" >&2; exit 2 ;;
    *) targets+=("$1"); shift ;;
  esac
done

program_of() {
  local program
  for program in "$bin"/fuzz_*; do
    "$program" 2>/dev/null | grep -qx "$1" && { echo "$program"; return; }
  done
}
mapfile -t all < <(for program in "$bin"/fuzz_$([ $ci = no ] && echo '*' || echo $ci); do "$program" 2>/dev/null; done | sort)
[ ${#all[@]} -gt 0 ] || { echo "fuzz: no fuzzers in $bin" >&2; exit 1; }
if [ $ci != no ]; then
  first=$((day / ${#groups[@]} * 3))
  for ((i = 0; i < 3 && i < ${#all[@]}; ++i)); do targets+=("${all[$(((first + i) % ${#all[@]}))]}"); done
fi
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")

# The input that libFuzzer gave up for its time; @returns whether it takes that long when it runs by itself.
hangs() {
  local input
  input=$(sed -n 's/.*Test unit written to //p' "$work/$2.log" | tail -1)
  [ -n "$input" ] || return 1
  (ulimit -t "$3"; "$1" --target="$2" -timeout=1000 "$input" >/dev/null 2>&1) && { rm -f "$input"; return 1; }
  return 0
}

# libFuzzer's log, and at its end: edges, and minutes since the last new one.
stamp_edges() {
  awk '{ print }
    / cov: [0-9]/ { for (i = 1; i < NF; ++i) if ($i == "cov:" && $(i + 1) > most) { most = $(i + 1); at = systime() } }
    END { if (most) printf "edges: %d %.0f\n", most, (systime() - at) / 60 }'
}

fuzz_one() {
  local target=$1 program
  program="$(program_of "$target")"
  [ -n "$program" ] || { echo "fuzz: there is no target '$target'; there are: ${all[*]}" >&2; return 1; }
  mkdir -p "$work/$target" "$here/corpus/$target"
  # A wide search over many scans is slow under the sanitizers; no decoder may be.
  local limit=1
  [[ $target == *_adapter ]] && limit=25
  # libFuzzer's second is a clock's: where others compute, too, an input is run again, for a second of this process.
  local end=$((SECONDS + seconds)) code=0 log="$work/$target.log"
  : >"$log"
  set -o pipefail
  while [ $SECONDS -lt $end ]; do
    timeout $((seconds + 120)) "$program" --target="$target" -timeout=$limit -rss_limit_mb=512 -max_len="$longest" \
      -max_total_time=$((end - SECONDS)) -print_final_stats=1 -artifact_prefix="$work/$target-" \
      "$work/$target" "$here/corpus/$target" 2>&1 | stamp_edges >>"$log"
    code=$?
    [ $code = 70 ] || break
    hangs "$program" "$target" "$limit" && break
    code=0
  done
  local executed edges quiet total
  executed=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | awk '{ sum += $1 } END { printf "%d", sum }')
  read -r edges quiet < <(sed -n 's/^edges: //p' "$log" | tail -1)
  # Of all runs into this WORK.
  total=$(($(cat "$work/$target.total" 2>/dev/null || echo 0) + ${executed:-0}))
  echo $total >"$work/$target.total"
  printf '%-20s %12s executions (of %s) %6s edges, none new for %4s min  %s\n' "$target" "${executed:-?}" "$total" \
    "${edges:-?}" "${quiet:-?}" \
    "$([ $code = 0 ] && echo clean || echo "FAILED: $(grep -m1 -oE 'ERROR: .*|runtime error: .*|terminate called.*' "$work/$target.log"), see $work/$target.log")"
  return $code
}

mkdir -p "$work"
failed=0 running=0
for target in "${targets[@]}"; do
  fuzz_one "$target" &
  running=$((running + 1))
  if [ $running -ge "$jobs" ]; then wait -n || failed=1; running=$((running - 1)); fi
done
while [ $running -gt 0 ]; do wait -n || failed=1; running=$((running - 1)); done
exit $failed
