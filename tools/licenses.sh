#!/bin/bash
# Prints what Marco depends on, in which version this machine has it and under which licence, checked against the
# copyright file of the package: licenses.sh TABLE PACKAGE...   Fails when a package has no row or says otherwise.
set -u
table=$1
shift
wrong=0
printf '%-24s %-28s %-38s %s\n' package version licence use
while IFS='|' read -r package use licence word; do
  case $package in '#'*|'') continue ;; esac
  version="$(dpkg-query -W -f='${Status} ${Version}' "$package" 2>/dev/null | sed -n 's/^install ok installed //p')"
  printf '%-24s %-28s %-38s %s\n' "$package" "${version:-(not installed)}" "$licence" "$use"
  [ -n "$version" ] || continue
  copyright=/usr/share/doc/$package/copyright
  if [ ! -r "$copyright" ]; then
    echo "licenses: $copyright is not there: not checked" >&2
  elif ! grep -qE "$word" "$copyright"; then
    echo "licenses: $copyright does not speak of $word" >&2
    wrong=1
  fi
done <"$table"
for package in "$@"; do
  grep -q "^$package|" "$table" || { echo "licenses: $package has no row in $table" >&2; wrong=1; }
done
echo
echo 'Marco itself: BSD-3-Clause. Nothing is downloaded at run time, nothing is vendored.'
exit $wrong
