#!/bin/bash
# Man pages of the installed programs, from what they say to --help; `cmake --install` calls this.
#   man.sh BIN MAN1 NAME...     BIN: the folder of the programs; MAN1: where NAME.1 go
set -euo pipefail
bin=${1:?usage: man.sh BIN MAN1 NAME...} folder=${2:?usage: man.sh BIN MAN1 NAME...}
shift 2
mkdir -p "$folder"

# Text as it stands, to roff: what roff takes for its own is escaped.
as_is() {
  echo .nf
  sed -e 's/\\/\\e/g' -e 's/-/\\-/g' -e "s/^[.']/\\\\\\&&/"
  echo .fi
}

heading() { printf '.SH %s\n' "$1"; }

# $1 name, $2 its version, $3 its help: a first sentence, what else there is to say, Usage, Positionals and Options.
page() {
  local name=$1 version=$2 help=$3 sentence
  sentence=$(sed -n '/^Usage: /d; /[^ ]/ { s/\\/\\e/g; s/[.:]$//; p; q }' <<<"$help")
  printf '.TH %s 1 "" "%s" "Marco"\n' "${name^^}" "$version"
  heading NAME
  printf '%s \\- %s\n' "${name//-/\\-}" "${sentence//-/\\-}"
  heading SYNOPSIS
  if grep -q '^Usage: ' <<<"$help"; then sed -n 's/^Usage: *//p' <<<"$help" | as_is; else printf '%s COMMAND ...\n' "${name//-/\\-}"; fi
  heading DESCRIPTION
  sed '/^Usage: /,$d' <<<"$help" | as_is
  sed -n '/^Usage: /,$p' <<<"$help" | sed '1d' | as_is
}

for name; do
  program="$bin/$name"
  if [ "$name" = marco-robot ]; then help=$("$program" help); else help=$("$program" --help); fi
  version=$("$program" --version 2>/dev/null | head -1) || version=Marco
  {
    page "$name" "$version" "$help"
    [ "$name" != marco-robot ] || for command in $(sed -n "s|^  $name \([a-z-]*\).*|\1|p" <<<"$help" | sort -u); do
      heading "${command^^}"
      { "$program" "$command" --help 2>/dev/null || true; } | as_is
    done
    heading "SEE ALSO"
    if [ "$name" = marco-robot ]; then echo 'The project'"'"'s README and docs/'; else echo '.BR marco\-robot (1)'; fi
  } >"$folder/$name.1"
done
