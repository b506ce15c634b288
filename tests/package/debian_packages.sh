#!/bin/bash
# The Debian packages of a build: what they need and hold; and used without root, unpacked into a folder, by another user
# from whom sources and build are hidden.
# usage: debian_packages.sh SOURCE BUILD
set -euo pipefail
source_folder=$(realpath "$1") build=$(realpath "$2")
. "$source_folder/lcm_tools/tests/support/namespaces.sh"
[ -n "$own" ] || { echo 'SKIPPED: this system forbids mount namespaces'; exit 0; }
command -v dpkg-shlibdeps >/dev/null || { echo 'SKIPPED: dpkg-dev is not installed'; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
unset MARCO_BIN

root=$source_folder
. "$source_folder/tools/package.sh"
# Static libraries of a build for tests are large: the package of a release has them.
pack "$build" "$folder/packages" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip \
  -D 'CPACK_COMPONENTS_ALL=lcm-tools;marco-robot;marco-robot-viewer;marco-robot-doc;python3-marco-robot'
cd "$folder/packages"
names=$(for deb in *.deb; do dpkg-deb -f "$deb" Package; done | sort | tr '\n' ' ')
[ "$names" = "lcm-tools marco-robot marco-robot-doc marco-robot-viewer python3-marco-robot " ] || fail "the packages are $names"

field() { dpkg-deb -f "$1"_*.deb "$2"; }
version=$(field marco-robot Version)
[[ $version == 0.*.* ]] || fail "version $version"
for package in lcm-tools marco-robot; do
  [[ "$(field $package Depends)" == *'libc6 (>= '*liblcm1* ]] || fail "$package needs: $(field $package Depends)"
  ! grep -E 'opencv|libegl|osmesa|libgl' <<<"$(field $package Depends)" || fail "$package needs OpenCV or OpenGL"
done
! grep embree <<<"$(field lcm-tools Depends)" || fail "lcm-tools needs the simulator's library"
[[ "$(field marco-robot Depends)" == *"lcm-tools (= $version)"* ]] || fail "marco-robot takes any lcm-tools"
[[ "$(field marco-robot-viewer Depends)" == *"marco-robot (= $version)"*libopencv-core* ]] || fail "marco-robot-viewer"
[[ "$(field marco-robot Recommends)" == *marco-robot-viewer* ]] || fail "marco-robot does not recommend the viewer"
[ "$(field marco-robot-doc Architecture)" = all ] || fail "the manual is of an architecture"
dpkg-deb -e marco-robot_*.deb "$folder/control"
for script in postinst prerm postrm; do
  sh -n "$folder/control/$script" || fail "$script"
  [ -x "$folder/control/$script" ] || fail "$script is no program"
done

# Each file once; root's, and nobody else writes it.
for deb in *.deb; do
  dpkg-deb -c "$deb" >"$folder/list"
  ! grep -vE '^([-d]rwxr-xr-x|-rw-r--r--|lrwxrwxrwx) root/root ' "$folder/list" || fail "modes or owners in $deb"
  dpkg -x "$deb" "$folder/root"
  grep -v '^d' "$folder/list" | awk '{ print $6 }' >>"$folder/files"
  [ -s "$folder/root/usr/share/doc/${deb%%_*}/changelog.gz" ] || fail "$deb has no changelog"
done
[ -z "$(sort "$folder/files" | uniq -d)" ] || fail "in two packages: $(sort "$folder/files" | uniq -d)"
[ "$(grep -c '/usr/bin/' "$folder/files")" = "$(find "$folder/root/usr/share/man/man1" -name '*.1.gz' | wc -l)" ] || fail "programs and man pages differ in number"
for file in lib/systemd/system/marco-robot.service lib/udev/rules.d/60-marco.rules share/bash-completion/completions/marco-robot \
  share/doc/marco-robot/docs/installing.md lib/python3/dist-packages/marco/__init__.py; do
  [ -e "$folder/root/usr/$file" ] || fail "no $file"
done
! grep -rlF "$source_folder" "$folder/root/usr/share" "$folder/root/usr/lib/systemd" || fail "names the folder of the sources"

# By hand, as somebody without root would, under another name where this test may take one.
chmod 755 "$folder" "$folder/root"
mkdir -m 777 "$folder/home"
cp "$source_folder/logs/sample.lcm" "$folder/home"
cat >"$folder/use.sh" <<'USE'
set -euo pipefail
[ ! -e "$SOURCE/CMakeLists.txt" ] || { echo "the sources are not hidden" >&2; exit 1; }
cd "$HOME"
door="$PREFIX/bin/marco-robot"
[[ "$("$door" --version)" == "marco-robot "[0-9]* ]]
"$door" map sample.lcm --out mine | tail -1
[ -s mine/map.png ] && [ -s mine/report.json ]
[[ "$("$door" log info sample.lcm)" == *LIDAR* ]]
[[ "$("$door" python -c 'import marco; print(marco.settings())')" == *"[slam]"* ]]
"$door" devices --udev | grep -q ID_MM_DEVICE_IGNORE
"$door" export mine --html mine.html >/dev/null
"$door" demo --batch --out demo >demo.log 2>&1 || { tail -5 demo.log; exit 1; }
[ -s demo/model.png ]
! "$door" run config/sim.procman nowhere -n 2>run.log || exit 1
grep -q 'no script "nowhere"' run.log || { cat run.log; exit 1; }
coproc "$door" page mine 2>page.log
read -r -t 20 line <&"${COPROC[0]}" || { cat page.log; exit 1; }
address=$(grep -oE 'http://[^ ]+' <<<"$line")
/usr/bin/python3 -c 'import sys, urllib.request as u; sys.exit(b"<html" not in u.urlopen(sys.argv[1]).read())' "$address"
kill "$COPROC_PID"
USE
other=()
[ "$(awk '$3 > 65534' /proc/self/uid_map)" = "" ] || [ "$(id -u)" != 0 ] || other=(setpriv --reuid=65534 --regid=65534 --clear-groups)
[ ${#other[@]} -gt 0 ] || echo "as this user: another one needs root"
map=(-m)
[ "$(id -u)" = 0 ] || map=(-rm)
HOME="$folder/home" PREFIX="$folder/root/usr" SOURCE="$source_folder" unshare "${map[@]}" bash -c '
  mount -t tmpfs none "$SOURCE" && shift && exec "$@"' hidden "$source_folder" \
  "${other[@]}" bash "$folder/use.sh" || fail "used without root"
echo "packages: all good"
