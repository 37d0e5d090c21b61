// Legacy files of VTK with STRUCTURED_POINTS: a text header, then one array behind the other, as text or big-endian.
// Arrays in front of the chosen one are passed over. In a text file, where only counting finds their ends, arrays of
// the whole image are passed over, and the first array of points or cells is read. Source: VTK File Formats,
// docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <glm/mat3x3.hpp>

#include "base/error.h"
#include "base/text.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/vtk/vtk_types.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr VtkTypeName kLegacyTypes[] = {{"unsigned_char", VoxelType::u8},
                                        {"char", VoxelType::i8},
                                        {"signed_char", VoxelType::i8},
                                        {"unsigned_short", VoxelType::u16},
                                        {"short", VoxelType::i16},
                                        {"unsigned_int", VoxelType::u32},
                                        {"int", VoxelType::i32},
                                        {"vtkidtype", VoxelType::i32},
                                        {"float", VoxelType::f32},
                                        {"double", VoxelType::f64},
                                        {"vtktypeint64", StoredType::wide(true)},
                                        {"vtktypeuint64", StoredType::wide(false)}};
// Most values to pass over one by one.
constexpr std::uint64_t kMostValues = 1 << 24;
// Types that are passed over only: programs disagree on the sizes of long numbers. unit: bytes.
constexpr std::pair<std::string_view, std::size_t> kPassedTypes[] = {{"long", 8}, {"unsigned_long", 8}};

// VTK writes blanks, quotation marks, percent signs and bytes beyond ASCII as %20.
std::string decodedName(std::string_view written) {
  std::string out;
  for (std::size_t at = 0; at < written.size(); ++at) {
    const std::string_view digits = written.substr(at + 1, 2);
    unsigned char letter = 0;
    const bool is_code = written[at] == '%' && digits.size() == 2 &&
                         std::from_chars(digits.data(), digits.data() + 2, letter, 16).ptr == digits.data() + 2;
    out += is_code ? static_cast<char>(letter) : written[at];
    at += is_code ? 2 : 0;
  }
  return out;
}

struct LegacyArray : VtkArray {
  LegacyArray(const std::string& written_name, const std::string& written, std::int64_t values) {
    name = decodedName(written_name);
    type_text = lowered(written);
    type = vtkTypeNamed(kLegacyTypes, type_text);
    components = values;
  }

  /// Size of a number; 0 for an unknown type. unit: bytes.
  std::uint64_t numberBytes() const;

  std::uint64_t begin = 0;
  bool of_colors = false;  // COLOR_SCALARS: as text, shares of 255
};

std::uint64_t LegacyArray::numberBytes() const {
  if (type) return sizeOf(*type);
  for (const auto& [passed, bytes] : kPassedTypes)
    if (type_text == passed) return bytes;
  return 0;
}

struct LegacyHeader {
  bool binary = false;
  std::array<std::int64_t, 6> extent{};
  glm::dvec3 origin{0}, spacing{1};
  std::vector<LegacyArray> arrays;
};

/// Reads a file line by line, and passes over the arrays between the lines of a binary file.
class LegacyReader {
 public:
  explicit LegacyReader(const File& file) : file_(file), lines_(std::in_place, file) {}
  LegacyHeader read();

 private:
  using Words = std::vector<std::string>;
  void readStart();
  bool takeGrid(const std::string& key, const Words& line);
  /// Each returns false behind the last array that can be found.
  bool takeAttribute(const std::string& key, const Words& line);
  bool takeScalars(const Words& line);
  bool takeFields(const Words& line);
  bool addArray(const LegacyArray& array, std::int64_t tuples);
  bool passOverText(const LegacyArray& array, std::int64_t tuples);
  std::optional<std::uint64_t> behindBytes(const LegacyArray& array, std::uint64_t tuples) const;
  std::optional<std::uint64_t> behindStrings(std::uint64_t at, std::uint64_t count) const;
  void takeCount(const Words& line, bool of_cells);
  void passOverMetadata();
  std::optional<Words> nextWords();
  std::int64_t whole(const Words& line, std::size_t at, std::int64_t least = 1) const;
  glm::dvec3 three(const Words& line) const;
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const {
    throw Error(code, file_.path(), fmt::format("byte {}", line_begin_), what);
  }

  const File& file_;
  std::optional<HeaderLines> lines_;
  std::uint64_t line_begin_ = 0;
  LegacyHeader header_;
  bool has_dimensions_ = false, of_cells_ = false;
  std::int64_t tuples_ = 0;  // 0 before POINT_DATA and CELL_DATA
};

std::optional<LegacyReader::Words> LegacyReader::nextWords() {
  while (true) {
    line_begin_ = lines_->endOffset();
    const std::optional<std::string> line = lines_->next();
    if (!line) return std::nullopt;
    if (Words found = words(*line); !found.empty()) return found;
  }
}

std::int64_t LegacyReader::whole(const Words& line, std::size_t at, std::int64_t least) const {
  const auto value = at < line.size() ? integerOf(line[at]) : std::nullopt;
  if (!value || *value < least || *value > INT64_MAX / 8)
    fail(fmt::format("{} needs a whole number from {} on (found {})", inQuotes(line[0]), least,
                     at < line.size() ? inQuotes(line[at]) : "none"));
  return *value;
}

glm::dvec3 LegacyReader::three(const Words& line) const {
  glm::dvec3 out(0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis) + 1;
    const auto value = at < line.size() ? doubleOf(line[at]) : std::nullopt;
    if (!value) fail(fmt::format("{} needs three numbers", inQuotes(line[0])));
    out[axis] = *value;
  }
  return out;
}

void LegacyReader::readStart() {
  if (!lines_->next().value_or("").starts_with("# vtk DataFile")) fail("does not begin with '# vtk DataFile'");
  lines_->next();  // a title
  const Words kind = nextWords().value_or(Words{""});
  if (lowered(kind[0]) != "ascii" && lowered(kind[0]) != "binary")
    fail(inQuotes(kind[0]) + " is neither ASCII nor BINARY");
  header_.binary = lowered(kind[0]) == "binary";
  const Words set = nextWords().value_or(Words{""});
  if (lowered(set[0]) != "dataset" || set.size() < 2) fail("'DATASET' is expected (found " + inQuotes(set[0]) + ")");
  if (lowered(set[1]) != "structured_points")
    fail("holds " + inQuotes(set[1]) + ", not STRUCTURED_POINTS; resample it to an image", ErrorCode::kUnsupported);
}

bool LegacyReader::takeGrid(const std::string& key, const Words& line) {
  if (key == "dimensions") {
    for (std::size_t axis = 0; axis < 3; ++axis) header_.extent[2 * axis + 1] = whole(line, axis + 1) - 1;
    has_dimensions_ = true;
  } else if (key == "spacing" || key == "aspect_ratio") {
    header_.spacing = three(line);
  } else if (key == "origin") {
    header_.origin = three(line);
  } else {
    return false;
  }
  return true;
}

void LegacyReader::takeCount(const Words& line, bool of_cells) {
  if (!has_dimensions_) fail("'DIMENSIONS' is missing before " + inQuotes(line[0]));
  of_cells_ = of_cells;
  tuples_ = whole(line, 1);
  std::int64_t expected = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t steps = header_.extent[2 * axis + 1],
                       n = of_cells ? std::max<std::int64_t>(steps, 1) : steps + 1;
    expected = expected > INT64_MAX / n ? INT64_MAX : expected * n;
  }
  if (tuples_ != expected)
    fail(fmt::format("{} says {} values, but the dimensions have {}", inQuotes(line[0]), tuples_, expected));
}

// Adds an array whose data begin behind the last line, and passes over the data.
bool LegacyReader::addArray(const LegacyArray& array, std::int64_t tuples) {
  LegacyArray added = array;
  added.of_cells = of_cells_;
  added.begin = lines_->endOffset();
  if (tuples_ > 0 && tuples == tuples_) header_.arrays.push_back(added);
  if (!header_.binary) return tuples_ == 0 && passOverText(array, tuples);
  // A cut array is the last one; opening it names the length.
  const std::optional<std::uint64_t> end = behindBytes(added, static_cast<std::uint64_t>(tuples));
  if (!end) return false;
  lines_.emplace(file_, *end);
  return true;
}

// Returns the end of an array in a binary file; nothing for an unknown type, and for an array beyond the file's end.
std::optional<std::uint64_t> LegacyReader::behindBytes(const LegacyArray& array, std::uint64_t tuples) const {
  const std::uint64_t room = file_.size() - array.begin, size = array.numberBytes();
  const auto values = static_cast<std::uint64_t>(array.components);
  // A string has one byte or more; eight bits share a byte.
  const bool strings = array.type_text == "string", bits = array.type_text == "bit";
  if (!strings && !bits && size == 0) return std::nullopt;
  if (tuples > (bits ? 8 * room : strings ? room : room / size) / values) return std::nullopt;
  const std::uint64_t count = tuples * values;
  if (strings && count > kMostValues)
    fail(fmt::format("{} holds more than {} strings", inQuotes(array.name), kMostValues));
  if (strings) return behindStrings(array.begin, count);
  return array.begin + (bits ? (count + 7) / 8 : count * size);
}

// The upper two bits of a string's first byte state the bytes of its length, big-endian: 3 one, 2 two, 1 four, 0 eight.
std::optional<std::uint64_t> LegacyReader::behindStrings(std::uint64_t at, std::uint64_t count) const {
  constexpr std::size_t kLengthBytes[] = {8, 4, 2, 1};
  for (; count > 0; --count) {
    std::array<std::byte, 8> head{};
    const std::size_t got = file_.readSomeAt(at, head), bytes = kLengthBytes[std::to_integer<unsigned>(head[0]) >> 6];
    if (got < bytes) return std::nullopt;
    std::uint64_t length = std::to_integer<std::uint64_t>(head[0] & std::byte{0x3f});
    for (std::size_t i = 1; i < bytes; ++i) length = length << 8 | std::to_integer<std::uint64_t>(head[i]);
    at += bytes;
    if (length > file_.size() - at) return std::nullopt;
    at += length;
  }
  return at;
}

// Passes over the numbers of an array in a text file; a text has a line of its own. Returns false if the file ends.
bool LegacyReader::passOverText(const LegacyArray& array, std::int64_t tuples) {
  if (static_cast<std::uint64_t>(tuples) > kMostValues / static_cast<std::uint64_t>(array.components))
    fail(fmt::format("{} holds more than {} values of the whole image", inQuotes(array.name), kMostValues));
  const bool texts = array.type_text == "string";
  std::int64_t left = tuples * array.components;
  while (texts && left > 0 && lines_->next()) --left;
  while (!texts && left > 0) {
    const std::optional<Words> line = nextWords();
    if (!line) break;
    left -= static_cast<std::int64_t>(line->size());
  }
  return left <= 0;
}

bool LegacyReader::takeScalars(const Words& line) {
  if (line.size() < 3) fail("'SCALARS' needs a name and a type");
  LegacyArray array(line[1], line[2], line.size() > 3 ? whole(line, 3) : 1);
  array.is_active = true;
  const Words table = nextWords().value_or(Words{""});
  if (lowered(table[0]) != "lookup_table") fail("'LOOKUP_TABLE' is expected behind 'SCALARS'");
  return addArray(array, tuples_);
}

bool LegacyReader::takeFields(const Words& line) {
  constexpr std::int64_t kMostFields = 4096;
  const std::int64_t count = whole(line, 2, 0);
  if (count > kMostFields) fail(fmt::format("holds more than {} arrays", kMostFields));
  for (std::int64_t i = 0; i < count; ++i) {
    std::optional<Words> field = nextWords();
    if (field && lowered((*field)[0]) == "metadata") {
      passOverMetadata();
      field = nextWords();
    }
    if (!field || field->size() < 4) fail("an array of a FIELD needs a name, components, a length and a type");
    const LegacyArray array((*field)[0], (*field)[3], whole(*field, 1));
    if (!addArray(array, whole(*field, 2, 0))) return false;
  }
  return true;
}

// Metadata end with an empty line.
void LegacyReader::passOverMetadata() {
  for (auto line = lines_->next(); line && !trimmed(*line).empty(); line = lines_->next()) continue;
}

bool LegacyReader::takeAttribute(const std::string& key, const Words& line) {
  const auto array = [&](std::size_t type_at, std::int64_t components) {
    if (line.size() <= type_at) fail(inQuotes(line[0]) + " needs a name and a type");
    return addArray({line[1], line[type_at], components}, tuples_);
  };
  if (key == "point_data" || key == "cell_data") return takeCount(line, key == "cell_data"), true;
  if (key == "metadata") return passOverMetadata(), true;
  if (key == "field") return takeFields(line);
  if (tuples_ == 0) fail(inQuotes(line[0]) + " is not expected before POINT_DATA or CELL_DATA");
  if (key == "scalars") return takeScalars(line);
  if (key == "vectors" || key == "normals") return array(2, 3);
  if (key == "tensors") return array(2, 9);
  if (key == "texture_coordinates") return array(3, whole(line, 2));
  if (key == "color_scalars") {
    LegacyArray colors(line.size() > 1 ? line[1] : "", "unsigned_char", whole(line, 2));
    colors.of_colors = true;
    return addArray(colors, tuples_);
  }
  if (key == "lookup_table") return addArray({"", "unsigned_char", 4}, whole(line, 2));
  fail(inQuotes(line[0]) + " is not a keyword of VTK");
}

LegacyHeader LegacyReader::read() {
  readStart();
  while (const std::optional<Words> line = nextWords()) {
    const std::string key = lowered((*line)[0]);
    if (tuples_ == 0 && takeGrid(key, *line)) continue;
    if (!takeAttribute(key, *line)) break;
  }
  // Numbers of points, which filters add to an image, are no image beside other arrays.
  const auto is_of_ids = [](const LegacyArray& array) { return array.type_text == "vtkidtype" && !array.is_active; };
  const auto is_image = [&](const LegacyArray& array) { return array.isReadable() && !is_of_ids(array); };
  if (std::ranges::any_of(header_.arrays, is_image)) {
    for (LegacyArray& array : header_.arrays) {
      if (is_of_ids(array)) array.type.reset();
    }
  }
  return std::move(header_);
}

}  // namespace

std::unique_ptr<VolumeSource> openLegacyVtk(const fs::path& input, const SourceOptions& options) {
  const File file(input);
  const LegacyHeader header = LegacyReader(file).read();
  const VtkChoice choice = chosenVtkArray({header.arrays.begin(), header.arrays.end()}, options, input);
  const LegacyArray& array = header.arrays[choice.index];
  SourceInfo info;
  info.format = "VTK structured points" + choice.part;
  info.type = array.type->voxel();
  if (!choice.note.empty()) info.notes.push_back(choice.note);
  info.geometry =
      vtkGeometry(input, header.extent, array.of_cells, header.origin, header.spacing, glm::dmat3(1.0), options);
  LinearData data;
  data.file = input;
  data.encoding = header.binary ? DataEncoding::kRaw : array.of_colors ? DataEncoding::kShare : DataEncoding::kDecimal;
  data.offset_bytes = array.begin;
  data.stored_type = *array.type;
  data.big_endian = true;
  data.has_trailer = true;
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
