#include "ingest/hdf5/hdf5_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/memory/memory.h"
#include "ingest/chunks/fill_value.h"
#include "ingest/codec/hdf5_codecs.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Numbers of filters. Source: github.com/HDFGroup/hdf5_plugins, registered filters.
constexpr int kDeflate = 1, kShuffle = 2, kFletcher32 = 3, kLzf = 32000, kBlosc = 32001, kLz4 = 32004,
              kBitshuffle = 32008, kZstd = 32015;

// Null for a filter that Kiln leaves to the library.
std::unique_ptr<ByteCodec> filterCodec(const Hdf5Filter& filter, std::size_t number_bytes) {
  const auto value = [&](std::size_t i) { return i < filter.values.size() ? filter.values[i] : 0; };
  switch (filter.id) {
    case kDeflate:
      return zlibCodec();
    case kShuffle:
      return shuffleCodec(value(0) > 0 && value(0) <= 256 ? static_cast<std::size_t>(value(0)) : number_bytes);
    case kFletcher32:
      return fletcher32Codec();
    case kLzf:
      return lzfCodec();
    case kBlosc:
      // The seventh value is the compressor; 0, or no value, is BloscLZ, which Kiln does not decode.
      return value(6) != 0 ? bloscCodec() : nullptr;
    case kLz4:
      return hdf5Lz4Codec();
    case kZstd:
      return zstdCodec();
    case kBitshuffle: {
      constexpr std::int64_t kNone = 0, kWithLz4 = 2, kWithZstd = 3;
      const std::int64_t size = value(2), block = value(3), inner = value(4);
      if (size < 1 || size > 256 || block < 0 || block > (1 << 24) || block % 8 != 0) return nullptr;
      const auto bytes = static_cast<std::size_t>(size), numbers = static_cast<std::size_t>(block);
      if (inner == kNone) return bitshuffleCodec(bytes, numbers, BitshuffleInner::kNone);
      if (inner == kWithLz4) return bitshuffleCodec(bytes, numbers, BitshuffleInner::kLz4);
      if (inner == kWithZstd) return bitshuffleCodec(bytes, numbers, BitshuffleInner::kZstd);
      return nullptr;
    }
    default:
      return nullptr;
  }
}

AxisNumbers lengths(const JsonNode& list) {
  AxisNumbers out = list.wholes();
  std::uint64_t product = 1;
  for (const std::int64_t length : out) {
    if (length < 1) list.fail(fmt::format("lengths must be positive (found {})", length));
    if (static_cast<std::uint64_t>(length) > (std::uint64_t{1} << 60) / product) list.fail("is too large");
    product *= static_cast<std::uint64_t>(length);
  }
  return out;
}

// Chunks that the library reads: slabs of up to 4 MiB, of whole rows if a row is not longer.
AxisNumbers slabs(const AxisNumbers& shape, std::size_t bytes) {
  AxisNumbers out(shape.size(), 1);
  std::int64_t room = (4 << 20) / static_cast<std::int64_t>(bytes);
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    out[axis] = std::min(shape[axis], std::max<std::int64_t>(room, 1));
    room /= out[axis];
  }
  return out;
}

void requireTable(const std::vector<hdf5::ChunkEntry>& table, const Hdf5Layout& layout, const fs::path& file) {
  std::uint64_t chunks = 1;
  for (std::size_t axis = 0; axis < layout.shape.size(); ++axis)
    chunks *= static_cast<std::uint64_t>((layout.shape[axis] - 1) / layout.chunk_shape[axis] + 1);
  if (table.size() != chunks)
    throw Error(ErrorCode::kFormat, file, layout.path,
                fmt::format("the HDF5 library lists {} chunks of {}", table.size(), chunks));
}

}  // namespace

std::optional<CodecChain> codecsOf(const std::vector<Hdf5Filter>& filters, std::uint64_t left_out,
                                   std::size_t number_bytes) {
  CodecChain out;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    std::unique_ptr<ByteCodec> codec = filterCodec(filters[i], number_bytes);
    if (!codec) return std::nullopt;
    if ((left_out >> i & 1) == 0) out.add(std::move(codec));
  }
  return out;
}

Hdf5Layout readHdf5Layout(Hdf5Reader& reader, const fs::path& file, const std::string& path,
                          std::uint64_t memory_bytes) {
  constexpr std::uint64_t kMostHeaderBytes = 16 << 20;
  const std::uint64_t most =
      std::min<std::uint64_t>(std::numeric_limits<std::uint64_t>::max() - kMostHeaderBytes, memory_bytes) +
      kMostHeaderBytes;
  const std::vector<std::byte> answer = reader.answer(hdf5::Request::kLayout, path, most);
  const auto end = std::find(answer.begin(), answer.end(), std::byte{'\n'});
  const std::string_view text(reinterpret_cast<const char*>(answer.data()),
                              static_cast<std::size_t>(end - answer.begin()));
  const JsonNode header(file, std::string(text));
  Hdf5Layout out;
  out.path = path;
  out.attributes = header.find("attributes");
  const std::optional<JsonNode> type = header.find("type");
  if (!type)
    throw Error(ErrorCode::kUnsupported, file, path, "holds no whole numbers or floats, so that it is no volume");
  out.shape = lengths(header.at("shape"));
  const std::optional<StoredNumber> stored = storedNumberNamed(type->at("name").text());
  const std::optional<StoredNumber> native = storedNumberNamed(header.at("native").text());
  const std::string layout = header.at("layout").text();
  const bool here = header.at("user_block").whole() == 0 && stored && type->at("plain").truth();
  out.stored_axes.resize(out.shape.size());
  std::iota(out.stored_axes.begin(), out.stored_axes.end(), 0);
  if (const std::optional<JsonNode> filters = header.find("filters")) {
    for (const JsonNode& filter : filters->items(64))
      out.filters.push_back(
          {static_cast<int>(filter.at("id").whole()), filter.at("name").text(), filter.at("values").wholes()});
  }
  const bool known = here && codecsOf(out.filters, 0, stored->bytes).has_value();
  if (!native) throw Error(ErrorCode::kUnsupported, file, path, "has numbers of a type that is not read");
  out.number =
      here && ((layout == "contiguous" && header.find("offset")) || (layout == "chunked" && known)) ? *stored : *native;
  if (here && layout == "contiguous" && header.find("offset")) {
    out.number.big_endian = type->at("big").truth();
    out.offset = static_cast<std::uint64_t>(header.at("offset").whole());
    out.chunk_shape = slabs(out.shape, out.number.bytes);
  } else if (layout == "chunked" && known) {
    out.number.big_endian = type->at("big").truth();
    out.chunk_shape = lengths(header.at("chunk"));
    if (out.chunk_shape.size() != out.shape.size()) header.fail("chunks must have the axes of the data set");
    const auto table_bytes = static_cast<std::size_t>(answer.end() - end) - 1;
    out.table.resize(table_bytes / sizeof(hdf5::ChunkEntry));
    std::memcpy(out.table.data(), answer.data() + text.size() + 1, out.table.size() * sizeof(hdf5::ChunkEntry));
    requireTable(out.table, out, file);
  } else {
    out.chunk_shape = layout == "chunked" ? lengths(header.at("chunk")) : slabs(out.shape, out.number.bytes);
  }
  readFill(header.find("fill"), out);
  return out;
}

}  // namespace kiln
