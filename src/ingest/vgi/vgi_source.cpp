// VGI, the header of VGStudio: lines "name = value" in sections and groups, beside a file of raw voxels, x fastest and
// little-endian. {volumeN} has a [file1] with the voxels, {volumeprimitiveN} a [geometry] with the size of a voxel. The
// text has no published definition: the names are those that scanners write and other readers take.
#include <fmt/format.h>

#include <map>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "grid/length_unit.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

/// The fields of a header, by section: "file1/size". The first file and the first geometry are kept.
class VgiParser {
 public:
  explicit VgiParser(const File& file) : path_(file.path()), lines_(file) {}

  HeaderFields parse() {
    HeaderFields out(path_);
    std::string section;
    while (const std::optional<std::string> line = lines_.next()) {
      const std::string text = trimmed(*line);
      if (text.empty() || text.starts_with("#")) continue;
      if (text.front() == '{') {
        takeGroup(text);
        section.clear();
      } else if (text.front() == '[') {
        section = lowered(text.substr(1, text.find(']') - 1));
        if (section == "geometry" && ++geometries_ > 1) section = "another geometry";
      } else if (section == "file1" || section == "geometry") {
        take(section, text, out);
      } else if (section.starts_with("file")) {
        fail("the voxels are in several files; save them as one", ErrorCode::kUnsupported);
      }
    }
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const {
    throw Error(code, path_, fmt::format("line {}", lines_.number()), what);
  }

  // "{volume1}", "{volumeprimitive12}".
  void takeGroup(const std::string& text) {
    const bool volume = text.starts_with("{volume") && text.size() > 7 && text[7] >= '0' && text[7] <= '9';
    if (volume && ++volumes_ > 1) fail("holds several volumes; save one of them", ErrorCode::kUnsupported);
  }

  void take(const std::string& section, const std::string& text, HeaderFields& out) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) fail(inQuotes(text) + " is not as NAME = VALUE");
    const std::string written = trimmed(text.substr(0, equals));
    out.add({section + "/" + lowered(written), written, trimmed(text.substr(equals + 1)), lines_.number()}, true);
  }

  std::filesystem::path path_;
  HeaderLines lines_;
  int volumes_ = 0, geometries_ = 0;
};

VoxelType vgiType(const HeaderFields& fields) {
  const HeaderField &kind = fields.require("file1/datatype"), &size = fields.require("file1/bitsperelement");
  struct Row {
    std::string_view kind;
    std::int64_t bits;
    VoxelType type;
  };
  constexpr Row kTypes[] = {
      {"unsigned integer", 8, VoxelType::u8},
      {"unsigned integer", 16, VoxelType::u16},
      {"unsigned integer", 32, VoxelType::u32},
      {"signed integer", 8, VoxelType::i8},
      {"signed integer", 16, VoxelType::i16},
      {"signed integer", 32, VoxelType::i32},
      {"float", 32, VoxelType::f32},
      {"float", 64, VoxelType::f64},
  };
  const std::int64_t bits = fields.integers(size, 1)[0];
  for (const Row& row : kTypes)
    if (lowered(kind.value) == row.kind && bits == row.bits) return row.type;
  fields.unsupported(kind, fmt::format("{} of {} bits is not read", inQuotes(kind.value), bits));
}

// Refuses voxels that are not in a raw file as they are.
void requireRaw(const HeaderFields& fields) {
  const HeaderField* const format = fields.find("file1/fileformat");
  if (format && lowered(format->value) != "raw")
    fields.unsupported(*format, inQuotes(format->value) + " is not read; save the volume as raw");
}

std::uint64_t skippedBytes(const HeaderFields& fields) {
  const HeaderField* const skipped = fields.find("file1/skipheader");
  if (!skipped) return 0;
  const std::int64_t bytes = fields.integers(*skipped, 1)[0];
  if (bytes < 0) fields.fail(*skipped, "is negative");
  return static_cast<std::uint64_t>(bytes);
}

// The file lies beside the header, whatever folder of another machine is written in front of its name.
std::filesystem::path voxelsOf(const HeaderFields& fields) {
  HeaderField name = fields.require("file1/name");
  name.value = name.value.substr(name.value.find_last_of("/\\") + 1);
  return fields.dataFiles(name, {}).front();
}

}  // namespace

std::unique_ptr<VolumeSource> openVgi(const std::filesystem::path& input, const SourceOptions& options) {
  const HeaderFields fields = VgiParser(File(input)).parse();
  requireRaw(fields);
  SourceInfo info;
  info.format = "VGI";
  info.type = vgiType(fields);
  info.geometry.dims = fields.extent(fields.require("file1/size"));
  checkedBytes(info.geometry.dims, info.type, input);
  const HeaderField* const edges = fields.find("geometry/resolution");
  if (edges && options.spacing) refuseSpacing(input);
  const glm::dvec3 spacing = edges ? fields.vector(*edges) : options.spacing.value_or(glm::dvec3(1));
  info.geometry.world_from_index = axesAffine(spacing, glm::dvec3(0));
  if (const HeaderField* const unit = fields.find("geometry/unit"); edges && unit)
    info.geometry.unit = unitName(unit->value);
  requireInvertible(info.geometry.world_from_index, input.string());
  LinearData data;
  data.file = voxelsOf(fields);
  data.offset_bytes = skippedBytes(fields);
  data.stored_type = info.type;
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
