#include "support/files/vti_files.h"

#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "support/files/header_writer.h"
#include "support/files/packed_bytes.h"

namespace kiln::test {
namespace {

constexpr const char* kVtiTypes[] = {"UInt8", "Int8", "UInt16", "Int16", "UInt32", "Int32", "Float32", "Float64"};
constexpr const char* kCompressors[] = {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"};

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string lengthsOf(const std::vector<std::size_t>& numbers, const VtiLayout& layout) {
  std::string out(numbers.size() * (layout.wide ? 8 : 4), '\0');
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (layout.wide)
      putNumber(out, 8 * i, static_cast<std::uint64_t>(numbers[i]), layout.big);
    else
      putNumber(out, 4 * i, static_cast<std::uint32_t>(numbers[i]), layout.big);
  }
  return out;
}

// The bytes of an array as they stand in the file.
std::string arrayBytes(const std::string& stored, const VtiLayout& layout) {
  const bool text = layout.format == "binary" || layout.format == "base64";
  const auto written = [&](const std::string& bytes) { return text ? base64(bytes) : bytes; };
  if (layout.codec == 0) return written(lengthsOf({stored.size()}, layout) + stored);
  const std::size_t last = stored.size() % layout.block_bytes;
  std::vector<std::size_t> lengths = {(stored.size() + layout.block_bytes - 1) / layout.block_bytes, layout.block_bytes,
                                      last};
  std::string blocks;
  for (std::size_t at = 0; at < stored.size(); at += layout.block_bytes) {
    const std::string block = vtiBlock(std::string_view(stored).substr(at, layout.block_bytes), layout.codec);
    lengths.push_back(block.size());
    blocks += block;
  }
  return written(lengthsOf(lengths, layout)) + written(blocks);
}

}  // namespace

std::string vtiBlock(std::string_view bytes, int codec) {
  if (codec == 1) return zlibbed(bytes);
  if (codec == 2) return lz4Block(bytes);
  return xzStream(bytes);
}

std::string vtiFile(const ForeignVolume& volume, const VtiLayout& layout) {
  const Extent3& n = volume.dims;
  const int cell = layout.kind == "CellData" ? 1 : 0;
  const std::string extent = !layout.extent.empty()
                                 ? layout.extent
                                 : fmt::format("0 {} 0 {} 0 {}", n.x - 1 + cell, n.y - 1 + cell, n.z - 1 + cell);
  const bool appended = layout.format == "raw" || layout.format == "base64";
  std::string out = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{}\" header_type=\"{}\"{}>\n"
      "<ImageData WholeExtent=\"{}\" {}>\n<Piece Extent=\"{}\">\n<{}{}>\n{}",
      layout.big ? "BigEndian" : "LittleEndian", layout.wide ? "UInt64" : "UInt32",
      layout.codec == 0 ? "" : fmt::format(" compressor=\"{}\"", kCompressors[layout.codec]), extent,
      layout.image.empty() ? "Origin=\"0 0 0\" Spacing=\"1 1 1\"" : layout.image, extent, layout.kind, layout.scalars,
      layout.more_arrays);
  const std::string stored = volume.stored(layout.big);
  out += fmt::format("<DataArray type=\"{}\" Name=\"v\" format=\"{}\"", kVtiTypes[static_cast<int>(volume.type)],
                     appended ? "appended" : layout.format);
  if (appended)
    out += " offset=\"5\"/>\n";
  else
    out += ">\n    " + (layout.format == "ascii" ? decimalsOf(volume, "\n  ") : arrayBytes(stored, layout)) +
           "\n</DataArray>\n";
  out += fmt::format("</{}>\n</Piece>\n</ImageData>\n", layout.kind);
  if (appended)
    out += "<AppendedData encoding=\"" + layout.format + "\">\n   _other" + arrayBytes(stored, layout) +
           "\n</AppendedData>\n";
  return out + "</VTKFile>\n";
}

}  // namespace kiln::test
