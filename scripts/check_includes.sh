#!/usr/bin/env bash
# Checks that the code keeps to the two tables of src/ARCHITECTURE.md: a folder includes only what its row allows, and a
# third-party header stays in the files that its row names. The tables are read, not repeated here.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

# awk reads the tables, then every #include as FILE:LINE:TEXT.
includes=$(grep -rnE --include='*.h' --include='*.cpp' '^[[:space:]]*#[[:space:]]*include' src tools)
folders=$(find src -name '*.h' -printf '%P\n' -o -name '*.cpp' -printf '%P\n' | sed 's|/[^/]*$||' | sort -u)
FOLDERS=$folders awk '
  function complain(where, what) { print where ": " what; ++faults }
  function exists(path,   line, found) { found = (getline line < path) >= 0; close(path); return found }
  # The words in backticks of a table cell, separated by spaces.
  function quoted(cell,   parts, n, i, out) {
    n = split(cell, parts, "`")
    for (i = 2; i <= n; i += 2) out = out " " parts[i]
    return out " "
  }

  # Whether a word of a row allows the header: the header itself, its folder, or, with a slash behind, a folder and all below.
  function allows(words, header, from,   word, n, i) {
    n = split(words, word, " ")
    for (i = 1; i <= n; ++i) {
      if (word[i] == header || word[i] == from) return 1
      if (word[i] ~ /\/$/ && index(from "/", word[i]) == 1) return 1
    }
    return 0
  }

  FILENAME == "src/ARCHITECTURE.md" {
    if (/^## /) section = $0
    if (!/^\| /) next
    split($0, cell, "|")
    if (section ~ /Folders/ && cell[2] ~ /`/) {
      name = quoted(cell[2]); gsub(/ /, "", name); sub(/\/$/, "", name)
      may[name] = quoted(cell[4])
      rows = rows " " name " "
      n = split(may[name], words, " ")
      for (i = 1; i <= n; ++i) {
        folder = words[i]
        if (folder ~ /\.h$/) sub(/\/[^\/]*$/, "", folder)
        found = 0
        for (row in may) if (row != name && (row == folder || (folder ~ /\/$/ && index(row "/", folder) == 1))) found = 1
        if (!found) complain(FILENAME ":" FNR, name " may include " words[i] ", which has no row above")
      }
    }
    if (section ~ /Third-party/ && cell[3] ~ /`/) {
      n = split(quoted(cell[3]), words, " ")
      for (i = 1; i <= n; ++i) homes[words[i]] = (cell[4] ~ /anywhere/) ? "anywhere" : quoted(cell[4])
      m = split(quoted(cell[4]), words, " ")
      for (i = 1; i <= m; ++i) if (words[i] !~ /\/$/ && !exists((words[i] ~ /^tools\//) ? words[i] : "src/" words[i])) complain(FILENAME ":" FNR, words[i] " is not there")
    }
    next
  }

  {
    split($0, field, ":")
    file = field[1]; where = file ":" field[2]
    home = file; sub(/^src\//, "", home)
    folder = home; sub(/\/[^\/]*$/, "", folder)
    if (!(folder in may)) { if (!(folder in missing)) complain(where, folder " has no row in src/ARCHITECTURE.md"); missing[folder]; next }
    ++checked
    header = $0
    if (header ~ /include[ \t]*"/) {
      sub(/^[^"]*"/, "", header); sub(/".*/, "", header)
      if (header !~ /\//) {
        if (folder !~ /^tools\/kiln/ || !exists("tools/kiln/" header)) complain(where, "\"" header "\" does not name its folder")
        next
      }
      from = header; sub(/\/[^\/]*$/, "", from)
      if (from ~ /^(bench|python)(\/|$)/) from = "tools/" from
      if (from != folder && !allows(may[folder], header, from)) complain(where, folder " may not include \"" header "\"")
      else if (!exists("src/" header) && !exists("tools/" header)) complain(where, "\"" header "\" is not a header of src/")
    } else {
      sub(/^[^<]*</, "", header); sub(/>.*/, "", header)
      if (header !~ /[\/.]/) next  # the standard library
      for (prefix in homes) if (index(header, prefix) == 1) {
        directory = home; sub(/[^\/]*$/, "", directory)
        if (homes[prefix] != "anywhere" && index(homes[prefix], " " home " ") == 0 && index(homes[prefix], " " directory " ") == 0) complain(where, "<" header "> belongs in" homes[prefix] "only")
        next
      }
      complain(where, "<" header "> has no row in src/ARCHITECTURE.md")
    }
  }

  END {
    n = split(ENVIRON["FOLDERS"], words, "\n")
    for (i = 1; i <= n; ++i) if (!(words[i] in may)) complain("src/" words[i], "has no row in src/ARCHITECTURE.md")
    if (checked == 0) complain("src/ARCHITECTURE.md", "no include was checked")
    if (faults > 0) exit 1
    print checked " includes keep to src/ARCHITECTURE.md"
  }
' src/ARCHITECTURE.md - <<<"$includes"
