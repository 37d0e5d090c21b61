// Zarr version 2 (.zarray). Source: zarr-specs, docs/v2/v2.0.rst; numcodecs for the codecs' names.
#include <fmt/format.h>

#include <numeric>

#include "ingest/bytes/numpy_type.h"
#include "ingest/chunks/fill_value.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {
namespace {

StoredNumber storedNumberOf(const JsonNode& dtype) {
  if (!dtype.isText()) dtype.unsupported("arrays of records are not read; write each field as an array of its own");
  const std::string text = dtype.text();
  const auto [order, code] = numpyTypeText(text);
  if (code == "b1") return *storedNumberNamed("bool");
  const std::optional<StoredType> type = numpyTypeOf(code);
  if (!type)
    dtype.unsupported(
        fmt::format("numbers of type {} are not read; write u1 to u8, i1 to i8, f2, f4 or f8", dtype.shown()));
  return {*type, order == '>'};
}

// A compressor or filter of numcodecs; null for a filter that needs no reverse.
std::unique_ptr<ByteCodec> codecOf(const JsonNode& json) {
  const JsonNode id = json.at("id");
  const std::string name = id.text();
  if (name == "gzip") return gzipCodec();
  if (name == "zlib") return zlibCodec();
  if (name == "zstd") return zstdCodec();
  if (name == "lz4") return lz4Codec();
  if (name == "blosc") return bloscCodec();
  if (name == "crc32c") {
    const std::optional<JsonNode> location = json.find("location");
    if (location && location->text() != "end") location->unsupported("a checksum in front of its data is not read");
    return crc32cCodec();
  }
  if (name == "bz2") return bzip2Codec();
  if (name == "lzma") return lzmaOf(json.find("format"));
  if (isRounding(name)) return nullptr;
  if (name == "shuffle") return shuffleOf(json.find("elementsize"));
  id.unsupported(fmt::format("the codec {} is not read; write blosc, zstd, lz4, gzip or zlib", id.shown()));
}

}  // namespace

ZarrArray readZarr2(const JsonNode& header) {
  if (const JsonNode version = header.at("zarr_format"); version.whole() != 2) version.fail("must be 2 in a .zarray");
  ZarrArray out;
  out.format = "Zarr v2";
  out.number = storedNumberOf(header.at("dtype"));
  out.shape = header.at("shape").wholes();
  out.chunk_shape = out.file_shape = header.at("chunks").wholes();
  const std::optional<JsonNode> separator = header.find("dimension_separator"), order = header.find("order");
  out.names.separator = ChunkNames::kOpen;
  if (separator) {
    const std::string text = separator->text();
    if (text != "." && text != "/") separator->fail("must be \".\" or \"/\"");
    out.names.separator = text[0];
  }
  out.stored_axes.resize(out.shape.size());
  if (order && order->text() != "C" && order->text() != "F") order->fail("must be \"C\" or \"F\"");
  if (order && order->text() == "F")
    std::iota(out.stored_axes.rbegin(), out.stored_axes.rend(), 0);
  else
    std::iota(out.stored_axes.begin(), out.stored_axes.end(), 0);
  if (const std::optional<JsonNode> filters = header.find("filters")) {
    for (const JsonNode& filter : filters->items(16))
      if (std::unique_ptr<ByteCodec> codec = codecOf(filter)) out.codecs.add(std::move(codec));
  }
  if (const std::optional<JsonNode> compressor = header.find("compressor"))
    if (std::unique_ptr<ByteCodec> codec = codecOf(*compressor)) out.codecs.add(std::move(codec));
  readFill(header.find("fill_value"), out);
  return out;
}

}  // namespace kiln
