// The syntax of NRRD: a magic line, then "field: value" lines, comments, and the user's own pairs, which are skipped.
// Values are interpreted elsewhere. Source: teem.sourceforge.net/nrrd/format.html.
#include "ingest/nrrd/nrrd_header.h"

#include <map>

#include "base/error.h"
#include "base/text.h"

namespace kiln {
namespace {

using Names = std::map<std::string, std::string>;

// Maps every spelling of the format's fields to one name.
const Names& fieldNames() {
  static const Names kNames = [] {
    Names names = {{"datafile", "data file"},      {"lineskip", "line skip"}, {"byteskip", "byte skip"},
                   {"centerings", "centers"},      {"axismins", "axis mins"}, {"axismaxs", "axis maxs"},
                   {"blocksize", "block size"},    {"oldmin", "old min"},     {"oldmax", "old max"},
                   {"sampleunits", "sample units"}};
    for (const char* name : {"data file",
                             "line skip",
                             "byte skip",
                             "centers",
                             "axis mins",
                             "axis maxs",
                             "block size",
                             "old min",
                             "old max",
                             "sample units",
                             "dimension",
                             "type",
                             "encoding",
                             "endian",
                             "content",
                             "min",
                             "max",
                             "number",
                             "sizes",
                             "spacings",
                             "thicknesses",
                             "labels",
                             "units",
                             "kinds",
                             "space",
                             "space dimension",
                             "space units",
                             "space origin",
                             "space directions",
                             "measurement frame"}) {
      names[name] = name;
    }
    return names;
  }();
  return kNames;
}

[[noreturn]] void failAt(const File& file, int line, const std::string& what) {
  throw Error(ErrorCode::kFormat, file.path(), "line " + std::to_string(line), what);
}

}  // namespace

NrrdHeader readNrrdHeader(const File& file) {
  NrrdHeader header{HeaderFields(file.path()), 0, false, {}};
  HeaderLines lines(file);
  const std::string magic = lines.next().value_or("");
  const bool versioned = magic.size() == 8 && magic.starts_with("NRRD") && doubleOf(magic.substr(4)).has_value();
  if (!versioned) failAt(file, 1, "does not begin with NRRD0001 to NRRD0005; not a NRRD file");
  if (magic < "NRRD0001" || magic > "NRRD0005") {
    throw Error(ErrorCode::kUnsupported, file.path(), "line 1",
                inQuotes(magic) + " is no version that is read (1 to 5)");
  }
  while (const std::optional<std::string> line = lines.next()) {
    if (line->empty()) {
      header.closed = true;
      break;
    }
    if (line->front() == '#') continue;
    const std::size_t colon = line->find(':');
    if (colon == std::string::npos) failAt(file, lines.number(), inQuotes(*line) + " is not 'field: value'");
    const std::string written = trimmed(line->substr(0, colon));
    const auto name = fieldNames().find(lowered(written));
    // A key-value pair of the user, whose key may have colons.
    const bool is_pair = line->find(":=", colon) != std::string::npos;
    if (line->substr(colon, 2) == ":=" || (is_pair && name == fieldNames().end())) continue;
    if (name == fieldNames().end()) failAt(file, lines.number(), inQuotes(written) + " is not a field of NRRD");
    header.fields.add({name->second, written, trimmed(line->substr(colon + 1)), lines.number()});
    // The lines behind "data file: LIST" are names of files and no fields.
    if (name->second == "data file" && namesList(header.fields.find("data file")->value)) header.listed = lines.rest();
  }
  header.end_offset = lines.endOffset();
  return header;
}

}  // namespace kiln
