#!/bin/bash
# What Debian wants of a package and CMake does not write: finish.sh PREFIX PACKAGE, called by CPack.
# MARCO_PACKAGE_VERSION, MARCO_PACKAGE_DATE (RFC 2822) and MARCO_MAINTAINER come from `./marco package`.
set -euo pipefail
prefix=$1 package=$2
doc="$prefix/share/doc/$package"
mkdir -p "$doc"
{
  printf 'marco-robot (%s) bookworm; urgency=medium\n\n' "$MARCO_PACKAGE_VERSION"
  printf '  * What is new: CHANGELOG.md in the package marco-robot-doc.\n\n'
  printf -- ' -- %s  %s\n' "$MARCO_MAINTAINER" "$MARCO_PACKAGE_DATE"
} | gzip -9n >"$doc/changelog.gz"
if [ -d "$prefix/share/man" ]; then find "$prefix/share/man" -type f -exec gzip -9n {} +; fi
find "$prefix" -type f -name '*.a' -exec "${STRIP:-strip}" --strip-debug --enable-deterministic-archives {} +
find "$prefix" -type f ! -perm -u+x -exec chmod 0644 {} +
find "$prefix" -type d -exec chmod 0755 {} +
