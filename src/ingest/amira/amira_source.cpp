// AmiraMesh, the volumes of Amira and Avizo: a text header, then the voxels of each field behind its mark "@1". Fields
// on a lattice of uniform coordinates are read: raw, as text, or in a zlib stream. The bounding box runs from the
// centre of the first voxel to the centre of the last. Source: Amira User's Guide, "AmiraMesh Format", and the
// description of the same by the Fiji project (AmiraMeshDecoder).
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "grid/length_unit.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr int kMostLines = 100'000;

struct AmiraField {
  std::string type, name, mark, codec;
  int line = 0;
};

struct AmiraHeader {
  DataEncoding encoding = DataEncoding::kRaw;
  bool big_endian = false;
  std::optional<Extent3> dims;
  std::optional<std::vector<double>> box;
  std::string coordinates = "uniform", unit;
  std::vector<AmiraField> fields;
  /// The mark of the first data.
  std::string data_mark;
  std::uint64_t data_offset_bytes = 0;
};

/// Parses the header line by line, up to the mark of the first data.
class AmiraParser {
 public:
  explicit AmiraParser(const File& file) : file_(file), lines_(file) {}

  AmiraHeader parse() {
    takeFirst(next("its first line"));
    for (;;) {
      const std::string line = next("its data");
      if (line.starts_with("@")) {
        out_.data_mark = line;
        break;
      }
      take(line);
    }
    out_.data_offset_bytes = lines_.endOffset();
    if (!out_.dims) fail("has no lattice (define Lattice X Y Z); surfaces and sets of points are no volumes");
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const {
    throw Error(code, file_.path(), fmt::format("line {}", lines_.number()), what);
  }

  std::string next(const char* what) {
    const std::optional<std::string> line = lines_.next();
    if (!line || lines_.number() > kMostLines) fail(fmt::format("the header ends before {}", what));
    return trimmed(*line);
  }

  // "# AmiraMesh BINARY-LITTLE-ENDIAN 2.1". BINARY alone is big-endian, the order of the first machines.
  void takeFirst(const std::string& line) {
    const std::vector<std::string> parts = words(line);
    const auto has = [&](std::string_view word) { return std::find(parts.begin(), parts.end(), word) != parts.end(); };
    if (has("ASCII"))
      out_.encoding = DataEncoding::kDecimal;
    else if (has("BINARY"))
      out_.big_endian = true;
    else if (!has("BINARY-LITTLE-ENDIAN"))
      fail("is neither ASCII nor BINARY nor BINARY-LITTLE-ENDIAN: " + inQuotes(line), ErrorCode::kUnsupported);
  }

  // Entries of nested groups are known by their names, which Amira gives no others.
  void take(std::string line) {
    if (line.starts_with("#")) return;
    if (line.ends_with(",")) line.pop_back();
    const std::vector<std::string> parts = words(line);
    if (parts.empty()) return;
    if (parts.size() > 1 && parts[0] == "define" && parts[1] == "Lattice") return takeLattice(parts);
    if (parts[0] == "Lattice" && line.find('@') != std::string::npos) return takeField(line);
    if (parts[0] == "BoundingBox") return takeBox(parts);
    if (parts[0] == "CoordType" && parts.size() == 2) out_.coordinates = unquoted(parts[1]);
    if (parts[0] == "Coordinates" && parts.size() == 2) out_.unit = unquoted(parts[1]);
  }

  static std::string unquoted(const std::string& text) {
    const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    return quoted ? text.substr(1, text.size() - 2) : text;
  }

  void takeLattice(const std::vector<std::string>& parts) {
    Extent3 dims;
    if (parts.size() != 5) fail(fmt::format("a lattice of {} axes; volumes have 3", parts.size() - 2));
    for (int axis = 0; axis < 3; ++axis) {
      const std::optional<std::int64_t> length = integerOf(parts[static_cast<std::size_t>(axis) + 2]);
      if (!length) fail(inQuotes(parts[static_cast<std::size_t>(axis) + 2]) + " is no number of voxels");
      (axis == 0 ? dims.x : axis == 1 ? dims.y : dims.z) = *length;
    }
    out_.dims = dims;
  }

  void takeBox(const std::vector<std::string>& parts) {
    std::vector<double> box;
    for (std::size_t i = 1; i < parts.size(); ++i)
      if (const std::optional<double> number = doubleOf(parts[i])) box.push_back(*number);
    if (box.size() != 6 || parts.size() != 7) fail("BoundingBox must hold 6 numbers");
    out_.box = std::move(box);
  }

  // "Lattice { byte Data } @1(HxZip,1234)", or with "= @1".
  void takeField(const std::string& line) {
    const std::size_t open = line.find('{'), close = line.find('}'), at = line.find('@');
    if (open == std::string::npos || close == std::string::npos || !(open < close && close < at))
      fail("the field " + inQuotes(line) + " is not as Lattice { TYPE NAME } @1");
    const std::vector<std::string> declared = words(line.substr(open + 1, close - open - 1));
    if (declared.size() != 2) fail("a field has a type and a name (found " + inQuotes(line) + ")");
    const std::size_t codec = line.find('(', at);
    AmiraField field{declared[0], declared[1], trimmed(line.substr(at, codec - at)), "", lines_.number()};
    if (codec != std::string::npos) field.codec = line.substr(codec + 1, line.find_first_of(",)", codec) - codec - 1);
    out_.fields.push_back(std::move(field));
  }

  const File& file_;
  HeaderLines lines_;
  AmiraHeader out_;
};

[[noreturn]] void refuseField(const std::filesystem::path& path, const AmiraField& field, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, path, fmt::format("line {}", field.line), what);
}

VoxelType amiraType(const std::filesystem::path& path, const AmiraField& field) {
  constexpr std::pair<std::string_view, VoxelType> kTypes[] = {
      {"byte", VoxelType::u8},    {"short", VoxelType::i16}, {"ushort", VoxelType::u16}, {"int32", VoxelType::i32},
      {"uint32", VoxelType::u32}, {"int", VoxelType::i32},   {"float", VoxelType::f32},  {"double", VoxelType::f64}};
  for (const auto& [name, type] : kTypes)
    if (field.type == name) return type;
  refuseField(path, field,
              fmt::format("the field {} holds {}, not one number a voxel; save one component as a scalar "
                          "field",
                          inQuotes(field.name), inQuotes(field.type)));
}

DataEncoding amiraEncoding(const std::filesystem::path& path, const AmiraHeader& header, const AmiraField& field) {
  if (field.codec.empty()) return header.encoding;
  if (field.codec == "HxZip" && header.encoding == DataEncoding::kRaw) return DataEncoding::kZlib;
  refuseField(path, field,
              fmt::format("the field is compressed by {}, which is not read; save it as BINARY without compression",
                          inQuotes(field.codec)));
}

// An axis of one voxel has no distance of its own.
void placeByBox(const std::vector<double>& box, VolumeGeometry& out) {
  glm::dvec3 spacing(0), origin(0);
  double smallest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = box[static_cast<std::size_t>(2 * axis)], hi = box[static_cast<std::size_t>(2 * axis + 1)];
    origin[axis] = lo;
    if (out.dims[axis] < 2) continue;
    spacing[axis] = (hi - lo) / static_cast<double>(out.dims[axis] - 1);
    if (smallest == 0 || spacing[axis] < smallest) smallest = spacing[axis];
  }
  for (int axis = 0; axis < 3; ++axis)
    if (out.dims[axis] < 2) spacing[axis] = smallest > 0 ? smallest : 1;
  out.world_from_index = axesAffine(spacing, origin);
}

}  // namespace

std::unique_ptr<VolumeSource> openAmira(const std::filesystem::path& input, const SourceOptions& options) {
  const File file(input);
  const AmiraHeader header = AmiraParser(file).parse();
  if (header.fields.empty()) throw Error(ErrorCode::kUnsupported, input, "", "has a lattice without a field of values");
  const AmiraField& field = header.fields.front();
  if (header.fields.size() > 1)
    refuseField(input, header.fields[1],
                fmt::format("holds {} fields on its lattice; save one of them", header.fields.size()));
  if (field.mark != header.data_mark)
    refuseField(input, field,
                fmt::format("the field's data, {}, lie behind other data (found {} first); save the field alone",
                            inQuotes(field.mark), inQuotes(header.data_mark)));
  if (header.coordinates != "uniform")
    throw Error(ErrorCode::kUnsupported, input, "CoordType",
                fmt::format("{} coordinates are not read; resample to uniform ones", inQuotes(header.coordinates)));
  SourceInfo info;
  info.format = "AmiraMesh";
  info.type = amiraType(input, field);
  info.geometry.dims = *header.dims;
  info.geometry.unit = unitName(header.unit);
  checkedBytes(info.geometry.dims, info.type, input);
  if (header.box && options.spacing) refuseSpacing(input);
  if (header.box)
    placeByBox(*header.box, info.geometry);
  else
    info.geometry.world_from_index = axesAffine(options.spacing.value_or(glm::dvec3(1)), glm::dvec3(0));
  requireInvertible(info.geometry.world_from_index, input.string());
  LinearData data;
  data.file = input;
  data.encoding = amiraEncoding(input, header, field);
  data.offset_bytes = header.data_offset_bytes;
  data.stored_type = info.type;
  data.big_endian = header.big_endian;
  data.has_trailer = true;  // a line end
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
