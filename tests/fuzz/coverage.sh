#!/bin/bash
# Lines of the decoders that the corpora reach: coverage.sh BIN WORK, BIN a build with clang's coverage. Each program
# runs all corpora of its targets once; then a line for each of its source files that a fuzzer is for. What makes bytes
# or holds a table (see `writes`) is no decoder: without and with it.
set -eu
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
bin=$1 work=$2
out="$work/coverage"
rm -rf "$out" && mkdir -p "$out"
tool() { command -v "$1" || command -v "$1-14"; }
writes='encode_|encodeE|_request|to_message|print_|word_of|sonars|RampWalk|rate_code|mode_of_baud|baud_of_mode|adc|time_units'
profdata=$(tool llvm-profdata) cov=$(tool llvm-cov)
for program in "$bin"/fuzz_*; do
  name=$(basename "$program")
  for target in $("$program" 2>/dev/null); do
    mkdir -p "$work/$target"
    LLVM_PROFILE_FILE="$out/$name-$target.profraw" "$program" --target="$target" -runs=0 -max_len=100000 \
      "$work/$target" "$here/corpus/$target" >"$out/$name-$target.log" 2>&1 || echo "$target: FAILED, see $out" >&2
  done
  "$profdata" merge -o "$out/$name.profdata" "$out/$name"-*.profraw
  # File, lines, percent reached.
  "$cov" report "$program" -instr-profile="$out/$name.profdata" 2>/dev/null |
    awk '$1 ~ /\.cpp$/ && $1 !~ /tests\/fuzz/ { print $1 }' | while read -r file; do
    "$cov" report "$program" -instr-profile="$out/$name.profdata" -show-functions "$here/../../$file" 2>/dev/null |
      awk -v group="$name" -v file="$file" -v writes="$writes" '
        $1 ~ /_Z/ { all += $5; all_missed += $6 }
        $1 ~ /_Z/ && $1 !~ writes { lines += $5; missed += $6 }
        END { if (lines) printf "%-14s %-40s %5d lines %8.2f%%, of all %5d %8.2f%%\n", group, file, lines,
                                100 * (1 - missed / lines), all, 100 * (1 - all_missed / all) }'
  done
done
