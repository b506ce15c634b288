#!/bin/bash
# Robot and laptop without multicast between them: two network namespaces joined by a cable, LCM on loopback in each, a
# relay on both. What the robot says is heard on the laptop; orders are not passed on, a stop is; each side is killed and
# started again, the cable is cut, and it goes on by itself. An LCM program with tcpq:// needs no relay of its own.
#   two_hosts_test.sh BIN-FOLDER SOURCE-FOLDER
set -u
bin=$1
root=$2
source "$root/tests/support/two_networks.sh"
# Multicast stays on each host: not even its route leads to the cable.
ip route replace 224.0.0.0/4 dev lo
ip link set lo multicast on
on_other ip link set lo multicast on
on_other ip route replace 224.0.0.0/4 dev lo
# As a user sets it: without the receive buffer, which our programs ask for themselves.
export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'

cat >"$folder/say.py" <<'PYTHON'
# say.py CHANNEL COUNT PERIOD_S [BYTES]: numbers as text, of this length, on this host's LCM.
import ctypes, sys, time
length = int(sys.argv[4]) if len(sys.argv) > 4 else 0
lcm = ctypes.CDLL('liblcm.so.1')
lcm.lcm_create.restype = ctypes.c_void_p
bus = ctypes.c_void_p(lcm.lcm_create(None))
for i in range(int(sys.argv[2])):
    data = (b'%s %d' % (sys.argv[1].encode(), i)).ljust(length)
    lcm.lcm_publish(bus, sys.argv[1].encode(), data, len(data))
    time.sleep(float(sys.argv[3]))
PYTHON
cat >"$folder/hear.py" <<'PYTHON'
# hear.py URL FILE: a line for each message.
import ctypes, sys
lcm = ctypes.CDLL('liblcm.so.1')
lcm.lcm_create.restype = ctypes.c_void_p
url = sys.argv[1] + ('&recv_buf_size=4194304' if sys.argv[1].startswith('udpm') else '')
bus = ctypes.c_void_p(lcm.lcm_create(url.encode()))
class Buffer(ctypes.Structure):
    _fields_ = [('data', ctypes.c_void_p), ('size', ctypes.c_uint32), ('time', ctypes.c_int64), ('lcm', ctypes.c_void_p)]
out = open(sys.argv[2], 'a', buffering=1)
def heard(buffer, channel, _):
    b = Buffer.from_address(buffer)
    text = ctypes.string_at(b.data, b.size)
    out.write('%s: %s\n' % (channel.decode(), text.decode(errors='replace').rstrip() if text.isascii() else 'binary'))
handler = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)(heard)
lcm.lcm_subscribe(bus, b'.*', handler, None)
while lcm.lcm_handle(bus) == 0:
    pass
PYTHON

robot_relay() {
  "$bin/marco-relay" --listen 10.77.0.1:7700 >>"$folder/robot.log" 2>&1 &
  robot=$!
  started+=("$robot")
}
laptop_relay() {
  start_on_other "$bin/marco-relay" --connect 10.77.0.1:7700 >>"$folder/laptop.log" 2>&1
  laptop=${started[-1]}
}
# $1 text, $2 file, $3 seconds
wait_for() {
  for _ in $(seq $((${3:-20} * 10))); do
    grep -q "$1" "$2" 2>/dev/null && return
    sleep 0.1
  done
  fail "'$1' does not come to $2"
}
start_on_other python3 "$folder/hear.py" "$LCM_DEFAULT_URL" "$folder/laptop_heard"
python3 "$folder/hear.py" "$LCM_DEFAULT_URL" "$folder/robot_heard" & started+=($!)
robot_relay
laptop_relay
wait_for 'connected' "$folder/robot.log"
sleep 0.3

python3 "$folder/say.py" LIDAR 50 0.01
python3 "$folder/say.py" BASE_COMMAND 3 0.01
python3 "$folder/say.py" PM_ORDERS 3 0.01
wait_for 'LIDAR: LIDAR 49' "$folder/laptop_heard"
[ "$(grep -c '^LIDAR:' "$folder/laptop_heard")" = 50 ] || fail 'not each message comes once'
on_other python3 "$folder/say.py" BASE_COMMAND 3 0.01
on_other python3 "$folder/say.py" PM_ORDERS 3 0.01
on_other python3 "$folder/say.py" MAP_REQUEST 1 0.01
on_other timeout 3 "$bin/marco-stop" >/dev/null 2>&1  # nobody answers
wait_for '^MAP_REQUEST: ' "$folder/robot_heard"
wait_for '^EMERGENCY_STOP: ' "$folder/robot_heard"
# Each host said six orders itself, and hears no others.
for host in robot laptop; do
  [ "$(grep -c 'BASE_COMMAND\|PM_ORDERS' "$folder/${host}_heard")" = 6 ] || fail "orders came to the $host"
done
echo 'messages pass once in both directions, orders do not, a stop does'

most=$(cat /proc/sys/net/core/rmem_max)
if [ "$most" -ge 2097152 ]; then
  # Beside it one that is given too little, and counts what it loses.
  "$bin/marco-relay" --listen 7701 --lcm-url "$LCM_DEFAULT_URL&recv_buf_size=4096" >"$folder/small.log" 2>&1 & small=$!
  sleep 1
  python3 "$folder/say.py" GRID 180 0.0333 1000000
  wait_for 'GRID: GRID 179' "$folder/laptop_heard"
  sleep 1
  [ "$(grep -c '^GRID:' "$folder/laptop_heard")" = 180 ] ||
    fail "of 180 messages of 1 MB $(grep -c '^GRID:' "$folder/laptop_heard") came"
  kill -TERM "$small"
  wait "$small"
  grep -q '[1-9][0-9]* datagrams lost in the receive buffer; ' "$folder/small.log" || fail 'the loss is not counted'
  echo '180 of 180 messages of 1 MB, 30 a second'
else
  grep -q "rmem_max" "$folder/robot.log" || fail "the relay does not say that $most bytes are too small a buffer"
  echo "not tried: messages of 1 MB (net.core.rmem_max is $most)"
fi

kill -KILL "$robot"
wait_for 'disconnected' "$folder/laptop.log"
robot_relay
sleep 2.5
python3 "$folder/say.py" AGAIN 1 0.01
wait_for 'AGAIN 0' "$folder/laptop_heard"
kill -KILL "$laptop"
laptop_relay
sleep 1.5
python3 "$folder/say.py" ONCE_MORE 1 0.01
wait_for 'ONCE_MORE 0' "$folder/laptop_heard"
echo 'either side was killed and is back'

ip link set cable_a down
python3 "$folder/say.py" LOST 20 0.01
sleep 12  # longer than a silent peer is borne
ip link set cable_a up
ip route replace 10.77.0.0/24 dev cable_a
for _ in $(seq 20); do
  python3 "$folder/say.py" BACK 1 0.5
  grep -q 'BACK 0' "$folder/laptop_heard" && break
done
grep -q 'BACK 0' "$folder/laptop_heard" || fail 'the link is back, and nothing comes'
echo 'the cable was cut and is back'

start_on_other python3 "$folder/hear.py" tcpq://10.77.0.1:7700 "$folder/tcpq_heard"
sleep 1
python3 "$folder/say.py" POSE 3 0.01
wait_for 'POSE: POSE 2' "$folder/tcpq_heard"
echo 'a program with tcpq:// hears without a relay of its own'
