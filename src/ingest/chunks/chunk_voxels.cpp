#include "ingest/chunks/chunk_voxels.h"

#include <cstring>

namespace kiln {

void decodeVoxels(const CodecChain& codecs, const StoredNumber& number, std::span<const std::byte> packed,
                  std::span<std::byte> voxels, const ChunkPlace& place) {
  readVoxels(number, voxels, place, [&](std::span<std::byte> stored) { codecs.decode(packed, stored, place); });
}

std::uint64_t decodeVoxelsBytes(const CodecChain& codecs, const StoredNumber& number, std::uint64_t count) {
  const std::uint64_t stored = count * number.bytes(), size = sizeOf(number.voxelType());
  return codecs.packedBytes(stored) + codecs.scratchBytes(stored) + (number.bytes() == size ? 0 : stored) +
         count * size;
}

BlockCache::Bytes wholeChunk(const ChunkLayout& layout, std::span<const std::byte> part, const AxisNumbers& n) {
  const std::size_t size = sizeOf(layout.number.voxelType());
  BlockCache::Bytes out(productOf(layout.chunk_shape) * size);
  for (std::size_t at = 0; at < out.size(); at += size) std::memcpy(&out[at], layout.fill.data(), size);
  // Row by row: the index of a row is counted along all axes but the fastest.
  const std::size_t row = static_cast<std::size_t>(n.back()) * size;
  AxisNumbers index(n.size(), 0);
  for (std::size_t from = 0; from < part.size(); from += row) {
    std::memcpy(&out[static_cast<std::size_t>(placeIn(layout.chunk_shape, index)) * size], &part[from], row);
    for (std::size_t axis = n.size() - 1; axis-- > 0;) {
      if (++index[axis] < n[axis]) break;
      index[axis] = 0;
    }
  }
  return out;
}

}  // namespace kiln
