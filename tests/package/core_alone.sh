#!/bin/bash
# marco::core alone: core/ is configured, built, installed and used where nothing but Eigen is installed of Marco's
# dependencies.
# usage: core_alone.sh SOURCE
set -euo pipefail
source_folder=$1
if [ "${CORE_ALONE:-}" != inside ]; then
  . "$source_folder/lcm_tools/tests/support/namespaces.sh"
  [ -n "$own" ] || { echo 'SKIPPED: this system forbids mount namespaces'; exit 0; }
  CORE_ALONE=inside exec unshare $own "$0" "$@"
fi
for folder in /usr/include/{lcm,opencv4,spdlog,fmt,CLI,nlohmann,toml++,gtest}; do
  [ ! -d $folder ] || mount -t tmpfs none $folder
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
cmake -S "$source_folder/core" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Dev -DCMAKE_CXX_FLAGS_DEV=-O1 \
  >"$folder/log" 2>&1 || { cat "$folder/log"; fail configure; }
cmake --build "$folder/build" >"$folder/log" 2>&1 || { grep -E 'error|undefined' "$folder/log" | head -50; fail build; }
cmake --install "$folder/build" --prefix "$folder/usr" >/dev/null
# A project of somebody who installed it, and a robot that drives 1 m ahead in a corridor of 8 x 4 m.
mkdir "$folder/user"
cp "$source_folder/core/examples/map_carmen_log.cpp" "$folder/user/"
printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(user LANGUAGES CXX)' 'find_package(marco_core 1.0 REQUIRED)' \
  'add_executable(user map_carmen_log.cpp)' 'target_link_libraries(user PRIVATE marco::core)' >"$folder/user/CMakeLists.txt"
cmake -S "$folder/user" -B "$folder/user/build" -G Ninja -DCMAKE_PREFIX_PATH="$folder/usr" >"$folder/log" 2>&1 ||
  { cat "$folder/log"; fail 'configure a user of it'; }
cmake --build "$folder/user/build" >"$folder/log" 2>&1 || { grep -E 'error|undefined' "$folder/log" | head; fail 'build a user of it'; }
awk 'BEGIN {
  for (i = 0; i <= 40; ++i) {
    x = 2 + i / 40
    printf "FLASER 180"
    for (beam = 0; beam < 180; ++beam) {
      angle = (beam - 90) * atan2(0, -1) / 180
      ahead = cos(angle) > 1e-9 ? (8 - x) / cos(angle) : 1e9
      aside = sin(angle) == 0 ? 1e9 : 2 / (sin(angle) > 0 ? sin(angle) : -sin(angle))
      printf " %.3f", ahead < aside ? ahead : aside
    }
    printf " 0 0 0 %.4f 0 0 %.2f host %.2f\n", 1.05 * (x - 2), i / 10, i / 10
  }
}' >"$folder/drive.log"
cd "$folder"
user/build/user <drive.log >path.txt 2>verdict.txt || fail 'the example'
awk 'END { if (NR != 41 || $2 < 0.98 || $2 > 1.02 || $3 < -0.02 || $3 > 0.02) exit 1 }' path.txt || { tail -1 path.txt; fail 'the path'; }
head -c 2 map.pgm | grep -q P5 || fail 'the map'
grep -q 'the map is good' verdict.txt || { cat verdict.txt; fail 'the verdict'; }
echo 'marco::core stands alone'
