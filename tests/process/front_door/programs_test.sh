#!/bin/bash
# Every program helps, says its version and refuses an option that nobody knows, by the table of exit codes (0, 0, 2),
# and touches nothing meanwhile. usage: programs_test.sh BIN
set -u
bin="$(cd "$1" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
failed=0 count=0
fail() { echo "FAILED: $*" >&2; failed=1; }
for program in "$bin"/marco-*; do
  [ -x "$program" ] || continue
  name="${program##*/}" count=$((count + 1))
  for word in --help -h --version; do
    timeout 60 "$program" "$word" >out 2>err </dev/null || fail "$name $word ends with $?"
    [ -s out ] && [ ! -s err ] || fail "$name $word does not speak on stdout alone: $(<err)"
  done
  [[ "$(<out)" =~ ^$name\ [0-9]+\.[0-9]+\.[0-9]+(\ \([0-9a-f]+\))?$ ]] || fail "$name --version says $(<out)"
  timeout 60 "$program" --no-such-option >out 2>err </dev/null
  [ $? = 2 ] || fail "$name --no-such-option does not end with 2"
  [ -s err ] && [ ! -s out ] || fail "$name --no-such-option does not speak on stderr alone"
  rm -f out err
  [ -z "$(ls -A)" ] || fail "$name left $(ls -A)"
done
[ $count -ge 30 ] || fail "only $count programs in $bin"
[ $failed = 0 ] && echo "$count programs help, say their version, and refuse"
exit $failed
