# Sourced by tests that need two hosts: runs the test again inside a network and mount namespace of its own, and joins
# that with a second one by a pair of virtual cables. Gives: $folder (removed in the end), started+=(PID) (ended in the
# end), fail TEXT, on_other COMMAND, start_on_other COMMAND (in the background, ended in the end), connect (the cable up,
# multicast through it; `ip link set cable_a down` cuts it).
# Where the system forbids all this the test says SKIPPED.
if [ "${MARCO_TWO_NETWORKS:-}" != inside ]; then
  . "$(dirname "${BASH_SOURCE[0]}")/../../lcm_tools/tests/support/namespaces.sh"
  [ -n "$own" ] || { echo 'SKIPPED: this system forbids network namespaces'; exit 0; }
  MARCO_TWO_NETWORKS=inside exec unshare $own "$0" "$@"
fi
for program in nsenter ip python3 pgrep lcm-logplayer; do
  command -v $program >/dev/null || { echo "SKIPPED: $program is not installed"; exit 0; }
done

folder=$(mktemp -d)
export XDG_RUNTIME_DIR=$folder/run XDG_STATE_HOME=$folder/state
started=()
finish() {
  kill -TERM "${started[@]}" 2>/dev/null
  sleep 0.5
  kill -KILL "${started[@]}" 2>/dev/null
  rm -rf "$folder"
}
trap finish EXIT
fail() {
  echo "FAILED: $*"
  tail -n 30 "$folder"/*.log 2>/dev/null
  exit 1
}

# The second network lives as long as this sleep.
unshare -n sleep 300 &
other=$!
started+=("$other")
on_other() { nsenter --net="/proc/$other/ns/net" "$@"; }
# Not `on_other COMMAND &`: $! would be a shell around it, and the command would outlive that.
start_on_other() {
  nsenter --net="/proc/$other/ns/net" "$@" &
  started+=($!)
}
for _ in $(seq 100); do
  [ "$(readlink "/proc/$other/ns/net")" != "$(readlink /proc/self/ns/net)" ] && break
  sleep 0.02
done
ip link add cable_a type veth peer name cable_b netns "$other" 2>/dev/null ||
  { echo 'SKIPPED: this system has no virtual cables (veth)'; exit 0; }
connect() { ip link set cable_a up multicast on && ip route replace 224.0.0.0/4 dev cable_a; }
ip link set lo up
on_other ip link set lo up
ip address add 10.77.0.1/24 dev cable_a
on_other ip address add 10.77.0.2/24 dev cable_b
on_other ip link set cable_b up multicast on
on_other ip route replace 224.0.0.0/4 dev cable_b
connect || fail 'cannot join the two networks'
