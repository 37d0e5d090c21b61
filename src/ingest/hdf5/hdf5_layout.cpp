#include "ingest/hdf5/hdf5_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "base/error.h"
#include "ingest/chunks/fill_value.h"
#include "ingest/codec/hdf5_codecs.h"
#include "ingest/source/header_text.h"

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
      return bloscCodec();
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

std::vector<hdf5::ChunkEntry> tableOf(Hdf5Reader& reader, const Hdf5Layout& layout, const fs::path& file) {
  std::vector<hdf5::ChunkEntry> out = reader.table(layout.path);
  const std::uint64_t chunks = productOf(gridOf(layout));
  if (!out.empty() && out.size() != chunks)
    throw Error(ErrorCode::kFormat, file, layout.path,
                fmt::format("the HDF5 library lists {} chunks of {}", out.size(), chunks));
  return out;
}

// Finds a file as the library does: by its path, beside the data set's file, in the working directory, beside the
// target of a link to that file. A missing file of an absolute name is searched by the last part of the name.
std::optional<fs::path> foundFile(const fs::path& name, const fs::path& file) {
  std::error_code ignored;
  const fs::path last = name.is_absolute() ? name.filename() : name;
  const fs::path linked = fs::canonical(file, ignored).parent_path();
  for (const fs::path& path : {file.parent_path() / name, file.parent_path() / last, last, linked / last})
    if (fs::is_regular_file(path, ignored)) return path;
  return std::nullopt;
}

// Voxels of a missing file would become the fill value. "." is the file itself; "%b" numbers files that may be missing.
std::vector<fs::path> filesOf(const JsonNode& header, const fs::path& file, const std::string& dataset) {
  std::vector<fs::path> out;
  for (const std::string& name : header.at("files").texts()) {
    if (name == "." || name.find('%') != std::string::npos) continue;
    const std::optional<fs::path> found = foundFile(name, file);
    if (!found)
      throw Error(ErrorCode::kNotFound, file, shown(dataset),
                  fmt::format("the file {} with voxels of this data set is missing; put the file beside this one",
                              inQuotes(name)));
    out.push_back(*found);
  }
  return out;
}

std::vector<Hdf5Filter> filtersOf(const JsonNode& header) {
  std::vector<Hdf5Filter> out;
  const std::optional<JsonNode> filters = header.find("filters");
  if (!filters) return out;
  for (const JsonNode& filter : filters->items(32))
    out.push_back({static_cast<int>(filter.at("id").whole()), filter.at("values").wholes()});
  return out;
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
  const JsonNode header(file, reader.text(hdf5::Request::kLayout, path, memory_bytes), memory_bytes);
  const std::optional<JsonNode> type = header.find("type"), chunk = header.find("chunk"),
                                offset = header.find("offset");
  if (!type)
    throw Error(ErrorCode::kUnsupported, file, path, "holds no whole numbers or floats, so that it is no volume");
  const std::optional<StoredNumber> stored = storedNumberNamed(type->at("name").text());
  const std::optional<StoredNumber> native = storedNumberNamed(header.at("native").text());
  if (!native) throw Error(ErrorCode::kUnsupported, file, path, "has numbers of a type that is not read");
  Hdf5Layout out;
  out.path = path;
  out.number = out.served = *native;
  out.shape = lengths(header.at("shape"));
  out.stored_axes.resize(out.shape.size());
  std::iota(out.stored_axes.begin(), out.stored_axes.end(), 0);
  out.chunk_shape = chunk ? lengths(*chunk) : slabs(out.shape, native->bytes());
  if (out.chunk_shape.size() != out.shape.size()) header.fail("chunks must have the axes of the data set");
  out.filters = filtersOf(header);
  // A block of the user's own bytes in front moves all places by an amount that versions of the library count or not.
  const bool here =
      stored && type->at("plain").truth() && header.at("in_this_file").truth() && header.at("user_block").whole() == 0;
  const bool known = here && chunk && codecsOf(out.filters, 0, stored->bytes());
  if (here && (offset || known)) {
    out.number = *stored;
    out.number.big_endian = type->at("big").truth();
  }
  if (here && offset) out.offset = static_cast<std::uint64_t>(offset->whole());
  if (known) out.table = tableOf(reader, out, file);
  // Too many chunks are not listed.
  if (known && out.table.empty()) out.number = out.served;
  out.files = filesOf(header, file, path);
  readFill(header.find("fill"), out);
  return out;
}

}  // namespace kiln
