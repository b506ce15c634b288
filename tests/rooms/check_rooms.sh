#!/bin/bash
# The rooms' walls (docs/architecture.md): who may include whom. A header of LCM is always reachable, so that
# CMake's targets alone do not keep an algorithm from including it.
set -u
root=${1:?usage: check_rooms.sh ROOT}
cd "$root" || exit 2
failed=0

# $1 what is said, $2 pattern of forbidden includes, then the folders; */process/ is the seam and may.
refuse() {
  local what=$1 pattern=$2 found
  shift 2
  found=$(grep -rnE "#include [<\"]($pattern)" "$@" --include='*.hpp' --include='*.cpp' 2>/dev/null | grep -v '/process/')
  [ -z "$found" ] && return
  echo "$what:"
  echo "$found"
  failed=1
}

rooms=(slam plan mapping3d viewer)
programs='drivers/|simulator/|teleop/|tools/|web/|lcm_tools/(log|procman|schema|spy)/'
refuse 'an algorithm includes LCM, logging or a message' 'lcm/|lcmtypes/|marco/|bot_core/|spdlog/|toml' "${rooms[@]}" common
refuse 'slam includes another room' "plan/|mapping3d/|viewer/|recordings/|$programs" slam
found=$(grep -rnE '#include [<"][a-z_0-9]+/' core | grep -vE '"(core|common|slam)/')
[ -z "$found" ] || { echo "core includes more than its rooms:"; echo "$found"; failed=1; }
refuse 'plan includes another room than slam' "mapping3d/|viewer/|recordings/|$programs" plan
refuse 'mapping3d includes another room' "slam/|plan/|viewer/|recordings/|$programs" mapping3d
refuse 'viewer includes another room' "slam/|plan/|mapping3d/|recordings/|$programs" viewer
refuse 'common includes a room' "slam/|plan/|mapping3d/|viewer/|recordings/|$programs" common
refuse 'an algorithm includes threads or clocks' 'thread>|chrono>|mutex>|future>|atomic>' slam plan mapping3d
refuse 'recordings includes a room' "slam/|plan/|mapping3d/|viewer/|$programs" recordings
# lcm_tools is a project of its own, below */process/ too.
found=$(grep -rnE '#include [<"](common/|lcmtypes/|recordings/|drivers/|simulator/|teleop/|slam/|plan/|mapping3d/|viewer/|web/|tools/|tests/|Eigen/|opencv2/)' \
  lcm_tools --include='*.hpp' --include='*.cpp')
[ -z "$found" ] || { echo "lcm_tools includes what is not its own:"; echo "$found"; failed=1; }
refuse 'drivers include a room' 'slam/|plan/|mapping3d/|viewer/|tools/|web/' drivers
refuse 'the page includes a driver or the simulator' 'drivers/|simulator/' web
refuse 'Foxglove'"'"'s messages know the page' 'web/(process/|[a-z_]*\.hpp)' web/foxglove

names=$(find . \( -path ./build -o -name node_modules \) -prune -o \( -name '*utils*' -o -name '*helpers*' -o -name '*misc*' \) -print | grep -v '^./.git/')
if [ -n "$names" ]; then
  echo "a file's name says nothing: $names"
  failed=1
fi
[ $failed = 0 ] && echo 'rooms are apart'
exit $failed
