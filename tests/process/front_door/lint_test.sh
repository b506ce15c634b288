#!/bin/bash
# tools/lint.sh finds a badly laid out file, a badly named function, a badly worded page and a room above its budget, and
# lets good ones pass.
set -euo pipefail
root=${1:?usage: lint_test.sh ROOT}
for tool in clang-format clang-tidy clang++ git; do
  command -v $tool >/dev/null || { echo "SKIPPED: no $tool here"; exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/tools" "$folder/build" "$folder/tests"
cp "$root/tools/lint.sh" "$folder/tools/"
cp "$root/.clang-format" "$root/.clang-tidy" "$folder/"
cp "$root/tests/.clang-tidy" "$folder/tests/"
cd "$folder"
git init -q .
fail() { echo "FAILED: $*" >&2; exit 1; }

# $1 name, $2 its text; the build knows it.
source_file() {
  printf '%s\n' "$2" >"$1"
  git add "$1"
  entries+=("{\"directory\": \"$folder\", \"command\": \"clang++ -c $1\", \"file\": \"$folder/$1\"}")
  (IFS=,; echo "[${entries[*]}]" | sed 's/},{/},\n{/g' >build/compile_commands.json)
}
entries=()

source_file good.cpp 'int twice(int value) { return 2 * value; }'
tools/lint.sh format || fail "a good layout is refused"
tools/lint.sh tidy build 2>&1 || fail "good code is refused"
source_file wide.cpp 'int  half( int value ){return value/2;}'
! tools/lint.sh format 2>said || fail "a bad layout passes"
grep -q wide.cpp said || fail "the badly laid out file is not named"
! tools/lint.sh format good.cpp wide.cpp 2>/dev/null || fail "a bad layout among the named files passes"
tools/lint.sh format good.cpp || fail "a file that was not asked for is judged"
source_file named.cpp 'int BadName(int value) { return value; }'
! tools/lint.sh tidy build >said 2>&1 || fail "a bad name passes"
grep -q BadName said || fail "the badly named function is not named"
long='int %s(int value) {'$(printf '\n  if (value > %d) ++value;' $(seq 30))$'\n  return value;\n}'
source_file tests/branches.cpp "${long/\%s/many_branches}"
tools/lint.sh tidy build tests/branches.cpp || fail "a test with many branches is refused"
source_file branches.cpp "${long/\%s/many_branches}"
! tools/lint.sh tidy build branches.cpp >said 2>&1 || fail "a function with many branches passes"
source_file tests/named.cpp 'int BadName(int value) { return value; }'
! tools/lint.sh tidy build tests/named.cpp >said 2>&1 || fail "a bad name passes in a test"
tools/lint.sh tidy build good.cpp || fail "a file that was not asked for is judged by clang-tidy"

# How it reads.
if command -v codespell >/dev/null && command -v doxygen >/dev/null; then
  cp "$root/Doxyfile" .
  cp "$root/tools/phrases.txt" "$root/tools/bare_constants.awk" tools/
  printf '%s\n' '# phrase|lines|instead' 'as heard|1|as received' >tools/phrase_counts.txt
  # $1 the file, $2 a text without faults, $3 one with a fault, $4 what names it.
  reads() {
    mkdir -p $(sed -n 's/^INPUT = //p' Doxyfile) "$(dirname "$1")"
    printf '%b\n' "$2" >"$1"
    git add "$1"
    tools/lint.sh docs >said 2>&1 || { cat said; fail "$1 is refused: $2"; }
    printf '%b\n' "$3" >"$1"
    ! tools/lint.sh docs >said 2>&1 || fail "$1 passes: $3"
    grep -q "$4" said || fail "$4 is not named"
    git rm -qf "$1"
  }
  reads README.md 'The scan is matched again.' 'The scan is matched again and reci''eved.' reci''eved
  reads README.md 'The scan is matched again.' 'The scan is matched anew.' anew
  reads README.md 'One side.' '<<<<''<<< HEAD\nOne side.' README.md:1
  reads README.md 'The pose as heard.' 'The pose as heard.\nThe scan, as heard.' "'as heard' in 2 lines, at most 1: write as received"
  reads web/page/app.js '// A scan as heard.' '// A scan as heard.\n// A pose as heard.' "'as heard' in 2 lines"
  tools/lint.sh docs >said 2>&1 || { cat said; fail "fewer phrases than counted are refused"; }
  grep -q "'as heard' fell to 0 lines: lower its 1" said || fail "a count that may be lowered is not named"
  reads common/half.hpp '#pragma once\n/// @param value  is halved\nint half(int value);' \
    '#pragma once\n/// @param number  is halved\nint half(int value);' number
  reads slam/near.cpp '// A door.\nconstexpr double kNearM = 0.9, kFarM = 2.0;\nconstexpr int kFewestBeams = 3;' \
    '// A door.\nconstexpr double kNearM = 0.9;\n\nconstexpr double kFarM =\n    2.0;' slam/near.cpp:4:
  reads slam/near.cpp 'constexpr int kTile = 64;\nconstexpr double kTurn = 2 * std::numbers::pi;' \
    'constexpr int kTile = 64;\nconstexpr int kFewestBeams = 3;' kFewestBeams
else
  echo "without codespell and doxygen: how it reads is not tested"
fi

# How much there is.
git rm -qrf --cached . && rm -rf *.cpp tests/*.cpp
cp "$root/tools/lines.py" tools/
# $1 path, $2 number of lines.
lines_in() { mkdir -p "$(dirname "$1")"; seq -f '// %g' "$2" >"$1"; git add "$1"; }
budget() { printf '%s\n' '# room lines' "$@" >tools/lines.txt; }
lines_in slam/map/place.cpp 30
lines_in slam/map/tests/place.cpp 7
lines_in drivers/sick/driver.cpp 20
lines_in simulator/devices/sick/emulator.cpp 5
lines_in simulator/devices/sick/laser.hpp 4
lines_in simulator/world.cpp 3
lines_in lcm_tools/log/log.cpp 11
lines_in lcm_tools/tests/log/log_test.cpp 2
lines_in examples/own.cpp 6
lines_in web/page/app.js 8
mkdir -p docs
printf '%s\n' '    [slam]' '    example = 1' '' '    [slam]' '    # How far.' '    far_m = 1' '    near_m = 2' >docs/settings.md
full=('drivers/sick 20' 'emulators 9' 'examples 6' 'lcm_tools 11' 'page 8' 'simulator 3' 'slam/map 30' 'tests 9' 'total 73' 'settings 2')
budget "${full[@]}"
tools/lint.sh lines >said || { cat said; fail "a budget that fits is refused"; }
grep -qE '^product +53 *$' said && grep -qE '^total +73 +73$' said && grep -qE '^settings +2 +2$' said || { cat said; fail "lines are counted wrongly"; }
budget "${full[@]/slam\/map 30/slam/map 29}"
! tools/lint.sh lines >said || fail "a room one line above its budget passes"
grep -q '^slam/map: 30 lines, 1 more' said || fail "the room above its budget is not named"
budget "${full[@]/slam\/map 30/}"
! tools/lint.sh lines >said || fail "a room without a budget passes"
grep -q '^slam/map: 30 lines, and no budget' said || fail "the room without a budget is not named"
budget "${full[@]/settings 2/settings 1}"
tools/lint.sh lines >said || fail "a setting too many is no failure"
grep -qE '^settings +2 +1  1 more than allowed' said || fail "a setting too many is not reported"

# $1 lines of a function's body; its head takes one line, its end another.
function_of() {
  { printf 'namespace a {\nint first(int value) {\n'; seq -f '  value += %g;  // }' "$1"; printf '}\n'
    printf 'struct S {\n  S() : a_{1} {}\n  int a_;\n};\n}\n'; } >slam/map/long.cpp
  git add slam/map/long.cpp
}
budget "${full[@]/slam\/map 30/slam/map 200}" 'functions_over_60_lines 0'
sed -i 's/total 73/total 300/' tools/lines.txt
function_of 58
tools/lint.sh lines >said && grep -qE '^functions_over_60_lines +0 +0$' said || { cat said; fail "a function of 60 lines is taken for a longer one"; }
function_of 59
tools/lint.sh lines >said && grep -q '^  slam/map/long.cpp:2 (61 lines)$' said || { cat said; fail "a function of 61 lines is not named"; }
printf '#pragma once\n' >slam/map/one.hpp
printf '#include "slam/map/one.hpp"\n' | tee slam/map/one.cpp >drivers/sick/other.cpp
git add slam drivers
tools/lint.sh lines >said || true
grep -qE '^headers_with_one_user +1 ' said || { cat said; fail "a header with one user is not counted"; }
echo "lint finds what it should"
