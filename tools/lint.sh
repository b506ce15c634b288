#!/bin/bash
# Is the code laid out by .clang-format, what does .clang-tidy say of it, and how does it read? `./marco lint` calls this.
#   lint.sh format [FILE...]           names the files that clang-format would change
#   lint.sh tidy BUILD [FILE...]       runs clang-tidy over the sources that BUILD compiles; in a unity build, joined
#   lint.sh docs                       spelling, phrases of tools/phrases.txt and phrase_counts.txt, constants that decide
#                                      about a map without a comment, comments of headers that doxygen cannot follow
#   lint.sh lines                      lines of each room against the budget of tools/lines.txt
# Without FILEs: the whole tree. Exit code 1: something was found.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
what=${1:?usage: lint.sh format|tidy BUILD|docs|lines [FILE...]}
shift

# The layout differs between clang-format's versions: Debian 12's is the one that counts.
tool() {
  local name=$1 found
  for found in "$name-14" "$name"; do
    command -v "$found" >/dev/null || continue
    "$found" --version | grep -q 'version 14' && { echo "$found"; return; }
  done
  echo "marco lint: needs $name 14 (Debian 12's)" >&2
  exit 2
}

case $what in
  format)
    [ $# -gt 0 ] || mapfile -t files < <(git ls-files '*.cpp' '*.hpp')
    format=$(tool clang-format)
    printf '%s\0' "${@:-${files[@]}}" | xargs -0 -n 50 -P "$(nproc)" "$format" --dry-run --Werror
    ;;
  tidy)
    build=${1:?lint.sh tidy BUILD}
    shift
    tidy=$(tool clang-tidy)
    # Only what this build compiles: a header is judged through the sources that include it.
    mapfile -t compiled < <(grep -o '"file": "[^"]*"' "$build/compile_commands.json" | cut -d'"' -f4 |
      sed "s|^$PWD/||" | sort -u)
    if [ $# -gt 0 ]; then
      mapfile -t compiled < <(printf '%s\n' "${compiled[@]}" | awk 'NR == FNR { wanted[$0]; next } $0 in wanted' <(printf '%s\n' "$@") -)
    fi
    [ ${#compiled[@]} -gt 0 ] || { echo "clang-tidy: nothing to check"; exit 0; }
    echo "clang-tidy: ${#compiled[@]} files"
    judge() { xargs -r -d '\n' -n 1 -P "$(nproc)" "$tidy" -p "$build" --quiet "$@"; }
    found=0
    printf '%s\n' "${compiled[@]}" | awk '!/(^|\/)tests\//' | judge || found=1
    printf '%s\n' "${compiled[@]}" | awk '/(^|\/)tests\//' | judge --config-file=tests/.clang-tidy || found=1
    exit $found
    ;;
  docs)
    found=0
    mapfile -t texts < <(git ls-files | grep -E '\.(md|cpp|hpp|py|pyi|sh|lcm|toml|procman|cmake)$|^marco$|CMakeLists.txt$' | grep -v '^tools/phrases')
    # Words of the code and the theses that codespell takes for others.
    codespell --quiet-level 3 -L theses,kown,fro,crate,avance,nd,fo,ond,nees,statics "${texts[@]}" || found=1
    # What a merge left: both sides of a conflict.
    ! grep -nHE '^(<{7}|>{7}) ' "${texts[@]}" || found=1
    # Tests and old changes are left alone.
    mapfile -t read < <(printf '%s\n' "${texts[@]}" | grep -vE '(^|/)tests/|^CHANGELOG')
    while IFS='|' read -r phrase instead; do
      case $phrase in '#'*) continue ;; esac
      ! grep -niwH -e "$phrase" "${read[@]}" || { echo "  '$phrase': write $instead"; found=1; }
    done <tools/phrases.txt
    mapfile -t page < <(git ls-files 'web/page/*.js' 'web/page/*.html')
    while IFS='|' read -r phrase most instead; do
      case $phrase in '#'*) continue ;; esac
      lines=$(cat "${read[@]}" "${page[@]}" </dev/null | grep -icw -e "$phrase" || true)
      if [ "$lines" -gt "$most" ]; then
        echo "tools/phrase_counts.txt: '$phrase' in $lines lines, at most $most: write $instead"
        found=1
      elif [ "$lines" -lt "$most" ]; then
        echo "tools/phrase_counts.txt: '$phrase' fell to $lines lines: lower its $most"
      fi
    done <tools/phrase_counts.txt
    git ls-files -z 'common/*.[ch]pp' 'slam/*.[ch]pp' 'mapping3d/*.[ch]pp' | xargs -0 awk -f tools/bare_constants.awk || found=1
    mkdir -p build/doxygen
    warnings=$(doxygen Doxyfile 2>&1 >/dev/null | sort -u)
    [ -z "$warnings" ] || { echo "$warnings"; found=1; }
    exit $found
    ;;
  lines)
    python3 tools/lines.py
    ;;
  *)
    echo "lint.sh: format, tidy, docs or lines, not '$what'" >&2
    exit 2
    ;;
esac
