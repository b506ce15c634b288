#!/bin/bash
# What nobody may do to us, tried:
#   - by default no message leaves this host: a packet capture at the other end of a cable sees none (and sees them when
#     ttl 1 is asked for, so that it could have);
#   - no shell is started from the content of orders;
#   - tools write under the folder they are given, whatever a log's channels are called.
#   safety_test.sh BIN-FOLDER SOURCE-FOLDER
set -u
bin=$1
root=$2
source "$root/tests/support/two_networks.sh"
unset LCM_DEFAULT_URL

cat >"$folder/capture.py" <<'PY'
import socket, struct, sys, time
# Every frame that arrives at the far end; UDP packets to LCM's group are counted.
sock = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
sock.bind(("cable_b", 0))
sock.settimeout(0.2)
end, packets, lcm = time.time() + float(sys.argv[1]), 0, 0
while time.time() < end:
    try:
        frame = sock.recv(65536)
    except socket.timeout:
        continue
    packets += 1
    if frame[12:14] == b"\x08\x00" and frame[23] == 17 and frame[30] >= 224:
        lcm += 1
print(lcm)
PY
# Everything that publishes by itself, for three seconds; $1: extra arguments.
captured() {
  local children=() url=("$@")
  "$bin/marco-sim" --config "$root/config/robots/michoacan.toml" --world "$root/config/worlds/lab.toml" \
    --ports "$folder/ports" "${url[@]}" >"$folder/sim.log" 2>&1 &
  children+=($!)
  "$bin/marco-slam" "${url[@]}" >"$folder/slam.log" 2>&1 &
  children+=($!)
  "$bin/marco-procman-deputy" -i here "${url[@]}" >"$folder/deputy.log" 2>&1 &
  children+=($!)
  sleep 1
  on_other python3 "$folder/capture.py" 3
  kill -TERM "${children[@]}" 2>/dev/null
  wait "${children[@]}" 2>/dev/null
}
packets=$(captured --lcm-url 'udpm://239.255.76.67:7667?ttl=1')
[ "$packets" -gt 10 ] || fail "with ttl 1 the capture sees only $packets packets: it proves nothing"
echo "with ttl 1 asked for: $packets packets leave"
packets=$(captured)
[ "$packets" = 0 ] || fail "by default $packets packets leave this host"
echo 'by default: none leaves'

# Orders: what is no word of the grammar stays a word.
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'
ip route replace 224.0.0.0/4 dev lo
ip link set lo multicast on
cat >"$folder/evil.procman" <<TEXT
cmd "semicolon" { exec = "echo one; touch $folder/owned1"; deputy = "localhost"; }
cmd "substitution" { exec = "echo \$(touch $folder/owned2)"; deputy = "localhost"; }
cmd "backticks" { exec = "echo \`touch $folder/owned3\`"; deputy = "localhost"; }
cmd "pipe" { exec = "echo x | touch $folder/owned4 && touch $folder/owned4"; deputy = "localhost"; }
cmd "variable" { exec = "echo \$EVIL"; deputy = "localhost"; }
script "go" { start everything; wait ms 1500; }
TEXT
EVIL="\$(touch $folder/owned5); touch $folder/owned5" timeout 30 "$bin/marco-procman-sheriff" -n -l \
  "$folder/evil.procman" go --on-script-complete exit >"$folder/sheriff.log" 2>&1 || fail 'the sheriff ended with an error'
grep -rq 'owned1' "$XDG_STATE_HOME" || fail 'the commands did not run at all'
[ -z "$(ls "$folder" | grep owned)" ] || fail "a shell ran: $(ls "$folder" | grep owned)"
echo 'five exec lines with shell syntax: no shell was started'

# A log whose channels are paths.
python3 - "$folder/evil.lcm" "$root" <<'PY'
import struct, sys
# bot_core.image_t (grey, 1 x 1) and text on channels that are paths.
IMAGE = bytes.fromhex("14739ffe13d5f5f0") + struct.pack(">qiii", 7, 1, 1, 1) + struct.pack(">i", 0x59455247) \
    + struct.pack(">i", 1) + b"\x00" + struct.pack(">i", 0)
with open(sys.argv[1], "wb") as log:
    for number, name in enumerate(["../../evil", "/tmp/marco_evil", "..", "a/../../../evil", ".bashrc", "~/evil"]):
        channel = name.encode()
        log.write(struct.pack(">IqqII", 0xEDA1DA01, number, 1000 + number, len(channel), len(IMAGE)) + channel + IMAGE)
PY
mkdir -p "$folder/a/b/out"
before=$(cd "$folder" && find . -path ./a/b/out -prune -o -print | sort)
for kind in csv images; do
  "$bin/marco-log" export --format $kind "$folder/evil.lcm" "$folder/a/b/out/$kind" >"$folder/export_$kind.log" 2>&1
  [ -n "$(ls -A "$folder/a/b/out/$kind" 2>/dev/null)" ] || fail "export $kind wrote nothing: $(cat "$folder/export_$kind.log")"
done
after=$(cd "$folder" && find . -path ./a/b/out -prune -o -print | grep -v 'export_' | sort)
[ "$before" = "$after" ] || fail "files outside of the folder: $(diff <(echo "$before") <(echo "$after"))"
[ ! -e /tmp/marco_evil ] && [ ! -e "$folder/../evil" ] || fail 'files outside of the folder'
find "$folder/a/b/out" -name '.*' ! -name '.marco-*' | grep -q . && fail 'hidden files were written'
echo "exports of channels that are paths: $(find "$folder/a/b/out" -type f | wc -l) files, all in their folder"
