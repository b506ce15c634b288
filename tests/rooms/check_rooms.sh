#!/bin/bash
# The rooms' walls (docs/architecture.md): who may include whom. A header of LCM is always reachable, so that
# CMake's targets alone do not keep an algorithm from including it.
set -u
root=${1:?usage: check_rooms.sh ROOT}
cd "$root" || exit 2
failed=0

# $1 what is said, $2 pattern of forbidden includes, then the folders.
refuse() {
  local what=$1 pattern=$2 found
  shift 2
  found=$(grep -rnE "#include [<\"]($pattern)" "$@" --include='*.hpp' --include='*.cpp' 2>/dev/null)
  [ -z "$found" ] && return
  echo "$what:"
  echo "$found"
  failed=1
}
# Messages enter a room of algorithms in its folder process/.
outside_process() { find "$@" -type d -not -path '*/process*' -exec sh -c 'ls "$1"/*.[ch]pp 2>/dev/null' ls {} \;; }

algorithms=(slam plan mapping3d viewer)
messages='lcm/|lcmtypes/|marco/|bot_core/|spdlog/|toml'
programs='drivers/|simulator/|teleop/|tools/|web/'
tools_of_lcm='lcm_tools/(log|procman|schema|spy)/'
mapfile -t sources < <(outside_process "${algorithms[@]}")
refuse 'an algorithm includes LCM, logging, a message or a live room' "$messages|live/" "${sources[@]}"
refuse 'an algorithm includes threads or clocks' 'thread>|chrono>|mutex>|future>|atomic>' $(printf '%s\n' "${sources[@]}" | grep -v ^viewer)
refuse 'common includes LCM, logging, a message or a room' \
  "$messages|slam/|plan/|mapping3d/|viewer/|recordings/|live/|$programs|$tools_of_lcm" common
refuse 'slam includes another room' "plan/|mapping3d/|viewer/|recordings/|$programs|$tools_of_lcm" slam
found=$(grep -rnE '#include [<"][a-z_0-9]+/' core | grep -vE '"(core|common|slam)/')
[ -z "$found" ] || { echo "core includes more than its rooms:"; echo "$found"; failed=1; }
refuse 'plan includes another room than slam' "mapping3d/|viewer/|recordings/|$programs|$tools_of_lcm" plan
refuse 'mapping3d includes another room' "slam/|plan/|viewer/|recordings/|$programs|$tools_of_lcm" mapping3d
refuse 'viewer includes another room' "slam/|plan/|mapping3d/|recordings/|$programs|$tools_of_lcm" viewer
refuse 'recordings includes a room' "slam/|plan/|mapping3d/|viewer/|live/|$programs" recordings
refuse 'live includes a room above' "slam/|plan/|mapping3d/|viewer/|$programs" live
# lcm_tools is a project of its own.
found=$(grep -rnE '#include [<"](common/|lcmtypes/|recordings/|live/|drivers/|simulator/|teleop/|slam/|plan/|mapping3d/|viewer/|web/|tools/|tests/|Eigen/|opencv2/)' \
  lcm_tools --include='*.hpp' --include='*.cpp')
[ -z "$found" ] || { echo "lcm_tools includes what is not its own:"; echo "$found"; failed=1; }
refuse 'drivers include a room' 'simulator/|slam/|plan/|mapping3d/|viewer/|tools/|web/' drivers
refuse 'the page includes a driver, the simulator or a tool' 'drivers/|simulator/|tools/' web
refuse 'Foxglove'"'"'s messages know the page' 'web/(process/|[a-z_]*\.hpp)' web/foxglove

names=$(find . \( -path ./build -o -name node_modules \) -prune -o \( -name '*utils*' -o -name '*helpers*' -o -name '*misc*' \) -print | grep -v '^./.git/')
if [ -n "$names" ]; then
  echo "a file's name says nothing: $names"
  failed=1
fi
[ $failed = 0 ] && echo 'rooms are apart'
exit $failed
