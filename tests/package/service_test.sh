#!/bin/bash
# The service's rights, as systemd judges them: an exposure of 3.0 at most, and units without mistakes. service_test.sh SOURCE-FOLDER
set -u
systemd-analyze security --help 2>/dev/null | grep -q -e --offline || { echo "SKIPPED: no systemd-analyze that judges files"; exit 77; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for unit in marco-robot marco-robot-loopback; do
  systemd-analyze security --offline=true --threshold=30 "$1/cmake/debian/$unit.service" >"$folder/said" 2>&1 || { cat "$folder/said"; exit 1; }
  tail -1 "$folder/said"
done
# Nothing that a unit does not know; the programs need not be installed here.
systemd-analyze verify --recursive-errors=no "$1"/cmake/debian/marco-robot{,-loopback}.service 2>&1 | grep -E 'Unknown|Invalid|Failed to parse' && exit 1
echo "the service's rights are few"
