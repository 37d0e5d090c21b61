// Separately compressed blocks, each decoded by one call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace kiln {

enum class BlockCodec { kNone, kZlib, kLz4, kLzma };

/// Decodes `packed` into `out`. Returns false if the data are damaged, or decode to another size than `out`.
/// requires: a codec other than kNone.
/// cost: unpackMemory.
bool unpackBlock(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out);
/// Returns the memory that a decoder takes beside both blocks: LZMA's dictionary, of which a larger one is refused.
/// unit: bytes.
std::uint64_t unpackMemory(BlockCodec codec);

}  // namespace kiln
