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
"$door" help | grep -q '^  marco-robot map' || fail "marco-robot help"
"$door" map "$source_folder/../../logs/sample.lcm" --out map >map.log || fail "marco-robot map"
[ -s map/map.png ] && [ -s map/trajectory.tum ] || fail "marco-robot map wrote no map"
"$door" log info "$source_folder/../../logs/sample.lcm" | grep -q LIDAR || fail "marco-robot log info"
"$door" bench >/dev/null 2>bench.log && fail "marco-robot bench has no sources and ended with 0"
grep -q 'in a clone of the project' bench.log || fail "marco-robot bench does not say what it needs"
[ "$(readlink -f "$prefix/share/marco-robot/marco")" = "$(readlink -f "$door")" ] || fail "procman scripts find no front door"
echo "installed: all good"
