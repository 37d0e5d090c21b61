// Zarr version 3 (zarr.json). Source: zarr-specs, docs/v3/core and docs/v3/codecs.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "ingest/chunks/fill_value.h"
#include "ingest/source/header_text.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {
namespace {

// An extension point is an object with a name and a configuration, or the name alone.
struct Extension {
  explicit Extension(const JsonNode& json) : node(json), name((json.isText() ? json : json.at("name")).text()) {
    if (!json.isText()) settings = json.find("configuration");
    constexpr std::string_view kNumcodecs = "numcodecs.";
    if (name.starts_with(kNumcodecs)) name.erase(0, kNumcodecs.size());
  }
  std::optional<JsonNode> find(const char* key) const { return settings ? settings->find(key) : std::nullopt; }
  JsonNode at(const char* key) const {
    if (!settings) node.fail(fmt::format("\"configuration\" with \"{}\" is missing", key));
    return settings->at(key);
  }

  JsonNode node;
  std::string name;
  std::optional<JsonNode> settings;
};

bool isBigEndian(const Extension& bytes) {
  const std::optional<JsonNode> endian = bytes.find("endian");
  if (!endian) return false;
  const std::string order = endian->text();
  if (order != "big" && order != "little") endian->fail("must be \"big\" or \"little\"");
  return order == "big";
}

std::unique_ptr<ByteCodec> byteCodecOf(const Extension& codec) {
  if (codec.name == "gzip") return gzipCodec();
  if (codec.name == "zlib") return zlibCodec();
  if (codec.name == "zstd") return zstdCodec();
  if (codec.name == "lz4") return lz4Codec();
  if (codec.name == "blosc") return bloscCodec();
  if (codec.name == "crc32c") return crc32cCodec();
  if (codec.name == "bz2") return bzip2Codec();
  if (codec.name == "lzma") return lzmaOf(codec.find("format"));
  if (codec.name == "shuffle") return shuffleOf(codec.find("elementsize"));
  codec.node.unsupported(
      fmt::format("the codec {} is not read; write blosc, zstd, gzip or crc32c", inQuotes(codec.name)));
}

// The stored order of the axes, for a "transpose" on top of `axes`.
std::vector<int> transposed(const Extension& codec, const std::vector<int>& axes) {
  const JsonNode order = codec.at("order");
  std::vector<int> out;
  if (order.isText()) {
    out = axes;
    if (order.text() == "F") std::reverse(out.begin(), out.end());
    return out;
  }
  for (const std::int64_t axis : order.wholes()) {
    if (axis < 0 || axis >= static_cast<std::int64_t>(axes.size())) order.fail("must name the axes of the array");
    out.push_back(axes[static_cast<std::size_t>(axis)]);
  }
  if (out.size() != axes.size()) order.fail("must name each axis once");
  return out;
}

// The codecs of an array or of a shard's chunks: orders of axes, then the bytes of numbers, then bytes alone.
void readCodecs(const JsonNode& list, ZarrArray& out);

void readSharding(const Extension& codec, ZarrArray& out) {
  if (out.sharding) codec.node.unsupported("shards in shards are not read");
  Sharding& sharding = out.sharding.emplace();
  out.chunk_shape = codec.at("chunk_shape").wholes();
  if (const std::optional<JsonNode> place = codec.find("index_location")) {
    if (place->text() != "start" && place->text() != "end") place->fail("must be \"start\" or \"end\"");
    sharding.index_at_end = place->text() == "end";
  }
  for (const JsonNode& item : codec.at("index_codecs").items(16)) {
    const Extension of_index(item);
    if (of_index.name == "bytes" || of_index.name == "endian")
      sharding.index_big_endian = isBigEndian(of_index);
    else if (of_index.name == "crc32c")
      sharding.index_codecs.add(crc32cCodec());
    else
      item.unsupported("an index of shards has the codecs bytes and crc32c only");
  }
  readCodecs(codec.at("codecs"), out);
}

void readCodecs(const JsonNode& list, ZarrArray& out) {
  bool as_bytes = false;
  for (const JsonNode& item : list.items(32)) {
    const Extension codec(item);
    if (codec.name == "sharding_indexed") {
      if (as_bytes || list.items().size() != 1) item.unsupported("codecs beside sharding_indexed are not read");
      readSharding(codec, out);
      as_bytes = true;
    } else if (codec.name == "transpose") {
      if (as_bytes) item.fail("transpose must come before the codec of bytes");
      out.stored_axes = transposed(codec, out.stored_axes);
    } else if (isRounding(codec.name)) {
      continue;
    } else if (codec.name == "bytes" || codec.name == "endian") {
      out.number.big_endian = isBigEndian(codec);
      as_bytes = true;
    } else {
      std::unique_ptr<ByteCodec> of_bytes = byteCodecOf(codec);
      if (!as_bytes) item.fail("a codec of numbers (bytes) must come before codecs of bytes");
      out.codecs.add(std::move(of_bytes));
    }
  }
  if (!as_bytes) list.fail("a codec of numbers (bytes, sharding_indexed) is missing");
}

ChunkNames namesOf(const JsonNode& header) {
  ChunkNames out;
  const Extension encoding(header.at("chunk_key_encoding"));
  const std::optional<JsonNode> separator = encoding.find("separator");
  if (encoding.name != "default" && encoding.name != "v2")
    encoding.node.unsupported("chunk_key_encoding must be \"default\" or \"v2\"");
  out.prefix = encoding.name == "default" ? "c" : "";
  out.separator = encoding.name == "default" ? '/' : '.';
  if (!separator) return out;
  const std::string text = separator->text();
  if (text != "." && text != "/") separator->fail("must be \".\" or \"/\"");
  out.separator = text[0];
  return out;
}

}  // namespace

std::optional<ZarrArray> readZarr3(const JsonNode& header) {
  if (const JsonNode version = header.at("zarr_format"); version.whole() != 3)
    version.unsupported("versions 2 and 3 of Zarr are read (found " + version.shown() + ")");
  const JsonNode kind = header.at("node_type");
  if (kind.text() == "group") return std::nullopt;
  if (kind.text() != "array") kind.fail("must be \"array\" or \"group\"");
  ZarrArray out;
  out.attributes = header.find("attributes");
  out.format = "Zarr v3";
  const Extension type(header.at("data_type"));
  const std::optional<StoredNumber> number = storedNumberNamed(type.name);
  if (!number)
    type.node.unsupported(
        fmt::format("numbers of type {} are not read; write whole numbers or floats", type.node.shown()));
  out.number = *number;
  out.shape = header.at("shape").wholes();
  const Extension grid(header.at("chunk_grid"));
  if (grid.name != "regular") grid.node.unsupported("chunks of different sizes are not read; write a regular grid");
  out.chunk_shape = out.file_shape = grid.at("chunk_shape").wholes();
  out.stored_axes.resize(out.shape.size());
  std::iota(out.stored_axes.begin(), out.stored_axes.end(), 0);
  out.names = namesOf(header);
  readCodecs(header.at("codecs"), out);
  if (const std::optional<JsonNode> transformers = header.find("storage_transformers"))
    if (!transformers->items().empty()) transformers->unsupported("storage transformers are not read");
  readFill(header.find("fill_value"), out);
  if (const std::optional<JsonNode> names = header.find("dimension_names")) {
    for (const JsonNode& name : names->items()) out.axis_names.push_back(name.isText() ? name.text() : "");
  }
  return out;
}

}  // namespace kiln
