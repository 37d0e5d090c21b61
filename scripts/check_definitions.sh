#!/usr/bin/env bash
# Checks that no two files define a type of one name in one namespace: the linker takes one of two such types for both,
# and says nothing.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

find src tools \( -name '*.h' -o -name '*.cpp' \) -print0 | sort -z | xargs -0 awk '
  FNR == 1 { depth = 0; own = FILENAME ~ /-inl\.h$/ }  # those are compiled once for each instruction set
  /^namespace[^;]*\{$/ {
    name[++depth] = $2
    if ($2 == "{") ++own
    next
  }
  /^}  \/\/ namespace/ {
    if (depth > 0 && name[depth] == "{") --own
    if (depth > 0) --depth
    next
  }
  /^(struct|class|enum|union) [^;]*\{/ && own == 0 {
    sub(/^(struct|class|enum class|enum|union) /, "")
    sub(/[^A-Za-z0-9_:].*/, "")
    whole = ""
    for (i = 1; i <= depth; ++i) whole = whole name[i] "::"
    whole = whole $0
    ++types
    if (whole in home && home[whole] != FILENAME) { print FILENAME ":" FNR ": " whole " is defined in " home[whole] ", too"; ++faults }
    home[whole] = FILENAME
  }
  END {
    if (types == 0) { print "no type was found"; exit 1 }
    if (faults > 0) exit 1
    print types " types have a name of their own"
  }
'
