#include "ingest/zarr/zarr_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostAxes = 32;
// Blosc's and LZ4's own limit for the bytes of a chunk.
constexpr std::uint64_t kMostChunkBytes = (std::uint64_t{1} << 31) - 1;
// A table of chunks of 1 GiB.
constexpr std::uint64_t kMostChunksInFile = std::uint64_t{1} << 26;
constexpr std::uint64_t kMostArrayBytes = std::uint64_t{1} << 63;

// The product of lengths and `unit`; nothing beyond `most`.
std::optional<std::uint64_t> product(const AxisNumbers& lengths, std::uint64_t unit, std::uint64_t most) {
  std::uint64_t out = unit;
  for (const std::int64_t length : lengths) {
    const auto factor = static_cast<std::uint64_t>(length);
    if (factor > most / out) return std::nullopt;
    out *= factor;
  }
  return out;
}

[[noreturn]] void fail(const ZarrArray& array, const std::string& place, const std::string& what) {
  throw Error(ErrorCode::kFormat, array.header, place, what);
}

void requireLengths(const ZarrArray& array, const char* place, const AxisNumbers& lengths) {
  if (lengths.size() != array.shape.size())
    fail(array, place,
         fmt::format("must have a number for each of {} axes (found {})", array.shape.size(), lengths.size()));
  for (const std::int64_t length : lengths)
    if (length < 1) fail(array, place, fmt::format("lengths must be positive (found {})", length));
}

// Tests what all versions have in common, before a number becomes a size.
void requireConsistent(const ZarrArray& array) {
  if (array.shape.size() > kMostAxes)
    fail(array, "shape", fmt::format("an array has at most {} axes (found {})", kMostAxes, array.shape.size()));
  requireLengths(array, "shape", array.shape);
  requireLengths(array, "chunk shape", array.chunk_shape);
  requireLengths(array, "shard shape", array.file_shape);
  if (!product(array.shape, array.number.bytes(), kMostArrayBytes))
    fail(array, "shape", "the array has more than 2^63 bytes");
  if (!product(array.chunk_shape, std::max<std::uint64_t>(array.number.bytes(), 4), kMostChunkBytes))
    fail(array, "chunk shape", "a chunk has 2 GiB or more, which is not read; write smaller chunks");
  for (std::size_t axis = 0; axis < array.shape.size(); ++axis)
    if (array.file_shape[axis] % array.chunk_shape[axis] != 0)
      fail(array, "shard shape",
           fmt::format("must be a multiple of the chunk shape (found {} and {})", array.file_shape[axis],
                       array.chunk_shape[axis]));
  AxisNumbers chunks;
  for (std::size_t axis = 0; axis < array.shape.size(); ++axis)
    chunks.push_back(array.file_shape[axis] / array.chunk_shape[axis]);
  if (!product(chunks, 1, kMostChunksInFile)) fail(array, "shard shape", "a shard has more than 67 million chunks");
  std::vector<int> axes = array.stored_axes, expected(array.shape.size());
  std::iota(expected.begin(), expected.end(), 0);
  std::sort(axes.begin(), axes.end());
  if (axes != expected) fail(array, "order", "must name each axis once");
}

}  // namespace

fs::path ChunkNames::of(const AxisNumbers& index) const {
  std::string out = prefix;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (!out.empty()) out += separator;
    out += std::to_string(index[reversed ? index.size() - 1 - i : i]);
  }
  return out;
}

std::uint64_t ZarrArray::chunkBytes() const { return *product(chunk_shape, number.bytes(), kMostChunkBytes); }

std::uint64_t ZarrArray::chunksInFile() const {
  std::uint64_t out = 1;
  for (std::size_t axis = 0; axis < shape.size(); ++axis)
    out *= static_cast<std::uint64_t>(file_shape[axis] / chunk_shape[axis]);
  return out;
}

namespace {

// Version 2 may leave the separator open: the name of any chunk then shows it.
char separatorIn(const fs::path& folder) {
  char out = '.';
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789.") != std::string::npos || name.front() == '.') return Walk::kGoOn;
    out = name.find('.') == std::string::npos ? '/' : '.';
    return Walk::kStop;
  });
  return out;
}

}  // namespace

fs::path zarrHeaderIn(const fs::path& folder) {
  for (const char* const name : {"zarr.json", ".zarray", ".zgroup", "attributes.json"})
    if (isThere(folder / name)) return folder / name;
  return {};
}

std::optional<JsonNode> zarrAttributes(const fs::path& folder, std::uint64_t memory_bytes) {
  const fs::path header = zarrHeaderIn(folder);
  if (header.filename() == "zarr.json") return JsonNode(header, memory_bytes).find("attributes");
  if (header.filename() == "attributes.json") return JsonNode(header, memory_bytes);
  if (isThere(folder / ".zattrs")) return JsonNode(folder / ".zattrs", memory_bytes);
  return std::nullopt;
}

std::unique_ptr<ByteCodec> shuffleOf(const std::optional<JsonNode>& element_size) {
  constexpr std::int64_t kMost = 256;
  const std::int64_t bytes = element_size ? element_size->whole() : 4;
  if (bytes < 1 || bytes > kMost) element_size->fail(fmt::format("must be from 1 to {}", kMost));
  return shuffleCodec(static_cast<std::size_t>(bytes));
}

std::unique_ptr<ByteCodec> lzmaOf(const std::optional<JsonNode>& format) {
  constexpr std::int64_t kXz = 1;
  if (format && format->whole() != kXz) format->unsupported("of the formats of lzma, 1 (xz) is read; write xz");
  return xzCodec();
}

bool isRounding(const std::string& codec) { return codec == "bitround" || codec == "quantize"; }

std::optional<ZarrArray> readZarrArray(const fs::path& folder, std::uint64_t memory_bytes) {
  const fs::path header = zarrHeaderIn(folder);
  if (header.empty() || header.filename() == ".zgroup") return std::nullopt;
  const JsonNode json(header, memory_bytes);
  std::optional<ZarrArray> out = header.filename() == "zarr.json" ? readZarr3(json)
                                 : header.filename() == ".zarray" ? readZarr2(json)
                                                                  : readN5(json);
  if (!out) return std::nullopt;
  out->folder = folder;
  out->header = header;
  if (out->names.separator == ChunkNames::kOpen) out->names.separator = separatorIn(folder);
  if (header.filename() == ".zarray") out->attributes = zarrAttributes(folder, memory_bytes);
  requireConsistent(*out);
  return out;
}

}  // namespace kiln
