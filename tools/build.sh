# Configures and builds what a command needs; read by ./marco, whose root, needs, say and fail it uses.

# ninja's lines from stdin, also into the file $2. Prints nothing where nothing is to be done. Else $1 is, and the lines
# follow on a terminal, in one that changes; or, where there is none, only if ninja fails (see build).
show_progress() {
  local line begun=no width
  while IFS= read -r line; do
    case $line in
      "ninja: Entering directory"* | "ninja: no work to do.") continue ;;
      '['*'] The commit' | '['*'] Re-checking globbed directories'*) continue ;;
    esac
    if [ $begun = no ]; then
      begun=yes
      say "building ($1)"
      : >"$2"
      shopt -s checkwinsize; (:)
      width=$((${COLUMNS:-80} - 1))
    fi
    printf '%s\n' "$line" >>"$2"
    [ -t 2 ] || continue
    case $line in
      '['*/*']'*) printf '\r\033[K%s' "${line:0:width}" >&2 ;;
      *) printf '\r\033[K%s\n' "$line" >&2 ;;
    esac
  done
  [ $begun = no ] || [ ! -t 2 ] || printf '\r\033[K' >&2
}

# $1 preset. Again when the presets changed, or when more packages are there than the last time was asked for: optional
# components are found then.
configure() {
  local preset=$1 folder="$root/build/$1" log="$root/build/$1.log" name known="" is_known=yes fresh=()
  [ -f "$folder/configured_for" ] && known=$(<"$folder/configured_for")
  # Where a preset names another compiler, CMake forgets the preset's other values, and says so only in its log.
  [ -f "$folder/build.ninja" ] && [ "$root/CMakePresets.json" -nt "$folder/build.ninja" ] && fresh=(--fresh) known=""
  for name in "${needs[@]}"; do
    [[ " $known " == *" $name "* ]] || { known="$known $name"; is_known=no; }
  done
  [ $is_known = yes ] && [ -f "$folder/build.ninja" ] && return
  say "configuring ($preset)"
  mkdir -p "$folder"
  (cd "$root" && cmake "${fresh[@]}" --preset "$preset" "${configure_options[@]}") >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
  echo "$known" >"$folder/configured_for"
}
configure_options=()

# $1 preset. Whether another ./marco builds at this moment.
is_building() {
  local lock="$root/build/$1/.lock"
  [ -z "$given_programs" ] && [ -w "$lock" ] && ! flock -n "$lock" true
}

# $1 preset, then targets (none = all). Nothing is done where the programs are given (MARCO_BIN, or installed).
build() {
  local preset=$1 folder="$root/build/$1" log="$root/build/$1.log" lock
  shift
  [ -z "$given_programs" ] || return 0
  # Somebody else's checkout: as it is.
  [ -f "$folder/build.ninja" ] && [ ! -w "$folder" ] && return
  install_packages
  mkdir -p "$folder" 2>/dev/null && [ -w "$folder" ] || fail "no permission to write $root/build, where programs are built"
  exec {lock}>"$folder/.lock"
  flock -n "$lock" || { say "waiting for another ./marco that is building here"; flock "$lock"; }
  configure "$preset"
  if ! ninja -C "$folder" "$@" 2>&1 | show_progress "$preset" "$log"; then
    [ -t 2 ] || cat "$log" >&2
    fail "the build failed; its output is in $log"
  fi
  exec {lock}>&-
}
