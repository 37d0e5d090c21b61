// N5 (attributes.json). Axes are listed the fastest first, numbers are big-endian, and blocks have a header. Source:
// the README of github.com/saalfeldlab/n5, "File-system specification".
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "ingest/zarr/zarr_array.h"

namespace kiln {
namespace {

// Null for raw blocks. "compressionType" is the spelling of the first version.
std::unique_ptr<ByteCodec> n5Codec(const JsonNode& header) {
  const std::optional<JsonNode> compression = header.find("compression");
  const JsonNode type = compression ? compression->at("type") : header.at("compressionType");
  const std::string name = type.text();
  if (name == "raw") return nullptr;
  if (name == "gzip") {
    const std::optional<JsonNode> zlib = compression ? compression->find("useZlib") : std::nullopt;
    return zlib && zlib->truth() ? zlibCodec() : gzipCodec();
  }
  if (name == "lz4") return lz4StreamCodec();
  if (name == "blosc") return bloscCodec();
  if (name == "zstd") return zstdCodec();
  if (name == "bzip2") return bzip2Codec();
  if (name == "xz") return xzCodec();
  type.unsupported(fmt::format("blocks compressed by {} are not read; write gzip, lz4, blosc, zstd, bzip2, xz or raw",
                               type.shown()));
}

AxisNumbers reversed(AxisNumbers numbers) {
  std::reverse(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace

std::optional<ZarrArray> readN5(const JsonNode& header) {
  const std::optional<JsonNode> dimensions = header.find("dimensions");
  if (!dimensions) return std::nullopt;
  if (const std::optional<JsonNode> multiset = header.find("isLabelMultiset"); multiset && multiset->truth())
    multiset->unsupported("blocks of label multisets, several labels a voxel, are not read; write one label a voxel");
  ZarrArray out;
  out.format = "N5";
  const JsonNode type = header.at("dataType");
  const std::optional<StoredNumber> number = storedNumberNamed(type.text());
  if (!number) type.unsupported(fmt::format("numbers of type {} are not read", type.shown()));
  out.number = *number;
  out.number.big_endian = true;
  out.shape = reversed(dimensions->wholes());
  out.chunk_shape = out.file_shape = reversed(header.at("blockSize").wholes());
  out.stored_axes.resize(out.shape.size());
  std::iota(out.stored_axes.begin(), out.stored_axes.end(), 0);
  out.names = {"", '/', true};
  if (std::unique_ptr<ByteCodec> codec = n5Codec(header)) out.codecs.add(std::move(codec));
  out.has_block_headers = true;
  out.attributes = header;
  return out;
}

}  // namespace kiln
