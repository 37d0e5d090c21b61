#!/usr/bin/env bash
# Fails where a file of src/ includes what src/ARCHITECTURE.md does not allow, naming file and line. The tables there are the
# rule; that the folders form no circle follows from rows naming only rows above them, which is checked, too.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../src"

{ cat ARCHITECTURE.md; echo '=== includes'
  grep -rnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]' --include='*.cpp' --include='*.h' . | LC_ALL=C sort -t: -k1,1 -k2,2n; } | awk -F'|' '
  function trim(s) { gsub(/^[ \t]+|[ \t]+$/, "", s); return s }
  function fail(place, text) { print "src/" place ": " text > "/dev/stderr"; failed = 1 }
  function libraryOf(h) {
    if (h ~ /^openvdb\//) return "openvdb"
    if (h ~ /^(tbb|oneapi)\//) return "tbb"
    if (h ~ /^(OpenEXR\/|Imath\/|Imf|Imath|half\.h|Iex)/) return "openexr"
    if (h ~ /^(png|pngconf)\.h$/) return "png"
    if (h ~ /^(zlib|zconf)\.h$/) return "zlib"
    if (h ~ /^(xxhash|xxh3)\.h$/) return "xxhash"
    if (h ~ /^nlohmann\//) return "nlohmann"
    return ""
  }
  /^=== includes/ { includes = 1; next }
  !includes {
    key = trim($2)
    if (key == "folder" && trim($4) == "may include") { table = "folder"; next }
    if (key == "library" && trim($3) == "where") { table = "library"; next }
    if ($0 !~ /^\|/) { table = ""; next }
    if (key ~ /^-+$/ || table == "") next
    n = split(trim(table == "folder" ? $4 : $3), names, " ")
    for (i = 1; i <= n; ++i) {
      if (names[i] == "-") continue
      if (table == "folder" && !(names[i] in known)) fail("ARCHITECTURE.md:" NR, key " names " names[i] ", which is not a row above it")
      allowed[key, names[i]] = 1
    }
    if (table == "folder") { known[key] = 1; ++folders }
    next
  }
  {
    # ./folder/file:line:#include "header"
    split($0, part, ":")
    file = substr(part[1], 3); place = file ":" part[2]
    folder = file; sub(/\/.*/, "", folder)
    header = $0; sub(/^[^"<]*["<]/, "", header); sub(/[">].*/, "", header)
    ++count
    if (!(folder in known)) { fail(place, folder " has no row in ARCHITECTURE.md"); next }
    to = header
    if (to ~ /\// && sub(/\/.*/, "", to) && to in known && to != folder && !((folder, to) in allowed))
      fail(place, folder " may not include " header)
    library = libraryOf(header)
    if (library != "" && !((library, file) in allowed)) fail(place, header " may not be included here")
  }
  END {
    if (!folders || !count) fail("ARCHITECTURE.md", "no folder table or no includes found")
    exit failed
  }'
