// MetaImage (.mhd with data files, .mha with the data inside), read as ITK reads it: row i of TransformMatrix is the
// direction of axis i, and ElementDataFile is the last field.
// Source: MetaIO's documentation (itk.org/Wiki/MetaIO) and itkMetaImageIO.
// Differs: ITK assumes the LPS frame always; here the frame is LPS only if AnatomicalOrientation gives an orientation,
// else unknown.
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/text.h"
#include "ingest/bytes/stacked_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

// Maps alternative spellings to one field name.
std::string keyOf(const std::string& name) {
  static const std::map<std::string, std::string> kSame = {{"Origin", "Offset"},
                                                           {"Position", "Offset"},
                                                           {"Rotation", "TransformMatrix"},
                                                           {"Orientation", "TransformMatrix"},
                                                           {"ElementByteOrderMSB", "BinaryDataByteOrderMSB"}};
  const auto found = kSame.find(name);
  return found == kSame.end() ? name : found->second;
}

struct Header {
  HeaderFields fields;
  std::uint64_t end_offset = 0;
  /// The names behind "ElementDataFile = LIST".
  std::vector<std::string> listed;
};

Header readHeader(const File& file) {
  Header header{HeaderFields(file.path()), 0, {}};
  HeaderLines lines(file);
  while (std::optional<std::string> line = lines.next()) {
    if (trimmed(*line).empty()) continue;
    std::size_t split = line->find('=');
    if (split == std::string::npos) split = line->find(':');
    if (split == std::string::npos) {
      throw Error(ErrorCode::kFormat, file.path(), "line " + std::to_string(lines.number()),
                  inQuotes(*line) + " is not 'name = value'; not a MetaImage header");
    }
    const std::string name = trimmed(line->substr(0, split));
    header.fields.add({keyOf(name), name, trimmed(line->substr(split + 1)), lines.number()}, true);
    if (name == "ElementDataFile") {
      header.end_offset = lines.endOffset();
      if (!namesList(header.fields.find(name)->value)) return header;
      header.listed = lines.rest();
      return header;
    }
  }
  throw Error(ErrorCode::kFormat, file.path(), "end of the file", "the header ends without 'ElementDataFile'");
}

bool flag(const HeaderFields& fields, std::string_view key, bool otherwise) {
  const HeaderField* field = fields.find(key);
  if (!field) return otherwise;
  const std::string value = lowered(field->value);
  if (value == "true" || value == "t" || value == "1") return true;
  if (value == "false" || value == "f" || value == "0") return false;
  fields.fail(*field, inQuotes(field->value) + " is neither True nor False");
}

StoredType elementType(const HeaderFields& fields) {
  static const std::map<std::string, StoredType> kTypes = {{"MET_UCHAR", VoxelType::u8},
                                                           {"MET_CHAR", VoxelType::i8},
                                                           {"MET_USHORT", VoxelType::u16},
                                                           {"MET_SHORT", VoxelType::i16},
                                                           {"MET_UINT", VoxelType::u32},
                                                           {"MET_INT", VoxelType::i32},
                                                           {"MET_FLOAT", VoxelType::f32},
                                                           {"MET_DOUBLE", VoxelType::f64},
                                                           {"MET_LONG_LONG", StoredType::wide(true)},
                                                           {"MET_ULONG_LONG", StoredType::wide(false)}};
  const HeaderField& field = fields.require("ElementType");
  const auto found = kTypes.find(field.value);
  if (found != kTypes.end()) return found->second;
  const bool known = field.value.starts_with("MET_");
  const bool array = field.value.ends_with("_ARRAY") || field.value.ends_with("_MATRIX");
  fields.fail(field,
              !known  ? inQuotes(field.value) + " is not a MetaImage type"
              : array ? inQuotes(field.value) + " is vector, tensor or colour data; give a scalar volume"
                      : inQuotes(field.value) + " is not read; convert it to one of 8, 16 or 32 bits, float or double",
              known ? ErrorCode::kUnsupported : ErrorCode::kFormat);
}

// Removes axes of length 1 from a header of more than three dimensions, the last axes first. File axis and world
// dimension are removed together, so the matrix must not mix them with others.
void dropUnitMetaImageAxes(HeaderFields& fields) {
  constexpr std::int64_t kMostAxes = 10;  // MetaIO's own limit
  const std::int64_t axes = fields.integers(fields.require("NDims"), 1)[0];
  if (axes <= 3 || axes > kMostAxes) return;
  const auto count = static_cast<std::size_t>(axes);
  const std::vector<std::int64_t> sizes = fields.integers(fields.require("DimSize"), count);
  std::vector<bool> dropped(count, false);
  std::size_t left = count;
  for (std::size_t i = count; i-- > 0 && left > 3;) {
    dropped[i] = sizes[i] == 1;
    left -= dropped[i] ? 1 : 0;
  }
  if (left > 3) return;
  for (const char* key : {"DimSize", "ElementSpacing", "ElementSize", "Offset", "CenterOfRotation"})
    fields.dropAxes(key, dropped);
  if (const HeaderField* matrix = fields.find("TransformMatrix")) {
    const std::vector<double> m = fields.doubles(*matrix, count * count);
    std::vector<bool> dropped_entries(count * count);
    for (std::size_t i = 0; i < m.size(); ++i) {
      const std::size_t row = i / count, column = i % count;
      dropped_entries[i] = dropped[row] || dropped[column];
      if (dropped[row] != dropped[column] && m[i] != 0)
        fields.unsupported(*matrix, "mixes an axis of length 1 with the others; give a volume of three dimensions");
    }
    fields.dropAxes("TransformMatrix", dropped_entries);
  }
  fields.replace("NDims", "3");
}

void requireScalarMetaImage(const HeaderFields& fields) {
  const HeaderField* object = fields.find("ObjectType");
  if (object && lowered(object->value) != "image") {
    fields.unsupported(*object, inQuotes(object->value) + " is not an image; give a file with ObjectType Image");
  }
  if (const HeaderField* channels = fields.find("ElementNumberOfChannels")) {
    if (fields.integers(*channels, 1)[0] != 1) {
      fields.unsupported(*channels, channels->value + " channels: vector, tensor or colour data; give a scalar volume");
    }
  }
  const HeaderField& ndims = fields.require("NDims");
  if (fields.integers(ndims, 1)[0] != 3) {
    fields.unsupported(ndims, ndims.value + "-D data; give a volume of three dimensions");
  }
  if (const HeaderField* gaps = fields.find("HeaderSizePerSlice")) {
    if (fields.integers(*gaps, 1)[0] != 0) fields.unsupported(*gaps, "slices with headers of their own are not read");
  }
  // The format defines this map, but ITK does not apply it: either choice would give some users wrong values.
  for (const auto& [key, neutral] :
       {std::pair{"ElementToIntensityFunctionSlope", 1.0}, std::pair{"ElementToIntensityFunctionOffset", 0.0}}) {
    const HeaderField* map = fields.find(key);
    if (map && fields.doubles(*map, 1)[0] != neutral) {
      fields.unsupported(*map, "values with a linear map are not read; remove the line to get the stored values");
    }
  }
}

VolumeGeometry geometryOf(const HeaderFields& fields, const SourceOptions& options) {
  VolumeGeometry geometry;
  geometry.dims = fields.extent(fields.require("DimSize"));
  const HeaderField* spacing_field = fields.find("ElementSpacing");
  if (!spacing_field) spacing_field = fields.find("ElementSize");
  glm::dvec3 spacing = spacing_field ? fields.vector(*spacing_field) : glm::dvec3(1);
  const HeaderField* matrix = fields.find("TransformMatrix");
  if (options.spacing && matrix) {
    throw Error(ErrorCode::kUsage, fields.path(), "line " + std::to_string(matrix->line),
                "--spacing does not apply: the file gives its axes in " + inQuotes(matrix->written));
  }
  if (options.spacing) spacing = *options.spacing;
  // Negative spacings are refused, as by ITK; TransformMatrix can mirror an axis.
  const auto legal = [](double edge) { return edge >= 0 && std::isfinite(edge); };
  if (!legal(spacing.x) || !legal(spacing.y) || !legal(spacing.z))
    fields.fail(*spacing_field, "expected three numbers above 0 (found " + inQuotes(spacing_field->value) +
                                    "); mirror an axis by TransformMatrix");
  const HeaderField* offset = fields.find("Offset");
  const glm::dvec3 origin = offset ? fields.vector(*offset) : glm::dvec3(0);
  std::vector<double> m = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (matrix) m = fields.doubles(*matrix, 9);
  geometry.world_from_index =
      directionsAffine({spacing.x * glm::dvec3(m[0], m[1], m[2]), spacing.y * glm::dvec3(m[3], m[4], m[5]),
                        spacing.z * glm::dvec3(m[6], m[7], m[8])},
                       origin);
  requireInvertible(geometry.world_from_index, fields.path().string());
  const HeaderField* orientation = fields.find("AnatomicalOrientation");
  const bool known = orientation && !orientation->value.empty() && orientation->value.find('?') == std::string::npos;
  geometry.frame = known ? PatientFrame::kLps : PatientFrame::kUnknown;
  const HeaderField* units = fields.find("DistanceUnits");
  if (units && (units->value == "mm" || units->value == "um" || units->value == "cm")) geometry.unit = units->value;
  return geometry;
}

std::vector<std::filesystem::path> dataFilesOf(const Header& header) {
  const HeaderField& name = header.fields.require("ElementDataFile");
  if (lowered(name.value) == "local") return {header.fields.path()};
  return header.fields.dataFiles(name, header.listed);
}

// Returns the begin of the data in one data file, which holds `dims` voxels.
LinearData dataOf(const Header& header, const std::filesystem::path& file, const Extent3& dims, StoredType type) {
  const HeaderFields& fields = header.fields;
  const bool local = file == fields.path();
  LinearData data;
  data.file = file;
  data.stored_type = type;
  data.big_endian = flag(fields, "BinaryDataByteOrderMSB", false);
  data.offset_bytes = local ? header.end_offset : 0;
  const bool compressed = flag(fields, "CompressedData", false);
  if (const HeaderField* size = fields.find("HeaderSize")) {
    // MetaIO: a positive size counts from the start of the data file, even of LOCAL data; -1: the data are its end.
    const std::int64_t skip = fields.integers(*size, 1)[0];
    if (skip < -1 || (skip == -1 && compressed)) fields.fail(*size, inQuotes(size->value) + " is not legal here");
    if (skip > 0 && local && static_cast<std::uint64_t>(skip) < header.end_offset) {
      fields.fail(*size, inQuotes(size->value) + " is inside the header, which ends at byte " +
                             std::to_string(header.end_offset));
    }
    if (skip > 0) data.offset_bytes = static_cast<std::uint64_t>(skip);
    if (skip == -1) {
      const std::uint64_t bytes = checkedBytes(dims, type, fields.path()), found = File(data.file).size();
      if (bytes > found) {
        fields.fail(*size, "the data file has " + std::to_string(found) + " bytes, the dimensions need " +
                               std::to_string(bytes));
      }
      if (local && found - bytes < header.end_offset) fields.fail(*size, "the data would overlap the header");
      data.offset_bytes = found - bytes;
    }
  }
  if (!flag(fields, "BinaryData", true)) {
    if (compressed) fields.fail(*fields.find("BinaryData"), "contradicts CompressedData; text is not compressed");
    data.encoding = DataEncoding::kDecimal;
  } else if (compressed) {
    std::byte magic[2] = {};
    File(data.file).readSomeAt(data.offset_bytes, magic);
    const bool gzip = magic[0] == std::byte{0x1f} && magic[1] == std::byte{0x8b};
    data.encoding = gzip ? DataEncoding::kGzip : DataEncoding::kZlib;
  }
  return data;
}

}  // namespace

std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& input, const SourceOptions& options) {
  Header header = readHeader(File(input));
  dropUnitMetaImageAxes(header.fields);
  requireScalarMetaImage(header.fields);
  SourceInfo info;
  info.format = "MetaImage";
  const StoredType type = elementType(header.fields);
  info.type = type.voxel();
  info.geometry = geometryOf(header.fields, options);
  const std::vector<std::filesystem::path> files = dataFilesOf(header);
  const Extent3 part = partOfFile(info.geometry.dims, files.size(), input);
  std::vector<LinearData> data;
  for (const std::filesystem::path& file : files) data.push_back(dataOf(header, file, part, type));
  return openStacked(input, std::move(info), std::move(data));
}

}  // namespace kiln
