#!/bin/bash
# .ci/run tells what each step took, also where one fails, and ends as the step did. usage: ci_test.sh PROJECT
set -u
project="$(cd "$1" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*: $said" >&2; exit 1; }
mkdir "$folder/.ci"
cp "$project/.ci/run" "$folder/.ci/"
printf '#!/bin/bash\ncase "$*" in "test --peers") sleep 1.1 ;; "$FAILS") exit 7 ;; esac\n' >"$folder/marco"
chmod +x "$folder/marco"

said=$(FAILS=nothing "$folder/.ci/run") || fail "steps that pass end with $?"
for step in 'lint --format' 'lint --lines' 'test' 'test --peers' 'test --asan' 'fuzz --ci'; do
  grep -qE "^ +0:0[0-9]  ./marco $step\$" <<<"$said" || fail "no minutes of '$step'"
done
grep -qE '^ +0:0[1-9]  ./marco test --peers$' <<<"$said" || fail "a step that took a second is told as less"
[[ "${said##*$'\n'}" =~ ^\ +0:0[1-9]\ \ in\ all$ ]] || fail "the last line is not the sum"

said=$(FAILS="test --asan" "$folder/.ci/run")
[ $? = 7 ] || fail "a step that fails: another exit code"
grep -qE '^ +0:0[0-9]  ./marco test --asan  \(failed\)$' <<<"$said" || fail "the step that failed is not told"
grep -qE '^ +0:0[1-9]  ./marco test --peers$' <<<"$said" || fail "steps before the one that failed are not told"
! grep -q 'fuzz' <<<"$said" || fail "a step after the one that failed is told"
echo "the minutes of each step are told"
