// NRRD 1 to 5, attached (.nrrd) or with the data beside the header (.nhdr). Source:
// teem.sourceforge.net/nrrd/format.html. World space is RAS or LPS where `space` says one of them;
// left-anterior-superior is mirrored in x into RAS, so that the frame is one that Kiln names. The world of any other
// space has no patient.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "ingest/formats.h"
#include "ingest/header_text.h"
#include "ingest/linear_source.h"

namespace kiln {
namespace {

using Names = std::map<std::string, std::string>;

// Every field of the format, and the name it has here.
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

struct Header {
  HeaderFields fields;
  std::uint64_t end_offset = 0;
  bool closed = false;  // by the empty line that data may follow
};

[[noreturn]] void failAt(const File& file, int line, const std::string& what) {
  throw Error(ErrorCode::kFormat, file.path(), "line " + std::to_string(line), what);
}

Header readHeader(const File& file) {
  Header header{HeaderFields(file.path()), 0, false};
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
    if (line->substr(colon, 2) == ":=") continue;  // a key with a value of the user's own
    const std::string written = trimmed(line->substr(0, colon));
    const auto name = fieldNames().find(lowered(written));
    if (name == fieldNames().end()) failAt(file, lines.number(), inQuotes(written) + " is not a field of NRRD");
    header.fields.add({name->second, written, trimmed(line->substr(colon + 1)), lines.number()});
  }
  header.end_offset = lines.endOffset();
  return header;
}

VoxelType typeOf(const HeaderFields& fields) {
  static const std::map<std::string, VoxelType> kTypes = [] {
    std::map<std::string, VoxelType> types = {{"float", VoxelType::f32}, {"double", VoxelType::f64}};
    const auto name = [&](VoxelType type, std::initializer_list<const char*> spellings) {
      for (const char* spelling : spellings) types[spelling] = type;
    };
    name(VoxelType::i8, {"signed char", "int8", "int8_t"});
    name(VoxelType::u8, {"uchar", "unsigned char", "uint8", "uint8_t"});
    name(VoxelType::i16, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"});
    name(VoxelType::u16, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"});
    name(VoxelType::i32, {"int", "signed int", "int32", "int32_t"});
    name(VoxelType::u32, {"uint", "unsigned int", "uint32", "uint32_t"});
    return types;
  }();
  static const char* const kWide[] = {
      "longlong", "long long", "long long int", "signed long long",   "signed long long int",
      "int64",    "int64_t",   "ulonglong",     "unsigned long long", "unsigned long long int",
      "uint64",   "uint64_t"};
  const HeaderField& field = fields.require("type");
  const std::string type = lowered(field.value);
  const auto found = kTypes.find(type);
  if (found != kTypes.end()) return found->second;
  if (type == "block") fields.unsupported(field, "opaque blocks ('block') have no scalar value; give a scalar volume");
  if (std::find(std::begin(kWide), std::end(kWide), type) != std::end(kWide)) {
    fields.unsupported(field,
                       "64-bit integers (" + inQuotes(type) + ") are not read; convert them to double or 32 bits");
  }
  fields.fail(field, inQuotes(field.value) + " is not a NRRD type");
}

void refuseWhatIsNotAScalarVolume(const HeaderFields& fields) {
  if (const HeaderField* kinds = fields.find("kinds")) {
    for (const std::string& kind : words(lowered(kinds->value))) {
      if (kind == "domain" || kind == "space" || kind == "???" || kind == "none") continue;
      if (kind == "time") fields.unsupported(*kinds, "a series over time; give one volume of it");
      fields.unsupported(*kinds, "vector, tensor or colour data (" + inQuotes(kind) + "); give a scalar volume");
    }
  }
  const HeaderField* directions = fields.find("space directions");
  if (directions) {
    for (const std::string& word : words(lowered(directions->value))) {
      if (word == "none") fields.unsupported(*directions, "vector, tensor or colour data (an axis has no direction)");
    }
  }
  const HeaderField& dimension = fields.require("dimension");
  if (fields.integers(dimension, 1)[0] != 3) {
    fields.unsupported(dimension, dimension.value + "-D data; give a volume of three dimensions");
  }
}

// "(1,0,0) (0,1,0) …" as numbers: punctuation must be where the format has it.
std::vector<glm::dvec3> vectorsOf(const HeaderFields& fields, const HeaderField& field, std::size_t count) {
  std::vector<glm::dvec3> out;
  std::string_view rest = field.value;
  while (!rest.empty()) {
    const std::size_t close = rest.find(')');
    if (rest.front() != '(' || close == std::string_view::npos) break;
    HeaderField inside = field;
    inside.value = std::string(rest.substr(1, close - 1));
    if (std::count(inside.value.begin(), inside.value.end(), ',') != 2) break;
    std::replace(inside.value.begin(), inside.value.end(), ',', ' ');
    out.push_back(fields.vector(inside));
    rest.remove_prefix(close + 1);
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
  }
  if (!rest.empty() || out.size() != count) {
    fields.fail(field, inQuotes(field.value) + " is not " + std::to_string(count) + " vectors like (1,0,0)");
  }
  return out;
}

PatientFrame frameOf(const HeaderFields& fields, bool& mirror_x) {
  const HeaderField* space = fields.find("space");
  const HeaderField* count = fields.find("space dimension");
  if (space && count) fields.fail(*count, "contradicts 'space' in line " + std::to_string(space->line));
  if (count && fields.integers(*count, 1)[0] != 3) fields.unsupported(*count, count->value + "-D space is not read");
  if (!space) return PatientFrame::kUnknown;
  const std::string name = lowered(space->value);
  if (name == "right-anterior-superior" || name == "ras") return PatientFrame::kRas;
  if (name == "left-posterior-superior" || name == "lps") return PatientFrame::kLps;
  if (name == "left-anterior-superior" || name == "las") {
    mirror_x = true;
    return PatientFrame::kRas;
  }
  if (name == "scanner-xyz" || name == "3d-right-handed" || name == "3d-left-handed") return PatientFrame::kUnknown;
  static const char* const kOverTime[] = {"right-anterior-superior-time",
                                          "rast",
                                          "left-posterior-superior-time",
                                          "lpst",
                                          "left-anterior-superior-time",
                                          "last",
                                          "scanner-xyz-time",
                                          "3d-right-handed-time",
                                          "3d-left-handed-time"};
  const bool over_time = std::find(std::begin(kOverTime), std::end(kOverTime), name) != std::end(kOverTime);
  if (over_time) fields.unsupported(*space, inQuotes(space->value) + " has a time axis; give one volume of the series");
  fields.fail(*space, inQuotes(space->value) + " is not a space of NRRD");
}

// The unit where all axes have the same, else nothing.
std::string unitOf(const HeaderFields& fields) {
  const HeaderField* field = fields.find("space units");
  if (!field) field = fields.find("units");
  std::string unit;
  for (std::size_t at = 0; field && (at = field->value.find('"', at)) != std::string::npos;) {
    const std::size_t end = field->value.find('"', at + 1);
    if (end == std::string::npos) fields.fail(*field, "a quotation mark is not closed");
    const std::string one = field->value.substr(at + 1, end - at - 1);
    if (!unit.empty() && unit != one) return "";
    unit = one;
    at = end + 1;
  }
  return unit;
}

// Axis by axis, where there are no directions.
glm::dmat4 affineOfAxes(const HeaderFields& fields, const Extent3& dims, const SourceOptions& options) {
  const auto optional = [&](const char* key) {
    const HeaderField* field = fields.find(key);
    return field ? fields.vector(*field) : glm::dvec3(std::nan(""));
  };
  const glm::dvec3 mins = optional("axis mins"), maxs = optional("axis maxs");
  glm::dvec3 spacing = optional("spacings"), origin(0);
  const HeaderField* centers = fields.find("centers");
  const std::vector<std::string> kinds = centers ? words(lowered(centers->value)) : std::vector<std::string>(3);
  if (kinds.size() != 3) fields.fail(*centers, "one word an axis is expected");
  for (int axis = 0; axis < 3; ++axis) {
    const bool cell = kinds[axis] == "cell";
    const double steps = static_cast<double>(cell ? dims[axis] : dims[axis] - 1);
    // The spacing that the range implies, where the header gives a range only; NaN, "unknown", means 1.
    if (std::isnan(spacing[axis]) && steps > 0) spacing[axis] = (maxs[axis] - mins[axis]) / steps;
    if (std::isnan(spacing[axis])) spacing[axis] = 1;
    if (options.spacing) spacing[axis] = (*options.spacing)[axis];
    // A cell's range starts at its face, a node's at its sample.
    if (!std::isnan(mins[axis])) origin[axis] = mins[axis] + (cell ? spacing[axis] / 2 : 0);
  }
  if (const HeaderField* field = fields.find("space origin")) origin = vectorsOf(fields, *field, 1)[0];
  return axesAffine(spacing, origin);
}

VolumeGeometry geometryOf(const HeaderFields& fields, const SourceOptions& options) {
  VolumeGeometry geometry;
  geometry.dims = fields.extent(fields.require("sizes"));
  geometry.unit = unitOf(fields);
  bool mirror_x = false;
  geometry.frame = frameOf(fields, mirror_x);
  const HeaderField* directions = fields.find("space directions");
  if (directions) {
    if (options.spacing) {
      throw Error(ErrorCode::kUsage, fields.path(), "line " + std::to_string(directions->line),
                  "--spacing does not apply: the file gives its axes in 'space directions'");
    }
    for (const char* key : {"spacings", "axis mins", "axis maxs"}) {
      const HeaderField* other = fields.find(key);
      if (!other) continue;
      const glm::dvec3 v = fields.vector(*other);
      const bool all_nan = std::isnan(v.x) && std::isnan(v.y) && std::isnan(v.z);
      if (!all_nan) fields.fail(*other, "contradicts 'space directions' in line " + std::to_string(directions->line));
    }
    const std::vector<glm::dvec3> v = vectorsOf(fields, *directions, 3);
    const HeaderField* origin = fields.find("space origin");
    geometry.world_from_index =
        directionsAffine({v[0], v[1], v[2]}, origin ? vectorsOf(fields, *origin, 1)[0] : glm::dvec3(0));
  } else {
    geometry.world_from_index = affineOfAxes(fields, geometry.dims, options);
  }
  if (mirror_x) {
    for (int column = 0; column < 4; ++column) geometry.world_from_index[column].x *= -1;
  }
  requireInvertible(geometry.world_from_index, fields.path().string());
  return geometry;
}

DataEncoding encodingOf(const HeaderFields& fields) {
  const HeaderField& field = fields.require("encoding");
  const std::string name = lowered(field.value);
  if (name == "raw") return DataEncoding::kRaw;
  if (name == "gzip" || name == "gz") return DataEncoding::kGzip;
  for (const char* other : {"txt", "text", "ascii", "hex", "bz2", "bzip2"}) {
    if (name == other) fields.unsupported(field, inQuotes(field.value) + " is not read; write the file as raw or gzip");
  }
  fields.fail(field, inQuotes(field.value) + " is not an encoding of NRRD");
}

bool bigEndian(const HeaderFields& fields, VoxelType type) {
  if (sizeOf(type) == 1 && !fields.find("endian")) return false;
  const HeaderField& field = fields.require("endian");
  const std::string name = lowered(field.value);
  if (name != "big" && name != "little") fields.fail(field, inQuotes(field.value) + " is neither big nor little");
  return name == "big";
}

std::filesystem::path dataFileOf(const Header& header) {
  const HeaderField* field = header.fields.find("data file");
  if (!field) {
    if (header.closed) return header.fields.path();
    throw Error(ErrorCode::kFormat, header.fields.path(), "end of the file",
                "the header ends without the empty line before the data, and names no data file");
  }
  return header.fields.dataFile(*field);
}

// The byte after `lines` ends of line.
std::uint64_t afterLines(const File& file, std::uint64_t offset, std::int64_t lines) {
  std::vector<std::byte> chunk(lines > 0 ? 1 << 16 : 0);
  while (lines > 0) {
    const std::size_t got = file.readSomeAt(offset, chunk);
    if (got == 0) throw Error(ErrorCode::kFormat, file.path(), "", "the file ends within the lines to skip");
    std::size_t i = 0;
    while (i < got && lines > 0) lines -= chunk[i++] == std::byte{'\n'};
    offset += i;
  }
  return offset;
}

LinearData dataOf(const Header& header, const Extent3& dims, VoxelType type) {
  const HeaderFields& fields = header.fields;
  LinearData data;
  data.file = dataFileOf(header);
  data.encoding = encodingOf(fields);
  data.stored_type = type;
  data.big_endian = bigEndian(fields, type);
  const File file(data.file);
  const auto skip = [&](const char* key, std::int64_t least) {
    const HeaderField* field = fields.find(key);
    const std::int64_t count = field ? fields.integers(*field, 1)[0] : 0;
    if (count < least) fields.fail(*field, inQuotes(field->value) + " is not legal here");
    return count;
  };
  const std::int64_t byte_skip = skip("byte skip", data.encoding == DataEncoding::kRaw ? -1 : 0);
  const std::uint64_t first = fields.find("data file") ? 0 : header.end_offset;
  data.offset_bytes = afterLines(file, first, skip("line skip", 0));
  if (byte_skip >= 0) {
    // In a compressed stream the lines are skipped before decompression and the bytes after it.
    data.skip_decompressed_bytes = static_cast<std::uint64_t>(byte_skip);
    return data;
  }
  const std::uint64_t bytes = checkedBytes(dims, type, fields.path());
  if (file.size() < data.offset_bytes || bytes > file.size() - data.offset_bytes) {
    fields.fail(*fields.find("byte skip"), "the data file has " + std::to_string(file.size()) +
                                               " bytes, too few for the " + std::to_string(bytes) +
                                               " that the dimensions need");
  }
  data.offset_bytes = file.size() - bytes;
  return data;
}

}  // namespace

std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& input, const SourceOptions& options) {
  const Header header = readHeader(File(input));
  refuseWhatIsNotAScalarVolume(header.fields);
  SourceInfo info;
  info.format = "NRRD";
  info.type = typeOf(header.fields);
  info.geometry = geometryOf(header.fields, options);
  const LinearData data = dataOf(header, info.geometry.dims, info.type);
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
