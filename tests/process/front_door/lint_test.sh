#!/bin/bash
# tools/lint.sh finds a badly laid out file, a badly named function and a badly worded page, and lets good ones pass.
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
echo "lint finds what it should"
