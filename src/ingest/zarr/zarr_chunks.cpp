// Invariant: every length is tested against its file, and every decoded size against the array's header, before memory
// is taken. A hostile chunk costs at most the memory of a true one.
#include "ingest/zarr/zarr_chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/byte_record.h"
#include "base/error.h"
#include "base/file/path_status.h"
#include "ingest/bytes/value_map.h"
#include "ingest/chunks/chunk_voxels.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kIndexCacheBytes = 16 << 20;
// Offset and length of a chunk in a shard; both have all bits set for a chunk that does not exist.
constexpr std::uint64_t kEntryBytes = 2 * sizeof(std::uint64_t);
// Mode, number of axes, 32 lengths at most, number of values.
constexpr std::uint64_t kMostN5HeaderBytes = 4 + 32 * 4 + 4;

std::vector<std::byte> readPart(const File& file, std::uint64_t offset, std::uint64_t bytes) {
  std::vector<std::byte> out(bytes);
  file.readAt(offset, out);
  return out;
}

}  // namespace

ZarrChunks::ZarrChunks(ZarrArray array) : ChunkedArray(array), array_(std::move(array)) {
  for (std::size_t axis = 0; axis < array_.shape.size(); ++axis) {
    const std::int64_t length = array_.file_shape[axis];
    files_.push_back((array_.shape[axis] - 1) / length + 1);
    in_file_.push_back(length / array_.chunk_shape[axis]);
  }
  indexes_.setCapacity(std::max(kIndexCacheBytes, tableBytes() + BlockCache::kOwnBytes));
}

std::uint64_t ZarrChunks::tableBytes() const { return array_.sharding ? array_.chunksInFile() * kEntryBytes : 0; }

std::uint64_t ZarrChunks::decodeBytes() const {
  const std::uint64_t voxels = productOf(array_.chunk_shape);
  // A cut block of N5 is decoded beside the whole chunk.
  const std::uint64_t cut = array_.has_block_headers ? voxels * voxelBytes() : 0;
  // A shard's table as read and as decoded.
  return decodeVoxelsBytes(array_.codecs, array_.number, voxels) + cut + 2 * tableBytes();
}

std::uint64_t ZarrChunks::heldBytes() const {
  if (!array_.sharding) return 0;
  const std::uint64_t shards = productOf(files_);
  const std::uint64_t entry = tableBytes() + BlockCache::kOwnBytes, most = std::max(kIndexCacheBytes, entry);
  return shards > most / entry ? most : shards * entry;
}

BlockCache::Bytes ZarrChunks::decode(const AxisNumbers& index, std::int64_t, BlockCache::Bytes spare) {
  AxisNumbers file(index.size()), inner(index.size());
  for (std::size_t axis = 0; axis < index.size(); ++axis) {
    file[axis] = index[axis] / in_file_[axis];
    inner[axis] = index[axis] % in_file_[axis];
  }
  ChunkPlace at{array_.folder / array_.names.of(file), ""};
  const std::vector<std::byte> packed = packedChunk(placeIn(files_, file), placeIn(in_file_, inner), at);
  if (packed.empty()) {
    if (!array_.fill_fault.empty()) throw Error(ErrorCode::kFormat, array_.header, "fill_value", array_.fill_fault);
    return {};
  }
  if (array_.has_block_headers) return unpackBlock(packed, at);
  BlockCache::Bytes out = std::move(spare);
  out.resize(productOf(array_.chunk_shape) * voxelBytes());
  decodeVoxels(array_.codecs, array_.number, packed, out, at);
  return out;
}

// Returns no bytes for a chunk that does not exist.
std::vector<std::byte> ZarrChunks::packedChunk(std::int64_t file, std::int64_t place, ChunkPlace& at) {
  try {
    if (!array_.sharding) {
      const File whole(at.file);
      const std::uint64_t most =
          array_.codecs.packedBytes(array_.chunkBytes()) + (array_.has_block_headers ? kMostN5HeaderBytes : 0);
      if (whole.size() == 0) at.fail("is empty");
      if (whole.size() > most)
        at.fail(fmt::format("has {} bytes, and a chunk of {} bytes has at most {} packed", whole.size(),
                            array_.chunkBytes(), most));
      return readPart(whole, 0, whole.size());
    }
    const auto shard = open_.take(static_cast<std::size_t>(file), [&] { return std::make_unique<File>(at.file); });
    at.where = fmt::format("chunk {}", place);
    const std::optional<Part> part = partOf(*shard, file, place);
    return part ? readPart(*shard, part->offset, part->bytes) : std::vector<std::byte>();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    requireArray();
    return {};
  }
}

// A disk that has gone must not look like chunks that were never written.
void ZarrChunks::requireArray() const {
  if (isThere(array_.header)) return;
  throw Error(ErrorCode::kNotFound, array_.header, "", "has gone while the array was read");
}

std::optional<ZarrChunks::Part> ZarrChunks::partOf(const File& shard, std::int64_t file, std::int64_t place) {
  const auto table = indexes_.get({file, 0}, [&](BlockCache::Bytes) { return shardIndex(shard); });
  ByteTaker entry{std::span(*table).subspan(static_cast<std::uint64_t>(place) * kEntryBytes)};
  Part part;
  part.offset = entry.take<std::uint64_t>();
  part.bytes = entry.take<std::uint64_t>();
  if (part.offset == UINT64_MAX && part.bytes == UINT64_MAX) return std::nullopt;
  const std::uint64_t most = array_.codecs.packedBytes(array_.chunkBytes());
  const ChunkPlace at{shard.path(), fmt::format("chunk {}", place)};
  if (part.bytes == 0 || part.bytes > most)
    at.fail(fmt::format("the shard's index gives it {} bytes, and a chunk of {} bytes has 1 to {} packed", part.bytes,
                        array_.chunkBytes(), most));
  if (part.offset > shard.size() || part.bytes > shard.size() - part.offset)
    at.fail(fmt::format("the shard's index places it at byte {} with {} bytes, but the file has {}", part.offset,
                        part.bytes, shard.size()));
  return part;
}

BlockCache::Bytes ZarrChunks::shardIndex(const File& shard) const {
  const Sharding& sharding = *array_.sharding;
  const std::uint64_t bytes = tableBytes(), packed = sharding.index_codecs.packedBytes(bytes);
  const ChunkPlace at{shard.path(), "index of the shard"};
  if (shard.size() < packed)
    at.fail(fmt::format("the file has {} bytes, and the index alone has {}", shard.size(), packed));
  BlockCache::Bytes out(bytes);
  sharding.index_codecs.decode(readPart(shard, sharding.index_at_end ? shard.size() - packed : 0, packed), out, at);
  if (sharding.index_big_endian != (std::endian::native == std::endian::big))
    swapBytes(out.data(), out.size() / sizeof(std::uint64_t), sizeof(std::uint64_t));
  return out;
}

// Unpacks a block of N5, which may be cut at the border of the array, to a whole chunk.
BlockCache::Bytes ZarrChunks::unpackBlock(std::span<const std::byte> packed, const ChunkPlace& at) const {
  ByteTaker header{packed};
  const auto mode = header.takeBigEndian<std::uint16_t>(), axes = header.takeBigEndian<std::uint16_t>();
  if (!header.ok || mode > 1) at.fail("is no block of numbers with N5's header");
  if (axes != array_.shape.size()) at.fail(fmt::format("has {} axes, but the array {}", axes, array_.shape.size()));
  AxisNumbers n(axes);
  for (std::size_t i = axes; i-- > 0;) n[i] = header.takeBigEndian<std::uint32_t>();
  if (mode == 1) header.takeBigEndian<std::uint32_t>();
  if (!header.ok) at.fail("ends in N5's header");
  for (std::size_t axis = 0; axis < axes; ++axis)
    if (n[axis] < 1 || n[axis] > array_.chunk_shape[axis])
      at.fail(
          fmt::format("has {} voxels along axis {}, but a block has 1 to {}", n[axis], axis, array_.chunk_shape[axis]));
  BlockCache::Bytes voxels(productOf(n) * voxelBytes());
  decodeVoxels(array_.codecs, array_.number, header.left, voxels, at);
  return n == array_.chunk_shape ? voxels : wholeChunk(array_, voxels, n);
}

}  // namespace kiln
