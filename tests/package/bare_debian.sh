#!/bin/bash
# The packages on a bare Debian: installed by apt, used by a user who is not root, purged. As root, with network.
# usage: bare_debian.sh PACKAGES [ROOT]       PACKAGES: a folder of .deb; ROOT: the bare Debian, made here and deleted
set -euo pipefail
packages=$(realpath "${1:?usage: bare_debian.sh PACKAGES [ROOT]}")
root=${2:-$(mktemp -d)/debian}
project="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
. "$project/tests/package/bare_root.sh"
if [ "${BARE_DEBIAN:-}" != inside ]; then BARE_DEBIAN=inside exec unshare -m "$0" "$packages" "$root"; fi
trap 'remove_bare_root "$root"' EXIT
as_user() { within setpriv --reuid=1234 --regid=1234 --clear-groups env HOME=/home/user "$@"; }
size() { du -smx "$root" | cut -f1; }

make_bare_root "$root"
mkdir "$root/packages" "$root/home/user"
cp "$packages"/*.deb "$root/packages"
cp "$project/logs/sample.lcm" "$root/home/user"
chown -R 1234:1234 "$root/home/user"
within apt-get update -qq
echo "a bare Debian: $(size) MB"
find "$root/etc" "$root/usr" "$root/opt" "$root/srv" "$root/lib" -xdev -path '*marco*' >"$root.before"

# The robot's computer: without the recommended packages.
begin=$SECONDS
within sh -c 'apt-get install -y -qq --no-install-recommends /packages/lcm-tools_*.deb /packages/marco-robot_*.deb' >"$root.said" 2>&1 ||
  { tail -20 "$root.said"; fail "apt-get install"; }
echo "marco-robot and lcm-tools: $((SECONDS - begin)) s, $(size) MB"
as_user sh -c 'cd && marco-robot check sample.lcm' | tail -1
as_user sh -c 'cd && marco-robot map sample.lcm --out small' >"$root.said" 2>&1 || { tail "$root.said"; fail "map without the viewer"; }
said=$(as_user marco-robot render small --out x.png 2>&1) && fail "render without the viewer ended with 0"
[[ "$said" == *'package marco-robot-viewer'* ]] || fail "render does not say which package it is in: $said"

begin=$SECONDS
within sh -c 'apt-get install -y -qq /packages/*.deb man-db' >"$root.said" 2>&1 || { tail -20 "$root.said"; fail "apt-get install of all"; }
echo "all packages and what they recommend: $((SECONDS - begin)) s, $(size) MB"
[ -z "$(within dpkg --audit)" ] || fail "dpkg --audit"
as_user marco-robot --version
within id marco-robot
within test ! -e /etc/systemd/system/multi-user.target.wants/marco-robot.service || fail "the service is on"

begin=$SECONDS
as_user sh -c 'cd && marco-robot demo --batch --out demo' >"$root.said" 2>&1 || { tail -20 "$root.said"; fail demo; }
for file in map.png model.png model_photographs.png; do
  [ -s "$root/home/user/demo/$file" ] || fail "the demo wrote no $file"
done
echo "demo --batch: $((SECONDS - begin)) s"
begin=$SECONDS
as_user sh -c 'cd && marco-robot map sample.lcm --out mine' | tail -1
[ -s "$root/home/user/mine/map.png" ] || fail "map wrote no map.png"
echo "map of sample.lcm: $((SECONDS - begin)) s"
[[ "$(as_user python3 -c 'import marco; print(marco.settings())')" == *"[slam]"* ]] || fail "import marco"
[[ "$(as_user marco-robot python -c 'import marco; print(marco.settings())')" == *"[slam]"* ]] || fail "marco-robot python"
as_user marco-robot devices --udev | grep -q ID_MM_DEVICE_IGNORE || fail "devices --udev"
for page in marco-robot marco-map marco-spy marco-viewer; do
  within man "$page" 2>/dev/null | grep -q SYNOPSIS || fail "man $page"
done

# The page answers on loopback, with three.js and the map.
cat >"$root/page.py" <<'PY'
import re, subprocess, urllib.request
page = subprocess.Popen(["marco-robot", "page", "/home/user/mine"], stdout=subprocess.PIPE, text=True)
address = re.search(r"http://[^ ]+", page.stdout.readline()).group(0)
text = urllib.request.urlopen(address).read().decode()
base = re.match(r"http://[^/]+", address).group(0)
three = urllib.request.urlopen(base + "/page/three.js").read()
page.terminate()
page.wait(10)
assert "<html" in text and len(three) > 100000, (text[:200], len(three))
print("the page answers:", len(text), "bytes, three.js", len(three))
PY
unshare -n chroot "$root" sh -c 'ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo
  exec setpriv --reuid=1234 --regid=1234 --clear-groups env -i PATH="$PATH" HOME=/home/user python3 /page.py' || fail "the page"

# A user's configuration goes with purge, recordings stay with their owner.
within sh -c 'echo x >/etc/marco-robot/robot.procman; install -d -o marco-robot /var/lib/marco-robot/run/recordings; echo x >/var/lib/marco-robot/run/recordings/live.lcm.00'
within sh -c 'apt-get purge -y -qq marco-robot marco-robot-viewer lcm-tools python3-marco-robot libmarco-robot-dev marco-robot-doc' \
  >"$root.said" 2>&1 || { tail -20 "$root.said"; fail purge; }
[ -e "$root/var/lib/marco-robot/run/recordings/live.lcm.00" ] || fail "purge took a recording"
find "$root/etc" "$root/usr" "$root/opt" "$root/srv" "$root/lib" -xdev -path '*marco*' | diff "$root.before" - || fail "purge left files"
within sh -c 'rm -r /var/lib/marco-robot; apt-get install -y -qq --no-install-recommends /packages/lcm-tools_*.deb /packages/marco-robot_*.deb &&
  apt-get purge -y -qq marco-robot lcm-tools' >"$root.said" 2>&1 || { tail -20 "$root.said"; fail "install and purge again"; }
[ ! -e "$root/var/lib/marco-robot" ] || fail "purge left /var/lib/marco-robot"
! within getent passwd marco-robot || fail "purge left the user"
! ls "$root"/var/lib/dpkg/info/*marco* 2>/dev/null || fail "purge left dpkg's files"
echo "bare Debian: all good"
