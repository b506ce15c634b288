#!/bin/bash
# Records all channels with lcm-logger for as long as it is let: record.sh FILE [KB_LEFT_FREE]
# The newest piece is FILE.0, the one before it FILE.1 and so on: a new one after 500 MB, a full disk or a crash. Of more
# than 20 the oldest is deleted (MARCO_RECORD_MB, MARCO_RECORD_PIECES). While FILE's folder cannot be written, or the disk
# has less room than KB_LEFT_FREE (20480), it waits and says so. LCM_DEFAULT_URL says what is recorded.
set -u
[ $# -ge 1 ] || { echo "usage: record.sh FILE [KB_LEFT_FREE]" >&2; exit 2; }
file=$1 folder=$(dirname "$1") least_kb=${2:-20480}
pieces=${MARCO_RECORD_PIECES:-20}
ended=no

trap 'ended=yes' INT TERM

is_full() { [ "$(df -k --output=avail "$folder" | tail -1)" -lt "$least_kb" ]; }

# A signal ends `wait`, not what is waited for. procman tells our children, too, and lcm-logger told twice ends in the
# midst of an event: it is reported only when recording continues.
run() {
  local child told=no
  "$@" &
  child=$!
  while kill -0 "$child" 2>/dev/null; do
    wait "$child"
    code=$?
    [ $ended = yes ] && [ $told = no ] || continue
    sleep 0.5
    kill -INT "$child" 2>/dev/null
    told=yes
  done
}

# lcm-logger would continue in FILE.0, behind an event that was cut off: where lcm-logplayer stops.
begin_new_piece() {
  local i
  [ -e "$file.0" ] || return 0
  rm -f "$file.$((pieces - 1))"
  for ((i = pieces - 2; i >= 0; --i)); do
    [ ! -e "$file.$i" ] || mv "$file.$i" "$file.$((i + 1))"
  done
}

while [ $ended = no ]; do
  if [ ! -w "$folder" ]; then
    echo "record: $folder cannot be written: recording waits" >&2
    while [ $ended = no ] && [ ! -w "$folder" ]; do run sleep 1; done
    continue
  fi
  if is_full; then
    echo "record: less than $least_kb kB left on the disk: recording waits for room" >&2
    while [ $ended = no ] && is_full; do run sleep 1; done
    continue
  fi
  begin_new_piece
  run lcm-logger -q --split-mb="${MARCO_RECORD_MB:-500}" --rotate="$pieces" "$file"
  [ $ended = yes ] && break
  echo "record: lcm-logger ended with $code; a new file is begun" >&2
  run sleep 0.5
done
