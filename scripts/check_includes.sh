#!/usr/bin/env bash
# Checks that a folder includes only what its row in src/ARCHITECTURE.md allows, and that a third-party header stays in the
# files that its row in src/DEPENDENCIES.md names. The tables are read, not repeated here.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

# awk reads the tables, then every #include as FILE:LINE:TEXT.
includes=$(grep -rnE --include='*.h' --include='*.cpp' '^[[:space:]]*#[[:space:]]*include' src tools)
folders=$(find src tools -name '*.h' -o -name '*.cpp' | sed 's|^src/||; s|/[^/]*$||' | sort -u)
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

  # Words with the sets of folders written out: ENGINES becomes all its folders.
  function expanded(words,   word, n, i, out) {
    n = split(words, word, " ")
    for (i = 1; i <= n; ++i) out = out " " ((word[i] in set) ? set[word[i]] : word[i])
    return out " "
  }

  # The folders of a first cell: names in backticks, where a/{b,c}/ stands for a/b/ and a/c/.
  function foldersOf(cell, folder,   word, part, n, m, i, j, count, start) {
    n = split(quoted(cell), word, " ")
    for (i = 1; i <= n; ++i) {
      sub(/\/$/, "", word[i])
      start = index(word[i], "{")
      if (start == 0) { folder[++count] = word[i]; continue }
      m = split(substr(word[i], start + 1, index(word[i], "}") - start - 1), part, ",")
      for (j = 1; j <= m; ++j) folder[++count] = substr(word[i], 1, start - 1) part[j]
    }
    return count
  }

  # A row allows rows above it alone, and the folders of a row are strangers to one another.
  function readFolders(names, words,   name, word, folder, n, m, i, j, row, found) {
    gsub(/^ +| +$/, "", names)
    words = expanded(words)
    n = foldersOf(names, name)
    m = split(words, word, " ")
    for (i = 1; i <= m; ++i) {
      folder = word[i]
      if (folder ~ /\.h$/) sub(/\/[^\/]*$/, "", folder)
      found = 0
      for (row in may) if (row == folder || (folder ~ /\/$/ && index(row "/", folder) == 1)) found = 1
      if (!found) complain(FILENAME ":" FNR, names " may include " word[i] ", which has no row above")
    }
    for (i = 1; i <= n; ++i) {
      if (name[i] in may) complain(FILENAME ":" FNR, name[i] " has a row above")
      for (row in may) if (allows(may[row], "", name[i])) complain(FILENAME ":" FNR, row " above may include " name[i])
      for (j = 1; j <= n; ++j) if (i != j && allows(words, "", name[i])) complain(FILENAME ":" FNR, name[j] " may include " name[i] " of the same row")
    }
    for (i = 1; i <= n; ++i) may[name[i]] = words
  }

  FILENAME == "src/ARCHITECTURE.md" {
    if (/^- `[A-Z]+` = /) { n = split(quoted($0), words, " "); for (i = 2; i <= n; ++i) set[words[1]] = set[words[1]] " " words[i] }
    if (!/^\| /) next
    split($0, cell, "|")
    if (cell[2] ~ /`/) readFolders(cell[2], quoted(cell[4]))
    next
  }

  FILENAME == "src/DEPENDENCIES.md" {
    if (!/^\| /) next
    split($0, cell, "|")
    if (cell[3] !~ /`/) next
    n = split(quoted(cell[3]), words, " ")
    for (i = 1; i <= n; ++i) homes[words[i]] = (cell[4] ~ /anywhere/) ? "anywhere" : homes[words[i]] quoted(cell[4])
    m = split(quoted(cell[4]), words, " ")
    for (i = 1; i <= m; ++i) if (words[i] !~ /\/$/ && !exists((words[i] ~ /^tools\//) ? words[i] : "src/" words[i])) complain(FILENAME ":" FNR, words[i] " is not there")
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
      complain(where, "<" header "> has no row in src/DEPENDENCIES.md")
    }
  }

  END {
    n = split(ENVIRON["FOLDERS"], words, "\n")
    for (i = 1; i <= n; ++i) { there[words[i]]; if (!(words[i] in may)) complain(words[i], "has no row in src/ARCHITECTURE.md") }
    for (row in may) if (!(row in there)) complain("src/ARCHITECTURE.md", row " has no source file")
    if (checked == 0) complain("src/ARCHITECTURE.md", "no include was checked")
    if (faults > 0) exit 1
    print checked " includes keep to src/ARCHITECTURE.md and src/DEPENDENCIES.md"
  }
' src/ARCHITECTURE.md src/DEPENDENCIES.md - <<<"$includes"
