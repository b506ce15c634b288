# Constants that decide something and do not say why: `constexpr double kName = 0.3;` and what counts how often or how
# many at least or at most, without a comment beside it, above it, or above the constants right before it.
# awk -f bare_constants.awk FILE...; exit code 1 where there is one. Numbers of formats and sizes of arrays are no matter.
function judge(   code) {
  code = text
  sub(/\/\/.*/, "", code)
  if (code ~ /numeric_limits|numbers::|sizeof/ || text ~ /\/\// || above) return
  if (code !~ /constexpr (double|float|Duration) / &&
      (code ~ /static/ || code !~ /(int|int64_t|std::size_t) k[A-Za-z]*(Least|Fewest|Min|Rounds|Iterations|Times|Tries)/)) return
  if (code ~ /= *-?k[A-Z][A-Za-z0-9]*;/) return  # another one's name
  sub(/^ */, "", code)
  printf "%s:%d: %s: say where it comes from, or what it does\n", FILENAME, line, code
  found = 1
}
FNR == 1 { text = ""; comment = covered = 0 }
text != "" { text = text " " $0 }
text == "" && /^ *(inline |static )?constexpr [A-Za-z_:<>, 0-9]+ k[A-Z]/ {
  text = $0
  line = FNR
  above = comment || covered
}
text != "" {
  if (text !~ /;/) next
  judge()
  covered = above || text ~ /\/\//
  comment = 0
  text = ""
  next
}
{ comment = /^ *\/\//; covered = 0 }
END { exit found }
