// From the bytes of a chunk to its voxels.
#pragma once

#include "ingest/bytes/block_cache.h"
#include "ingest/chunks/chunked_array.h"
#include "ingest/codec/byte_codec.h"

namespace kiln {

/// Decodes `packed` to voxels of `number.voxelType()` in the machine's byte order. shape: `voxels` has the voxels of
/// the chunk. thread: any. throws: Error kFormat at `place` for damaged data and for values that do not fit into a
/// voxel.
void decodeVoxels(const CodecChain& codecs, const StoredNumber& number, std::span<const std::byte> packed,
                  std::span<std::byte> voxels, const ChunkPlace& place);
/// Memory of decoding `count` voxels: packed, between codecs, as stored numbers, and as voxels. unit: bytes.
std::uint64_t decodeVoxelsBytes(const CodecChain& codecs, const StoredNumber& number, std::uint64_t count);

/// Returns a whole chunk of `layout` with the voxels of `part`, whose lengths are `n`, at its first corner; all other
/// voxels are the fill value.
BlockCache::Bytes wholeChunk(const ChunkLayout& layout, std::span<const std::byte> part, const AxisNumbers& n);

}  // namespace kiln
