# `./marco demo`; read by ./marco, whose build, say, root, bin, self and here it uses.

run_demo() {
  local out="$here/out/demo" live=yes
  while [ $# -gt 0 ]; do
    case $1 in
      --out) value_of "$@"; out=$2; shift 2 ;;
      --live) live=yes; shift ;;
      --batch) live=no; shift ;;
      *) unknown option "$1" --out --live --batch ;;
    esac
  done
  need viewer simulator
  if [ $live = yes ]; then
    need network replay
    build release programs
  else
    build release marco-simulate marco-map marco-viewer
  fi
  mkdir -p "$out"
  out="$(cd "$out" && pwd)"
  . "$root/lcm_tools/tests/support/namespaces.sh"
  if [ $live = yes ] && [ -z "$own" ] && ! ip route get 239.255.76.67 >/dev/null 2>&1; then
    say "processes can't reach each other here (no network namespaces, no multicast route): demo --batch instead"
    live=no
  fi
  if [ $live = yes ]; then
    say "driving a tour of the lab in real time; the processes' output is in $out/state"
    demo_script "$out" sim.procman demo
    local recordings=("$out"/recordings/*/)  # this run's is the last one
    mv "${recordings[-1]}live.lcm.00" "$out/lab.lcm"
    rm -r "${recordings[-1]}"
    say "playing the recording into a new SLAM, at 5 times its speed"
    MARCO_RECORDING="$out/lab.lcm" demo_script "$out" replay.procman recording
  else
    say "simulating a tour of the lab"
    "$bin/marco-simulate" --world "$root/config/worlds/lab.toml" \
      --tour "$root/config/tours/lab.toml" --seed 1 --cameras "$root/config/robots/michoacan.toml" --out "$out/lab.lcm"
  fi
  say "mapping it"
  "$bin/marco-map" "$out/lab.lcm" --out "$out" --world "$root/config/worlds/lab.toml"
  if [ $live = yes ]; then
    say "the live path of this map against SLAM's poses during the drive, and during the playback"
    local recording
    for recording in lab replayed; do
      "$bin/marco-evaluate" "$out/trajectory_live.tum" --recorded "$out/$recording.lcm"
    done
  fi
  local painted=""
  if [ -f "$out/model_textured.glb" ]; then
    painted=" $out/model_photographs.png"
    "$bin/marco-viewer" "$out/model_textured.glb" --color photograph --out "$out/model_photographs.png" >/dev/null
  fi
  say "pictures: $out/map.png $out/model.png$painted"
}

# $1 folder, $2 a script of config/, $3 its name. The processes talk in a network namespace of their own where there
# is such a thing: no other robot on this network is disturbed, or disturbs.
demo_script() {
  MARCO_RUN="$1" "$root/lcm_tools/tests/support/isolated.sh" env XDG_STATE_HOME="$1/state" \
    "$self" run "$root/config/$2" "$3" -n --on-script-complete exit || {
    echo "marco demo: the live run ended with an error; see $1/state" >&2
    exit 1
  }
}
