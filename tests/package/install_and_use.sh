#!/bin/bash
# Installs a build into an empty folder and looks at it from outside: nothing of it is where MATE's window manager, which
# Debian calls marco, has files; a project of another folder links each library; the installed front door works.
# usage: install_and_use.sh BUILD [headers]       headers: instead of all that, each installed header compiles alone
set -euo pipefail
source_folder="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
prefix="$folder/usr"
fail() { echo "FAILED: $*" >&2; exit 1; }

cmake --install "$1" --prefix "$prefix" >/dev/null
each_header=OFF
linker=""
! command -v ld.lld >/dev/null || linker=-fuse-ld=lld  # a hundred programs in a fifth of the time
[ "${2:-}" != headers ] || each_header=ON
cmake -G Ninja -S "$source_folder" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" -DEACH_HEADER=$each_header "-DCMAKE_EXE_LINKER_FLAGS=$linker" >"$folder/log" 2>&1 ||
  { cat "$folder/log"; fail "find_package(marco)"; }
cmake --build "$folder/build" -- -k 0 >"$folder/log" 2>&1 ||
  { grep -E "error:|undefined reference|cannot find" "$folder/log" | head -50; fail "an installed library or header"; }
[ $each_header = OFF ] || { echo "each header compiles alone"; exit; }
"$folder/build/use_all"

# The examples are such a project.
examples="$(cd "$source_folder/../../examples" && pwd)"
sample="$(cd "$source_folder/../../logs" && pwd)/sample.lcm"
cmake -G Ninja -S "$examples" -B "$folder/examples" -DCMAKE_CXX_FLAGS=-O1 -DCMAKE_UNITY_BUILD=ON -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 ||
  { cat "$folder/log"; fail "the examples' find_package(marco)"; }
cmake --build "$folder/examples" >"$folder/log" 2>&1 || { grep -E 'error:|undefined' "$folder/log" | head; fail "an example"; }
ctest --test-dir "$folder/examples/landmarks" >"$folder/log" 2>&1 || { cat "$folder/log"; fail "the tests of examples/landmarks"; }
mkdir "$folder/of_example"
"$folder/examples/map_a_log" "$sample" "$folder/of_example" | grep -q 'scans, .* loops' || fail map_a_log
[ -s "$folder/of_example/map.pgm" ] || fail "map_a_log wrote no map"
"$folder/examples/match_two_scans" "$sample" 0 20 | grep -Eq '([7-9].|100) % of the points' || fail match_two_scans
isolated="$source_folder/../../lcm_tools/tests/support/isolated.sh"
# A laser of one's own is mapped, and a subscriber of one's own hears the pose.
LASER="$folder/examples/my_laser" FOLLOW="$folder/examples/follow_the_robot" SLAM="$prefix/bin/marco-slam" \
  "$isolated" bash -c '
    "$SLAM" & slam=$!
    "$LASER" 20 & laser=$!
    timeout 20 "$FOLLOW" 5; told=$?
    kill $laser $slam; wait
    exit $told' >"$folder/log" 2>&1 || { cat "$folder/log"; fail "my_laser, marco-slam, follow_the_robot"; }
[ "$(grep -Ec '^x -?0.00 m, y -?0.00 m' "$folder/log")" = 5 ] || { cat "$folder/log"; fail "the laser that stands moved"; }
! "$isolated" "$folder/examples/go_to" 1 0 >"$folder/log" || fail "go_to without a base"
grep -q 'no base answers' "$folder/log" || fail "go_to does not say that no base answers"

# A folder in the list ends with a slash: nothing of ours lies in it.
(cd "$prefix" && find . -type f -o -type l) | sed 's|^\./||; s|/x86_64-linux-gnu/|/|' | sort >"$folder/ours"
grep -qx bin/marco-robot "$folder/ours" || fail "no front door is installed"
grep -q '^bin/marco-map$' "$folder/ours" || fail "no marco-map is installed"
while IFS= read -r path; do
  case $path in
    '#'* | '') ;;
    */) ! grep "^$path" "$folder/ours" || fail "$path is MATE's" ;;
    *) ! grep -Fx "$path" "$folder/ours" || fail "$path is MATE's" ;;
  esac
done <"$source_folder/mate_paths.txt"

door="$prefix/bin/marco-robot"
cd "$folder"
[[ "$("$door" --version)" == "marco-robot "[0-9]* ]] || fail "marco-robot --version"
[[ "$("$door" help)" == *$'\n  marco-robot map '* ]] || fail "marco-robot help"
"$door" map "$source_folder/../../logs/sample.lcm" --out map >map.log || fail "marco-robot map"
[ -s map/map.png ] && [ -s map/trajectory.tum ] || fail "marco-robot map wrote no map"
[[ "$("$door" log info "$source_folder/../../logs/sample.lcm")" == *LIDAR* ]] || fail "marco-robot log info"
[[ "$("$door" python -c 'import marco; print(marco.settings())')" == *"[slam]"* ]] || fail "marco-robot python"
"$door" bench >/dev/null 2>bench.log && fail "marco-robot bench has no sources and ended with 0"
grep -q 'in a clone of the project' bench.log || fail "marco-robot bench does not say what it needs"
[ "$(readlink -f "$prefix/share/marco-robot/marco")" = "$(readlink -f "$door")" ] || fail "procman scripts find no front door"
said=$("$isolated" "$door" run config/sim.procman nowhere -n 2>&1) && fail "marco-robot run has no script 'nowhere' and ended with 0"
[[ "$said" == *'no script "nowhere"'* ]] || fail "marco-robot run does not find config/sim.procman: $said"

# Each program has a man page; that of the front door has all its commands.
for program in "$prefix"/bin/*; do
  page="$prefix/share/man/man1/${program##*/}.1"
  grep -q '^.SH SYNOPSIS' "$page" || fail "${program##*/} has no man page"
done
for command in $("$door" help | sed -n 's/^  marco-robot \([a-z-]*\).*/\1/p' | sort -u); do
  grep -qx ".SH ${command^^}" "$prefix/share/man/man1/marco-robot.1" || fail "the man page does not tell of $command"
done
if command -v man >/dev/null; then
  for program in robot map procman-sheriff; do
    complaints=$(LC_ALL=C.UTF-8 man --warnings=all --local-file "$prefix/share/man/man1/marco-$program.1" 2>&1 >page.txt)
    [ -z "$complaints" ] || fail "man page of marco-$program: $complaints"
    # Each option as one would type it.
    for option in $("$prefix/bin/marco-$program" --help | grep -oE -e '--[a-z][a-z-]+' | sort -u); do
      grep -qF -e "$option" page.txt || fail "the man page of marco-$program does not tell of $option"
    done
  done
  # What roff would take for its own stays text.
  mkdir fake
  cat >fake/marco-fake <<'FAKE'
#!/bin/bash
cat <<'TEXT'
Draws a map.
.map is its ending,
'map' its name, and \n a new line.
Usage: marco-fake [OPTIONS]
TEXT
FAKE
  chmod +x fake/marco-fake
  "$source_folder/../../tools/man.sh" fake fake/man1 marco-fake
  LC_ALL=C.UTF-8 man --warnings=all --local-file fake/man1/marco-fake.1 >page.txt 2>&1 || fail "a man page of roff's own characters"
  for text in '.map is its ending,' "'map' its name, and \\n a new line." 'marco-fake [OPTIONS]'; do
    grep -qF -e "$text" page.txt || { cat page.txt; fail "the man page lacks: $text"; }
  done
fi

# bash completes commands, options and files.
completed() {
  PATH="$prefix/bin:$PATH" bash -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _marco_robot marco-robot; echo "${COMPREPLY[*]}"' \
    completed "$prefix/share/bash-completion/completions/marco-robot" marco-robot "$@"
}
[ "$(completed ren)" = render ] || fail "'ren' is completed to '$(completed ren)'"
[ "$(completed map --cal)" = "--calibrate --calibration" ] || fail "'map --cal' is completed to '$(completed map --cal)'"
[ -z "$(completed map no_op)" ] || fail "what is no option is completed"

# pip makes the module of the installed libraries; what the clone holds is not used.
if /usr/bin/python3 -c 'import importlib.util as u; exit(not all(map(u.find_spec, ("venv", "ensurepip", "pip", "setuptools", "wheel"))))'; then
  cp -r "$source_folder/../../python" "$folder/python"
  /usr/bin/python3 -m venv --system-site-packages "$folder/venv"
  CMAKE_PREFIX_PATH="$prefix" CMAKE_ARGS=-DCMAKE_BUILD_TYPE= "$folder/venv/bin/pip" install --no-build-isolation --no-index "$folder/python" \
    >"$folder/log" 2>&1 || { tail -20 "$folder/log"; fail "pip install ./python"; }
  said=$("$folder/venv/bin/python" -c "import marco; print(marco.__file__, marco.map('$sample').verdict)") || fail "import marco, by pip"
  [[ "$said" == "$folder/venv/"*" good" ]] || fail "import marco, by pip: $said"
else
  echo "without venv, pip, setuptools and wheel: pip is not tested"
fi
echo "installed: all good"
