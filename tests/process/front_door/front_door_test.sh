#!/bin/bash
# What ./marco installs, configures and builds for each command, on a machine that is played by stubs of apt-get,
# dpkg-query, cmake, ninja and id: nothing is installed or built. usage: front_door_test.sh PROJECT
set -u
project="$(cd "$1" && pwd)"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
failed=0
fail() { echo "FAILED: $*" >&2; failed=1; }

# A checkout with what the front door reads, and a machine: calls, the packages that are there, who we are.
clone="$folder/clone"
machine="$folder/machine"
mkdir -p "$clone/tools" "$clone/docs" "$machine/bin"
cp "$project/marco" "$project/CMakeLists.txt" "$project/CMakePresets.json" "$clone/"
cp "$project"/tools/*.sh "$clone/tools/"
touch "$machine/installed"
stub() { printf '#!/bin/bash\n%s\n' "$2" >"$machine/bin/$1"; chmod +x "$machine/bin/$1"; }
export machine clone
stub id '[ "${1:-}" = -u ] && echo "${PLAYED_UID:-0}"'
stub sudo '[ "${PLAYED_SUDO:-}" = yes ] || exit 1; [ "$1" != -n ] || shift; "$@"'
stub dpkg-query 'echo dpkg-query >>"$machine/calls"; sed "s/.*/installed:& /" "$machine/installed" | tr -d "\n"'
stub apt-cache '[[ $2 != "${UNHEARD_OF:-none}"* ]]'
stub apt-get 'echo "apt-get $*" >>"$machine/calls"
  [ "$1" = install ] || exit 0
  for word; do case $word in install | -*) ;; *) echo "$word" >>"$machine/installed" ;; esac; done'
stub cmake 'echo "cmake $*" >>"$machine/calls"; mkdir -p "build/$2"; touch "build/$2/build.ninja"'
stub ninja 'echo "ninja ${*:3}" >>"$machine/calls"
  [ -z "${BUILD_REPLACES:-}" ] || yes "exit 9" | head -c 100000 >"$BUILD_REPLACES"
  [ -z "${BUILD_FAILS:-}" ] || { echo "x.cpp: error: oh"; exit 1; }
  [ -f "$2/.built.${3:-all}" ] && { echo "ninja: no work to do."; exit; }
  touch "$2/.built.${3:-all}"
  echo "[1/1] Linking"
  mkdir -p "$2/bin"
  for target in "${@:3}"; do printf "#!/bin/bash\necho ran $target \"\$@\"\n" >"$2/bin/$target"; chmod +x "$2/bin/$target"; done'

# $@ arguments: runs the front door; its exit code in `code`, what it said in `out` and `err`, what it called in `calls`.
door() {
  : >"$machine/calls"
  out="$(cd "$clone" && PATH="$machine/bin:$PATH" ./marco "$@" 2>"$folder/err" </dev/null)"
  code=$?
  err="$(<"$folder/err")" calls="$(<"$machine/calls")"
}
expect_code() { [ "$code" = "$1" ] || fail "$2: exit code $code instead of $1: $err"; }
expect_in() { [[ "$1" == *"$2"* ]] || fail "$3: '$2' is not in: $1"; }
expect_not_in() { [[ "$1" != *"$2"* ]] || fail "$3: '$2' is in: $1"; }
fresh_machine() { rm -rf "$clone/build"; : >"$machine/installed"; }

# Help and mistakes cost nothing, on a machine with nothing.
commands=$(sed -n 's/^  \.\/marco \([a-z-]*\).*/\1/p' <(cd "$clone" && ./marco help) | sort -u)
[ "$(wc -w <<<"$commands")" -ge 17 ] || fail "usage lists too few commands: $commands"
for command in demo run replay test bench fuzz soak licenses; do
  for words in "$command --help" "$command -h" "help $command" "$command --quick --help"; do
    door $words
    expect_code 0 "$words"
    expect_in "$out" "./marco $command" "$words"
    [ -z "$calls" ] || fail "$words calls $calls"
  done
done
printf '# Options\n\n## log\n\n    how log is used\n\n## map --many\n\n    how many are mapped\n' >"$clone/docs/options.md"
for words in "log --help" "help log" "log info --help" "log --version"; do
  door $words
  expect_code 0 "$words"
  [ -z "$calls$err" ] || fail "$words, which is not built, calls $calls and says $err"
done
door log --help
[ "$out" = "how log is used" ] || fail "help of a program that is not built: $out"
door map --many DIR --help
[ "$out" = "how many are mapped" ] || fail "help of map --many: $out"
door localize map.lcm
expect_code 2 localize
expect_in "$err" "map --localize FOLDER LOG" localize
door mpa
expect_code 2 mpa
expect_in "$err" "unknown command 'mpa'; did you mean 'map'?" mpa
door test --lnog
expect_code 2 "test --lnog"
expect_in "$err" "unknown option '--lnog'; did you mean '--long'?" "test --lnog"
for words in "demo --out" "replay a.lcm --speed" "replay" "run" "replay a.lcm --spede 2" "fuzz --mintes 3" "soak --hour 3" \
  "bench --filter x"; do
  MARCO_BIN=/nowhere door $words
  expect_code 2 "$words"
done
door --version
expect_code 0 --version
[[ "$out" =~ ^marco\ [0-9]+\.[0-9]+\.[0-9]+$ ]] || fail "--version in a folder without git: $out"

# Root on a machine with nothing: the list is said before apt runs, and holds what the command needs and no more.
door evaluate a.tum b.relations
expect_code 0 evaluate
expect_in "$out" "ran marco-evaluate a.tum b.relations" evaluate
expect_in "$err" "installing" evaluate
expect_in "$calls" "apt-get update" evaluate
for package in libgtest libgmock libbenchmark libassimp libembree libosmesa clang tmux; do
  expect_not_in "$calls" $package evaluate
done
expect_in "$calls" "ninja marco-evaluate" evaluate
for package in $(sed -n 's/.*packages: //p' <<<"$err"); do grep -qx "$package" "$machine/installed" || fail "$package was said and not installed"; done

# Again: one ninja, nothing else, no word.
door evaluate a.tum b.relations
[ "$calls" = "ninja marco-evaluate" ] || fail "a second call calls: $calls"
[ -z "$err" ] || fail "a second call says: $err"
exec {building}>"$clone/build/release/.lock"
flock "$building"
door evaluate a.tum b.relations
[ "$out/$calls" = "ran marco-evaluate a.tum b.relations/" ] || fail "while another builds: $out, $calls"
expect_in "$err" "running the existing marco-evaluate" "while another builds"
exec {building}>&-
door evaluate --help
[ "$out/$calls" = "ran marco-evaluate --help/" ] || fail "help where the program is there: $out, $calls"

# The script is overwritten while it builds: it goes on as it was.
BUILD_REPLACES="$clone/marco" door evaluate a.tum b.relations
[ "$code/$out" = "0/ran marco-evaluate a.tum b.relations" ] || fail "an update while it runs: $code, $out, $err"
cp "$project/marco" "$clone/marco"

# A command that needs more: only that is installed, and optional components are looked for again.
door map a.lcm
expect_in "$calls" "apt-get install -y -q --no-install-recommends libosmesa6-dev libosmesa6 libgl-dev libgl2ps-dev" map
expect_in "$calls" "cmake --preset release" map
for package in libgtest libbenchmark libassimp libembree; do expect_not_in "$calls" $package map; done
door map a.lcm --world w.toml
expect_in "$calls" libembree-dev "map --world"
door bench
expect_in "$calls" libbenchmark-dev bench
expect_in "$calls" "cmake --preset release -DMARCO_BENCHMARKS=ON" bench
door fuzz sick
expect_in "$calls" "clang" fuzz
fresh_machine
UNHEARD_OF=libosmesa6 door map a.lcm
expect_in "$calls" libegl-dev "a system without OSMesa"
expect_in "$calls" libgl1-mesa-dri "a system without OSMesa"
expect_not_in "$calls" libosmesa6-dev "a system without OSMesa"
expect_code 0 "a system without OSMesa"

# Without root: the line to run, and nothing else happens; after it no root is needed.
fresh_machine
PLAYED_UID=1000 door evaluate a b
expect_code 1 "without root"
line=$(grep 'apt-get update && apt-get install' <<<"$err") || fail "without root no line to run: $err"
expect_not_in "$calls" apt-get "without root"
expect_not_in "$calls" ninja "without root"
(PATH="$machine/bin:$PATH"; eval "$line")
PLAYED_UID=1000 door evaluate a b
expect_code 0 "after root's line"
expect_not_in "$calls" apt-get "after root's line"

fresh_machine
PLAYED_UID=1000 PLAYED_SUDO=yes door evaluate a b
expect_code 0 "through sudo"
expect_in "$calls" "apt-get install" "through sudo"

# A build that fails, and programs that are given.
fresh_machine
BUILD_FAILS=yes door evaluate a b
expect_code 1 "a build that fails"
expect_in "$err" "x.cpp: error: oh" "a build that fails"
# Root passes every permission: a file stands where the folder should be.
rm -rf "$clone/build"
touch "$clone/build"
door evaluate a b
expect_code 1 "a folder that cannot be written"
expect_in "$err" "no permission to write" "a folder that cannot be written"
rm "$clone/build"
mkdir -p "$folder/given"
printf '#!/bin/bash\necho given "$@"\n' >"$folder/given/marco-map"
chmod +x "$folder/given/marco-map"
MARCO_BIN="$folder/given" door map x
[ "$out/$calls" = "given x/" ] || fail "MARCO_BIN: $out, $calls"

[ $failed = 0 ] && echo "the front door does what it should, and no more"
exit $failed
