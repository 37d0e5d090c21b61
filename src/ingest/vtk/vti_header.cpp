// expat reads the file in steps and stops at the appended data, which are not XML. Nothing of an inline array is kept:
// the header holds its place only. Hostile XML is bounded: no document type, so no entities; few nested elements; short
// tags.
// Source: VTK File Formats, docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
#include "ingest/vtk/vti_header.h"

#include <expat.h>
#include <fmt/format.h>

#include <exception>
#include <memory>
#include <string_view>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::size_t kStepBytes = 1 << 16;
constexpr std::uint64_t kLongestTag = 1 << 20;
constexpr std::size_t kDeepest = 32;
constexpr std::size_t kMostArrays = 4096;

constexpr VtkTypeName kVtiTypes[] = {
    {"UInt8", VoxelType::u8},         {"Int8", VoxelType::i8},     {"UInt16", VoxelType::u16},
    {"Int16", VoxelType::i16},        {"UInt32", VoxelType::u32},  {"Int32", VoxelType::i32},
    {"Float32", VoxelType::f32},      {"Float64", VoxelType::f64}, {"UInt64", StoredType::wide(false)},
    {"Int64", StoredType::wide(true)}};

/// The attributes of one element.
class VtiAttributes {
 public:
  explicit VtiAttributes(const char** pairs) : pairs_(pairs) {}
  std::optional<std::string> find(std::string_view name) const {
    for (const char** pair = pairs_; *pair != nullptr; pair += 2)
      if (name == *pair) return std::string(pair[1]);
    return std::nullopt;
  }
  std::string get(std::string_view name, const char* otherwise = "") const { return find(name).value_or(otherwise); }

 private:
  const char** pairs_;
};

class VtiParser {
 public:
  explicit VtiParser(const File& file);
  VtiHeader parse();

 private:
  static void XMLCALL onStart(void* self, const XML_Char* name, const XML_Char** attributes);
  static void XMLCALL onEnd(void* self, const XML_Char*);
  static void XMLCALL onDoctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int);
  void start(std::string_view name, const VtiAttributes& attributes);
  void takeFile(const VtiAttributes& attributes);
  void takeImage(const VtiAttributes& attributes);
  void takePiece(const VtiAttributes& attributes);
  void takeArray(const VtiAttributes& attributes);
  void takeAppended(const VtiAttributes& attributes);
  template <std::size_t kCount, class Number>
  auto numbers(const VtiAttributes& attributes, const char* name, Number&& number) const;
  std::uint64_t position() const { return static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get())); }
  std::uint64_t afterTag() const {
    return position() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
  }
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const {
    throw Error(code, file_.path(), fmt::format("line {}", XML_GetCurrentLineNumber(parser_.get())), what);
  }

  const File& file_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_;
  std::exception_ptr thrown_;
  VtiHeader header_;
  int pieces_ = 0;
  bool has_image_ = false;
  /// Names of the elements that have begun and not ended.
  std::vector<std::string> open_;
  /// Of the last PointData or CellData; empty without.
  std::string active_scalars_;
};

VtiParser::VtiParser(const File& file) : file_(file), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
  if (!parser_) throw Error(ErrorCode::kIo, file.path(), "", "no memory for the XML");
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), &onStart, &onEnd);
  XML_SetStartDoctypeDeclHandler(parser_.get(), &onDoctype);
}

// No exception may pass through expat's frames, so an exception is kept and thrown behind them.
void VtiParser::onStart(void* self, const XML_Char* name, const XML_Char** attributes) {
  auto& parser = *static_cast<VtiParser*>(self);
  if (parser.thrown_ || parser.header_.appended) return;
  try {
    parser.start(name, VtiAttributes(attributes));
  } catch (...) {
    parser.thrown_ = std::current_exception();
    XML_StopParser(parser.parser_.get(), XML_FALSE);
  }
}

// An element that began behind the appended data or an error has no name in `open_`.
void VtiParser::onEnd(void* self, const XML_Char*) {
  auto& open = static_cast<VtiParser*>(self)->open_;
  if (!open.empty()) open.pop_back();
}

void VtiParser::onDoctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
  auto& parser = *static_cast<VtiParser*>(self);
  parser.thrown_ = std::make_exception_ptr(
      Error(ErrorCode::kFormat, parser.file_.path(), "", "has a document type, which files of VTK have not"));
  XML_StopParser(parser.parser_.get(), XML_FALSE);
}

VtiHeader VtiParser::parse() {
  for (std::uint64_t at = 0;;) {
    void* const buffer = XML_GetBuffer(parser_.get(), kStepBytes);
    if (buffer == nullptr) throw Error(ErrorCode::kIo, file_.path(), "", "no memory for the XML");
    const std::size_t got = file_.readSomeAt(at, {static_cast<std::byte*>(buffer), kStepBytes});
    at += got;
    const XML_Status status = XML_ParseBuffer(parser_.get(), static_cast<int>(got), got == 0);
    if (thrown_) std::rethrow_exception(thrown_);
    if (header_.appended) break;
    if (status != XML_STATUS_OK)
      fail(fmt::format("the XML is cut short or damaged ({})", XML_ErrorString(XML_GetErrorCode(parser_.get()))));
    if (got == 0) break;
    if (at > position() + kLongestTag) fail("a tag of the XML has no end");
  }
  if (!has_image_ || pieces_ == 0) throw Error(ErrorCode::kFormat, file_.path(), "", "has no piece of an image");
  return std::move(header_);
}

void VtiParser::start(std::string_view name, const VtiAttributes& attributes) {
  if (open_.size() == kDeepest) fail("elements are nested too deeply");
  open_.emplace_back(name);
  if (open_.size() == 1) {
    if (name != "VTKFile")
      fail(inQuotes(name) + " is not a file of VTK; its first element is VTKFile", ErrorCode::kUnsupported);
    return takeFile(attributes);
  }
  if (name == "ImageData") return takeImage(attributes);
  if (name == "Piece") return takePiece(attributes);
  if (name == "AppendedData") return takeAppended(attributes);
  if (name == "DataArray") return takeArray(attributes);
  if (name == "PointData" || name == "CellData") active_scalars_ = attributes.get("Scalars");
}

void VtiParser::takeFile(const VtiAttributes& attributes) {
  const std::string type = attributes.get("type"), order = attributes.get("byte_order", "LittleEndian"),
                    lengths = attributes.get("header_type", "UInt32"), codec = attributes.get("compressor");
  if (type == "PImageData")
    fail("lists the pieces of an image in other files; save it as one .vti", ErrorCode::kUnsupported);
  if (type != "ImageData")
    fail(fmt::format("holds {}, not an image on a regular grid; resample it to an image", inQuotes(type)),
         ErrorCode::kUnsupported);
  if (order != "LittleEndian" && order != "BigEndian") fail(inQuotes(order) + " is no byte order");
  if (lengths != "UInt32" && lengths != "UInt64") fail(inQuotes(lengths) + " is no type of lengths");
  header_.big_endian = order == "BigEndian";
  header_.wide_lengths = lengths == "UInt64";
  if (codec == "vtkZLibDataCompressor")
    header_.codec = BlockCodec::kZlib;
  else if (codec == "vtkLZ4DataCompressor")
    header_.codec = BlockCodec::kLz4;
  else if (codec == "vtkLZMADataCompressor")
    header_.codec = BlockCodec::kLzma;
  else if (!codec.empty())
    fail(inQuotes(codec) + " is not a compressor of VTK", ErrorCode::kUnsupported);
}

template <std::size_t kCount, class Number>
auto VtiParser::numbers(const VtiAttributes& attributes, const char* name, Number&& number) const {
  const std::string text = attributes.get(name);
  const std::vector<std::string> parts = words(text);
  std::array<typename decltype(number(""))::value_type, kCount> out{};
  bool legal = parts.size() == kCount;
  for (std::size_t i = 0; i < kCount && legal; ++i) {
    const auto value = number(parts[i]);
    legal = value.has_value();
    if (legal) out[i] = *value;
  }
  if (!legal) fail(fmt::format("{}: expected {} numbers (found {})", name, kCount, inQuotes(text)));
  return out;
}

void VtiParser::takeImage(const VtiAttributes& attributes) {
  if (has_image_) fail("holds several images; save one of them", ErrorCode::kUnsupported);
  has_image_ = true;
  if (attributes.find("Origin")) {
    const auto v = numbers<3>(attributes, "Origin", doubleOf);
    header_.origin = {v[0], v[1], v[2]};
  }
  if (attributes.find("Spacing")) {
    const auto v = numbers<3>(attributes, "Spacing", doubleOf);
    header_.spacing = {v[0], v[1], v[2]};
  }
  if (!attributes.find("Direction")) return;
  const auto rows = numbers<9>(attributes, "Direction", doubleOf);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      header_.direction[column][row] = rows[static_cast<std::size_t>(3 * row + column)];
}

void VtiParser::takePiece(const VtiAttributes& attributes) {
  if (++pieces_ > 1) fail("holds an image in several pieces; save it as one", ErrorCode::kUnsupported);
  header_.extent = numbers<6>(attributes, "Extent", integerOf);
}

void VtiParser::takeArray(const VtiAttributes& attributes) {
  const std::string& section = open_[open_.size() - 2];
  if (section != "PointData" && section != "CellData") return;
  if (header_.arrays.size() == kMostArrays) fail(fmt::format("holds more than {} arrays", kMostArrays));
  VtiArray array;
  array.name = attributes.get("Name");
  array.type_text = attributes.get("type");
  array.type = vtkTypeNamed(kVtiTypes, array.type_text);
  array.of_cells = section == "CellData";
  array.is_active = !array.name.empty() && array.name == active_scalars_;
  if (attributes.find("NumberOfComponents"))
    array.components = numbers<1>(attributes, "NumberOfComponents", integerOf)[0];
  const std::string format = attributes.get("format", "ascii");
  if (format == "appended") {
    const std::int64_t offset = numbers<1>(attributes, "offset", integerOf)[0];
    if (offset < 0) fail(fmt::format("offset is {}", offset));
    array.format = VtiFormat::kAppended;
    array.begin = static_cast<std::uint64_t>(offset);
  } else {
    if (format != "ascii" && format != "binary") fail(inQuotes(format) + " is no format of an array");
    array.format = format == "ascii" ? VtiFormat::kAscii : VtiFormat::kBase64;
    array.begin = afterTag();
  }
  header_.arrays.push_back(std::move(array));
}

// An underscore precedes the bytes, behind spaces.
void VtiParser::takeAppended(const VtiAttributes& attributes) {
  const std::string encoding = attributes.get("encoding", "base64");
  if (encoding != "raw" && encoding != "base64") fail(inQuotes(encoding) + " is no encoding of appended data");
  header_.appended_in_base64 = encoding == "base64";
  std::string text(4096, '\0');
  const std::uint64_t begin = afterTag();
  text.resize(file_.readSomeAt(begin, std::as_writable_bytes(std::span(text))));
  const std::size_t mark = text.find_first_not_of(" \t\r\n");
  if (mark == std::string::npos || text[mark] != '_') fail("the appended data do not begin with an underscore");
  header_.appended = begin + mark + 1;
  XML_StopParser(parser_.get(), XML_FALSE);
}

}  // namespace

VtiHeader readVtiHeader(const std::filesystem::path& path) {
  const File file(path);
  return VtiParser(file).parse();
}

}  // namespace kiln
