// The parser stops at the appended data, which are not XML. Nothing of an inline array is kept: the header holds its
// place only.
// Source: VTK File Formats, docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
#include "ingest/vtk/vti_header.h"

#include <fmt/format.h>

#include <string_view>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/source/header_text.h"
#include "ingest/source/xml_reader.h"

namespace kiln {
namespace {

constexpr std::size_t kMostArrays = 4096;

constexpr VtkTypeName kVtiTypes[] = {
    {"UInt8", VoxelType::u8},         {"Int8", VoxelType::i8},     {"UInt16", VoxelType::u16},
    {"Int16", VoxelType::i16},        {"UInt32", VoxelType::u32},  {"Int32", VoxelType::i32},
    {"Float32", VoxelType::f32},      {"Float64", VoxelType::f64}, {"UInt64", StoredType::wide(false)},
    {"Int64", StoredType::wide(true)}};

class VtiParser : public XmlReader {
 public:
  using XmlReader::XmlReader;
  VtiHeader read();

 private:
  void begin(std::string_view name, const XmlAttributes& attributes) override;
  void takeFile(const XmlAttributes& attributes);
  void takeImage(const XmlAttributes& attributes);
  void takePiece(const XmlAttributes& attributes);
  void takeArray(const XmlAttributes& attributes);
  void takeAppended(const XmlAttributes& attributes);
  template <std::size_t kCount, class Number>
  auto numbers(const XmlAttributes& attributes, const char* name, Number&& number) const;

  VtiHeader header_;
  int pieces_ = 0;
  bool has_image_ = false;
  /// Active scalars of the last PointData or CellData element; empty without one.
  std::string active_scalars_;
};

VtiHeader VtiParser::read() {
  parse();
  if (!has_image_ || pieces_ == 0) throw Error(ErrorCode::kFormat, file().path(), "", "has no piece of an image");
  return std::move(header_);
}

void VtiParser::begin(std::string_view name, const XmlAttributes& attributes) {
  if (open().size() == 1) {
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

void VtiParser::takeFile(const XmlAttributes& attributes) {
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
auto VtiParser::numbers(const XmlAttributes& attributes, const char* name, Number&& number) const {
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

void VtiParser::takeImage(const XmlAttributes& attributes) {
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

void VtiParser::takePiece(const XmlAttributes& attributes) {
  if (++pieces_ > 1) fail("holds an image in several pieces; save it as one", ErrorCode::kUnsupported);
  header_.extent = numbers<6>(attributes, "Extent", integerOf);
}

void VtiParser::takeArray(const XmlAttributes& attributes) {
  const std::string& section = open()[open().size() - 2];
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
void VtiParser::takeAppended(const XmlAttributes& attributes) {
  const std::string encoding = attributes.get("encoding", "base64");
  if (encoding != "raw" && encoding != "base64") fail(inQuotes(encoding) + " is no encoding of appended data");
  header_.appended_in_base64 = encoding == "base64";
  std::string text(4096, '\0');
  const std::uint64_t begin = afterTag();
  text.resize(file().readSomeAt(begin, std::as_writable_bytes(std::span(text))));
  const std::size_t mark = text.find_first_not_of(" \t\r\n");
  if (mark == std::string::npos || text[mark] != '_') fail("the appended data do not begin with an underscore");
  header_.appended = begin + mark + 1;
  stop();
}

}  // namespace

VtiHeader readVtiHeader(const std::filesystem::path& path) {
  const File file(path);
  return VtiParser(file).read();
}

}  // namespace kiln
