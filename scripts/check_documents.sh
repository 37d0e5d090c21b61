#!/usr/bin/env bash
# Checks documents and comments: a document keeps to its length, each link leads to a file of the repository, each named file
# exists, DECISIONS.md lists each decision, and a README of its folder or of a folder above names each header.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

sources=$(find src tools tests scripts cmake -type f \( -name '*.md' -o -name '*.h' -o -name '*.cpp' -o -name '*.sh' -o -name '*.cmake' \
  -o -name '*.py' -o -name '*.js' -o -name '*.mjs' -o -name CMakeLists.txt \) -not -path src/DEPENDENCIES.md | sort)

# awk reads the names of all files and folders, then the sources.
find src tools tests scripts cmake ./*.* LICENSE -not -name '*.pyc' | sed 's|^\./||' | awk '
  function complain(what) { print FILENAME ":" FNR ": " what; ++faults }
  # Most lines of a document, or 0.
  function limit(path) {
    if (path == "README.md") return 180
    if (path ~ /^tools\/kiln\/manual\//) return 150
    if (path == "src/ARCHITECTURE.md") return 120
    if (path == "src/GLOSSARY.md") return 80
    if (path == "src/PAPERS.md") return 60
    if (path == "src/CONTRIBUTING.md" || path ~ /^src\/contributing\//) return 40
    if (path ~ /^src\/engine\/.*README\.md$/) return 200
    if (path ~ /\/README\.md$/) return 60
    if (path ~ /\/decisions\//) return 40
    return 0
  }
  function folderOf(path) { return path ~ /\// ? substr(path, 1, match(path, /\/[^\/]*$/) - 1) : "." }
  function stemOf(path) { sub(/.*\//, "", path); sub(/\.(h|cpp)$/, "", path); return path }
  # Whether a README names the file: in its folder, or in a folder above.
  function isDescribed(path,   at) {
    for (at = folderOf(path); at != "."; at = folderOf(at)) if ((at FS stemOf(path)) in described) return 1
    return 0
  }
  # A path without "." and "..".
  function plain(path,   part, n, i, out, depth) {
    n = split(path, part, "/")
    depth = 0
    for (i = 1; i <= n; ++i) {
      if (part[i] == "" || part[i] == ".") continue
      if (part[i] == ".." && depth > 0) --depth
      else out[++depth] = part[i]
    }
    path = out[1]
    for (i = 2; i <= depth; ++i) path = path "/" out[i]
    return path
  }
  function endLengths() { if (most > 0 && lines > most) { print last ": " lines " lines, more than " most; ++faults } }

  BEGIN { split("nifti1.h nifti2.h stdio.h", word, " "); for (w in word) foreign[word[w]] }
  FILENAME == "-" { known[$0]; name = $0; sub(/.*\//, "", name); named[name]; next }

  FNR == 1 {
    endLengths()
    last = FILENAME; most = limit(FILENAME); folder = folderOf(FILENAME)
    document = FILENAME ~ /\.md$/
    readme = FILENAME ~ /\/README\.md$/
    libraries = FILENAME == "src/DEPENDENCIES.md"
    comment = FILENAME ~ /\.(h|cpp|js|mjs)$/ ? "//" : "#"
    root_count = split(folder " " folderOf(folder) " . src tools tests tools/kiln", roots, " ")
  }
  { lines = FNR }
  FILENAME == "README.md" && !/^\|/ && length($0) > 110 { complain("a line is longer than 110 characters") }
  FILENAME == "src/ARCHITECTURE.md" && /^\|/ { n = split($0, cell, "|"); for (c = 2; c < n; ++c) if (length(cell[c]) > 162) complain("a cell is longer than 160 characters") }
  # The headers of a library, in the second cell of its row.
  libraries && split($0, cell, "|") > 4 { n = split(cell[3], word, "`"); for (w = 2; w <= n; w += 2) foreign[word[w]] }
  /^[ \t]*#[ \t]*include/ && comment == "//" { next }

  document {
    rest = $0
    while (match(rest, /\]\([^)#: ]+/)) {
      target = substr(rest, RSTART + 2, RLENGTH - 2)
      rest = substr(rest, RSTART + RLENGTH)
      ++checked
      target = plain(folder "/" target)
      linked[target FS FILENAME]
      if (!(target in known)) complain(target " is not there")
    }
  }

  {
    text = $0
    if (!document) { at = index(text, comment); if (at == 0 || substr(text, at - 1, 1) == "\"") next; text = substr(text, at) }
    words = split(text, word, /[^A-Za-z0-9_.\/:$~{}*<>-]+/)
    for (w = 1; w <= words; ++w) {
      sub(/[.:]+$/, "", word[w])
      if (readme) described[folder FS stemOf(word[w])]
      path = word[w]
      if (path ~ /NAME|ROOM|BUILD|SUBJECT/) continue
      if (path ~ /^[A-Za-z0-9_-]+\.(h|cpp)$/) {
        ++checked
        if (!(path in named) && !(path in foreign)) complain(path " is not there")
      }
      if (path !~ /^[A-Za-z0-9_-][A-Za-z0-9_-]*\/[A-Za-z0-9_.\/-]*\.(h|cpp|md|sh|cmake|py|js|mjs|txt|json)$/) continue
      if (path ~ /^(build|out)\//) continue
      ++checked
      found = path ~ /^kiln\// && ("src/" substr(path, 6)) in known  # an installed header
      for (i = 1; i <= root_count; ++i) if (plain(roots[i] "/" path) in known) found = 1
      if (!found) complain(path " is not there")
    }
  }

  END {
    endLengths()
    for (path in known) if (path ~ /\/decisions\/.*\.md$/ && !((path FS "src/DECISIONS.md") in linked)) { print path ": src/DECISIONS.md does not list it"; ++faults }
    for (path in known) if (path ~ /^(src|tools)\/.*\.h$/ && !isDescribed(path)) { print path ": no README of its folder or above names it"; ++faults }
    if (checked == 0) { print "no name was checked"; exit 1 }
    if (faults > 0) exit 1
    print checked " names in documents and comments lead to files"
  }
' - src/DEPENDENCIES.md README.md $sources
