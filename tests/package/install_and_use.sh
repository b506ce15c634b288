#!/bin/bash
# Installs a build into an empty folder and looks at it from outside: nothing of it is where MATE's window manager, which
# Debian calls marco, has files; a project of another folder links each library; the installed front door works.
# usage: install_and_use.sh BUILD [headers]       headers: instead of all that, each installed header compiles alone
set -euo pipefail
source_folder="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
prefix="$folder/usr"
fail() { echo "FAILED: $*" >&2; exit 1; }

cmake --install "$1" --prefix "$prefix" >/dev/null
each_header=OFF
[ "${2:-}" != headers ] || each_header=ON
cmake -G Ninja -S "$source_folder" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" -DEACH_HEADER=$each_header >"$folder/log" 2>&1 ||
  { cat "$folder/log"; fail "find_package(marco)"; }
cmake --build "$folder/build" -- -k 0 >"$folder/log" 2>&1 ||
  { grep -E "error:|undefined reference|cannot find" "$folder/log" | head -50; fail "an installed library or header"; }
[ $each_header = OFF ] || { echo "each header compiles alone"; exit; }
"$folder/build/use_all"

# The examples are such a project.
examples="$(cd "$source_folder/../../examples" && pwd)"
sample="$(cd "$source_folder/../../logs" && pwd)/sample.lcm"
cmake -G Ninja -S "$examples" -B "$folder/examples" -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 ||
  { cat "$folder/log"; fail "the examples' find_package(marco)"; }
cmake --build "$folder/examples" >"$folder/log" 2>&1 || { grep -E 'error:|undefined' "$folder/log" | head; fail "an example"; }
mkdir "$folder/of_example"
"$folder/examples/map_a_log" "$sample" "$folder/of_example" | grep -q 'scans, .* loops' || fail map_a_log
[ -s "$folder/of_example/map.pgm" ] || fail "map_a_log wrote no map"
"$folder/examples/match_two_scans" "$sample" 0 20 | grep -Eq '([7-9].|100) % of the points' || fail match_two_scans
isolated="$source_folder/../../lcm_tools/tests/support/isolated.sh"
# A laser of one's own is mapped, and a subscriber of one's own hears the pose.
LASER="$folder/examples/my_laser" FOLLOW="$folder/examples/follow_the_robot" SLAM="$prefix/bin/marco-slam" \
  "$isolated" bash -c '
    "$SLAM" & slam=$!
    "$LASER" 20 & laser=$!
    timeout 20 "$FOLLOW" 5; told=$?
    kill $laser $slam; wait
    exit $told' >"$folder/log" 2>&1 || { cat "$folder/log"; fail "my_laser, marco-slam, follow_the_robot"; }
[ "$(grep -Ec '^x -?0.00 m, y -?0.00 m' "$folder/log")" = 5 ] || { cat "$folder/log"; fail "the laser that stands moved"; }
! "$isolated" "$folder/examples/go_to" 1 0 >"$folder/log" || fail "go_to without a base"
grep -q 'no base answers' "$folder/log" || fail "go_to does not say that no base answers"

# A folder in the list ends with a slash: nothing of ours lies in it.
(cd "$prefix" && find . -type f -o -type l) | sed 's|^\./||; s|/x86_64-linux-gnu/|/|' | sort >"$folder/ours"
grep -qx bin/marco-robot "$folder/ours" || fail "no front door is installed"
grep -q '^bin/marco-map$' "$folder/ours" || fail "no marco-map is installed"
while IFS= read -r path; do
  case $path in
    '#'* | '') ;;
    */) ! grep "^$path" "$folder/ours" || fail "$path is MATE's" ;;
    *) ! grep -Fx "$path" "$folder/ours" || fail "$path is MATE's" ;;
  esac
done <"$source_folder/mate_paths.txt"

door="$prefix/bin/marco-robot"
cd "$folder"
[[ "$("$door" --version)" == "marco-robot "[0-9]* ]] || fail "marco-robot --version"
[[ "$("$door" help)" == *$'\n  marco-robot map '* ]] || fail "marco-robot help"
"$door" map "$source_folder/../../logs/sample.lcm" --out map >map.log || fail "marco-robot map"
[ -s map/map.png ] && [ -s map/trajectory.tum ] || fail "marco-robot map wrote no map"
[[ "$("$door" log info "$source_folder/../../logs/sample.lcm")" == *LIDAR* ]] || fail "marco-robot log info"
[[ "$("$door" python -c 'import marco; print(marco.settings())')" == *"[slam]"* ]] || fail "marco-robot python"
"$door" bench >/dev/null 2>bench.log && fail "marco-robot bench has no sources and ended with 0"
grep -q 'in a clone of the project' bench.log || fail "marco-robot bench does not say what it needs"
[ "$(readlink -f "$prefix/share/marco-robot/marco")" = "$(readlink -f "$door")" ] || fail "procman scripts find no front door"
echo "installed: all good"
