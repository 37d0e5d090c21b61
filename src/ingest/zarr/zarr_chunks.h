// Reads the chunks of a Zarr array: finds a chunk's bytes in a file or in a shard, decodes the bytes.
#pragma once

#include <cstdint>
#include <memory>

#include "base/file/file.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {

class ZarrChunks : public ChunkedArray {
 public:
  explicit ZarrChunks(ZarrArray array);

  const ChunkLayout& layout() const override { return array_; }
  std::uint64_t decodeBytes() const override;
  std::uint64_t heldBytes() const override;

 private:
  struct Part {
    std::uint64_t offset = 0, bytes = 0;
  };
  BlockCache::Bytes decode(const AxisNumbers& index, std::int64_t place, BlockCache::Bytes spare) override;
  std::vector<std::byte> packedChunk(std::int64_t file, std::int64_t place, ChunkPlace& at);
  std::optional<Part> partOf(const File& shard, std::int64_t file, std::int64_t place);
  BlockCache::Bytes shardIndex(const File& shard) const;
  BlockCache::Bytes unpackBlock(std::span<const std::byte> packed, const ChunkPlace& at) const;
  void requireArray() const;
  /// Size of a shard's table. unit: bytes.
  std::uint64_t tableBytes() const;
  std::size_t voxelBytes() const { return sizeOf(array_.number.voxelType()); }

  ZarrArray array_;
  AxisNumbers files_;    // along each axis
  AxisNumbers in_file_;  // chunks of a file, along each axis
  BlockCache indexes_;
  HandlePool<File> open_;
};

}  // namespace kiln
