# Completion of `marco-robot` for bash, installed where bash looks for it. In a clone: . tools/completion.bash
# Commands are those that `marco-robot help` prints, options those of the command's --help. In a clone options are left to
# you: there --help may build a program first.
_marco_robot() {
  local door=$1 word=${COMP_WORDS[COMP_CWORD]} known=""
  if [ "$COMP_CWORD" = 1 ]; then
    known=$("$door" help 2>/dev/null | sed -n "s|^  [./]*marco[a-z-]* \([a-z-]*\).*|\1|p" | sort -u)
  elif [[ $word == -* && ${door##*/} == marco-robot ]]; then
    known=$("$door" "${COMP_WORDS[1]}" --help 2>/dev/null | grep -oE -e '(^|[ ,[|])--[a-z][a-z-]*' | sed 's/^[^-]*//' | sort -u)
  fi
  mapfile -t COMPREPLY < <(compgen -W "$known" -- "$word")
}
complete -o default -F _marco_robot marco-robot ./marco
