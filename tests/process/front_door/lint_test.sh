#!/bin/bash
# tools/lint.sh finds a badly laid out file and a badly named function, and lets good ones pass.
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
echo "lint finds what it should"
