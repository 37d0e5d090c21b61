// NRRD 1 to 5, attached (.nrrd) or with data files of its own (.nhdr): finds the scalar type and the bytes of the
// voxels.
// Source: teem.sourceforge.net/nrrd/format.html.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/text.h"
#include "ingest/bytes/stacked_source.h"
#include "ingest/nrrd/nrrd_geometry.h"
#include "ingest/nrrd/nrrd_header.h"
#include "ingest/source/formats.h"

namespace kiln {
namespace {

StoredType typeOf(const HeaderFields& fields) {
  static const std::map<std::string, StoredType> kTypes = [] {
    std::map<std::string, StoredType> types = {{"float", VoxelType::f32}, {"double", VoxelType::f64}};
    const auto name = [&](StoredType type, std::initializer_list<const char*> spellings) {
      for (const char* spelling : spellings) types.emplace(spelling, type);
    };
    name(VoxelType::i8, {"signed char", "int8", "int8_t"});
    name(VoxelType::u8, {"uchar", "unsigned char", "uint8", "uint8_t"});
    name(VoxelType::i16, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"});
    name(VoxelType::u16, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"});
    name(VoxelType::i32, {"int", "signed int", "int32", "int32_t"});
    name(VoxelType::u32, {"uint", "unsigned int", "uint32", "uint32_t"});
    name(StoredType::wide(true),
         {"longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"});
    name(StoredType::wide(false), {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"});
    return types;
  }();
  const HeaderField& field = fields.require("type");
  const std::string type = lowered(field.value);
  const auto found = kTypes.find(type);
  if (found != kTypes.end()) return found->second;
  if (type == "block") fields.unsupported(field, "opaque blocks ('block') have no scalar value; give a scalar volume");
  fields.fail(field, inQuotes(field.value) + " is not a NRRD type");
}

// True if a NRRD axis of this kind and direction is not spatial. Both are empty if the header lacks the field.
bool isOutsideSpace(const std::string& kind, const std::string& direction) {
  return direction == "none" ||
         !(kind.empty() || kind == "domain" || kind == "space" || kind == "???" || kind == "none");
}

// Removes axes of length 1 from a header of more than three dimensions: a single component or a single time. Axes
// outside space are removed first, then the last axes. Axes of other lengths stay, so more than three may be left.
void dropUnitNrrdAxes(HeaderFields& fields) {
  constexpr std::int64_t kMostAxes = 16;  // NRRD_DIM_MAX of teem, the format's own library
  const std::int64_t axes = fields.integers(fields.require("dimension"), 1)[0];
  if (axes <= 3 || axes > kMostAxes) return;
  const auto count = static_cast<std::size_t>(axes);
  const std::vector<std::int64_t> sizes = fields.integers(fields.require("sizes"), count);
  const auto valuesOf = [&](const char* key) {
    const HeaderField* field = fields.find(key);
    std::vector<std::string> out = field ? axisValues(lowered(field->value)) : std::vector<std::string>();
    out.resize(count);
    return out;
  };
  const std::vector<std::string> kinds = valuesOf("kinds"), directions = valuesOf("space directions");
  std::vector<bool> dropped(count, false);
  std::size_t left = count;
  for (const bool in_space : {false, true}) {
    for (std::size_t i = count; i-- > 0 && left > 3;) {
      if (dropped[i] || sizes[i] != 1 || isOutsideSpace(kinds[i], directions[i]) == in_space) continue;
      dropped[i] = true;
      --left;
    }
  }
  if (left > 3) return;
  for (const char* key : {"sizes", "spacings", "thicknesses", "axis mins", "axis maxs", "centers", "kinds", "labels",
                          "units", "space directions"})
    fields.dropAxes(key, dropped);
  fields.replace("dimension", "3");
}

// Warns about a volume 2 to 4 voxels wide: colours without the field kinds look like one.
std::string noteOfNarrow(const HeaderFields& fields, const Extent3& dims) {
  if (!mayBeChannels(dims) || fields.find("kinds") || fields.find("space directions")) return "";
  return fmt::format(
      "the first axis is taken as {} voxels of space; if it holds colours or vectors, its header lacks the "
      "field kinds, and the volume is wrong",
      dims.x);
}

void requireScalarNrrd(const HeaderFields& fields) {
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

DataEncoding encodingOf(const HeaderFields& fields) {
  const HeaderField& field = fields.require("encoding");
  const std::string name = lowered(field.value);
  if (name == "raw") return DataEncoding::kRaw;
  if (name == "gzip" || name == "gz") return DataEncoding::kGzip;
  if (name == "bzip2" || name == "bz2") return DataEncoding::kBzip2;
  if (name == "txt" || name == "text" || name == "ascii") return DataEncoding::kDecimal;
  if (name == "hex") return DataEncoding::kHex;
  fields.fail(field, inQuotes(field.value) + " is not an encoding of NRRD");
}

bool bigEndian(const HeaderFields& fields, StoredType type, DataEncoding encoding) {
  const bool ordered = sizeOf(type) > 1 && encoding != DataEncoding::kDecimal;
  if (!ordered && !fields.find("endian")) return false;
  const HeaderField& field = fields.require("endian");
  const std::string name = lowered(field.value);
  if (name != "big" && name != "little") fields.fail(field, inQuotes(field.value) + " is neither big nor little");
  return name == "big";
}

std::vector<std::filesystem::path> dataFilesOf(const NrrdHeader& header) {
  const HeaderField* field = header.fields.find("data file");
  if (!field) {
    if (header.closed) return {header.fields.path()};
    throw Error(ErrorCode::kFormat, header.fields.path(), "end of the file",
                "the header ends without the empty line before the data, and names no data file");
  }
  return header.fields.dataFiles(*field, header.listed);
}

// Returns the position behind `lines` line ends. unit: bytes.
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

// Describes one data file, which holds `dims` voxels.
LinearData dataOf(const NrrdHeader& header, const std::filesystem::path& path, const Extent3& dims, StoredType type) {
  const HeaderFields& fields = header.fields;
  LinearData data;
  data.file = path;
  data.encoding = encodingOf(fields);
  data.stored_type = type;
  data.big_endian = bigEndian(fields, type, data.encoding);
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
    // In a compressed file, lines are skipped before decompression and bytes after it.
    const bool text = data.encoding == DataEncoding::kDecimal || data.encoding == DataEncoding::kHex;
    (text ? data.offset_bytes : data.skip_decompressed_bytes) += static_cast<std::uint64_t>(byte_skip);
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

// Names the axes that run backwards by the header's spacings or ranges; empty where none does, or where a
// space or directions are given.
std::string noteOfMirrored(const HeaderFields& fields, const VolumeGeometry& geometry) {
  if (fields.find("space directions") || fields.find("space")) return "";
  std::string axes;
  for (int axis = 0; axis < 3; ++axis)
    if (geometry.world_from_index[axis][axis] < 0) axes += std::string(axes.empty() ? "" : ", ") + "xyz"[axis];
  return axes.empty()
             ? ""
             : "its spacing is negative along " + axes + ": the volume is mirrored there; --spacing sets another";
}

// Names the axes whose spacing the header gives as NaN, "unknown", and which therefore have the spacing 1.
std::string noteOfUnknown(const HeaderFields& fields, const VolumeGeometry& geometry, const SourceOptions& options) {
  const HeaderField* const spacings = fields.find("spacings");
  if (options.spacing || fields.find("space directions") || !spacings) return "";
  const glm::dvec3 given = fields.vector(*spacings);
  std::string axes;
  for (int axis = 0; axis < 3; ++axis)
    if (std::isnan(given[axis]) && geometry.world_from_index[axis][axis] == 1)
      axes += std::string(axes.empty() ? "" : ", ") + "xyz"[axis];
  return axes.empty() ? "" : "its spacing is unknown (nan) along " + axes + ", and taken as 1; --spacing sets another";
}

}  // namespace

std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& input, const SourceOptions& options) {
  NrrdHeader header = readNrrdHeader(File(input));
  dropUnitNrrdAxes(header.fields);
  requireScalarNrrd(header.fields);
  SourceInfo info;
  info.format = "NRRD";
  const StoredType type = typeOf(header.fields);
  info.type = type.voxel();
  info.geometry = nrrdGeometry(header.fields, options, info.notes);
  if (std::string note = noteOfNarrow(header.fields, info.geometry.dims); !note.empty())
    info.notes.push_back(std::move(note));
  if (std::string note = noteOfMirrored(header.fields, info.geometry); !note.empty())
    info.notes.push_back(std::move(note));
  if (std::string note = noteOfUnknown(header.fields, info.geometry, options); !note.empty())
    info.notes.push_back(std::move(note));
  const std::vector<std::filesystem::path> files = dataFilesOf(header);
  const Extent3 part = partOfFile(info.geometry.dims, files.size(), input);
  std::vector<LinearData> data;
  for (const std::filesystem::path& file : files) data.push_back(dataOf(header, file, part, type));
  return openStacked(input, std::move(info), std::move(data));
}

}  // namespace kiln
