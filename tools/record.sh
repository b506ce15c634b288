#!/bin/bash
# Records all channels with lcm-logger for as long as it is let: record.sh FILE [KB_LEFT_FREE]
# The newest piece is FILE.0, the one before it FILE.1 and so on: a new one after 500 MB, a full disk or a crash. Of more
# than 20 the oldest is deleted (MARCO_RECORD_MB, MARCO_RECORD_PIECES). While the disk has less room than KB_LEFT_FREE
# (20480) it waits and says so. LCM_DEFAULT_URL says what is recorded.
set -u
file=$1 least_kb=${2:-20480}
ended=no child=

leave() {
  ended=yes
  [ -n "$child" ] && kill -INT "$child" 2>/dev/null
}
trap leave INT TERM

is_full() { [ "$(df -k --output=avail "$(dirname "$file")" | tail -1)" -lt "$least_kb" ]; }

# A signal ends `wait`, not what is waited for.
run() {
  "$@" &
  child=$!
  while kill -0 "$child" 2>/dev/null; do
    wait "$child"
    code=$?
  done
  child=
}

while [ $ended = no ]; do
  if is_full; then
    echo "record: less than $least_kb kB left on the disk: recording waits for room" >&2
    while [ $ended = no ] && is_full; do run sleep 1; done
    continue
  fi
  run lcm-logger -q --split-mb="${MARCO_RECORD_MB:-500}" --rotate="${MARCO_RECORD_PIECES:-20}" "$file"
  [ $ended = yes ] && break
  echo "record: lcm-logger ended with $code; a new file is begun" >&2
  run sleep 0.5
done
