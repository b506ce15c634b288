#!/bin/bash
# lcm_tools without the rest: a copy of the folder is configured, built, installed and used, with Eigen and OpenCV hidden.
# usage: lcm_tools_alone.sh SOURCE
set -euo pipefail
source_folder=$1
if [ "${LCM_TOOLS_ALONE:-}" != inside ]; then
  . "$source_folder/lcm_tools/tests/support/namespaces.sh"
  [ -n "$own" ] || { echo 'SKIPPED: this system forbids mount namespaces'; exit 0; }
  LCM_TOOLS_ALONE=inside exec unshare $own "$0" "$@"
fi
for folder in /usr/include/eigen3 /usr/include/opencv4 /usr/share/eigen3; do
  [ ! -d $folder ] || mount -t tmpfs none $folder
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
cp -r "$source_folder/lcm_tools" "$folder/"
cmake -S "$folder/lcm_tools" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Dev -DMARCO_TESTS=OFF -DCMAKE_UNITY_BUILD=ON \
  >"$folder/log" 2>&1 || { cat "$folder/log"; fail configure; }
cmake --build "$folder/build" >"$folder/log" 2>&1 || { grep -E 'error|undefined' "$folder/log" | head -50; fail build; }
cmake --install "$folder/build" --prefix "$folder/usr" >/dev/null
for program in marco-log marco-relay marco-spy marco-procman-deputy marco-procman-keeper marco-procman-order marco-procman-sheriff; do
  "$folder/usr/bin/$program" --version | grep -q "^$program 0" || fail "$program --version"
done
"$folder/usr/bin/marco-log" info "$source_folder/logs/sample.lcm" | grep -q bot_core.planar_lidar_t || fail 'marco-log info'
! "$folder/usr/bin/marco-log" import a b 2>"$folder/log" || fail 'marco-log import is of Marco'
! grep -rl eigen "$folder/build/build.ninja" || fail 'something stands on Eigen'
echo 'lcm_tools stands alone'
