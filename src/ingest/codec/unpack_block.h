// Separately compressed blocks, each decoded by one call.
#pragma once

#include <cstddef>
#include <span>

namespace kiln {

enum class BlockCodec { kNone, kZlib, kLz4, kLzma };

/// Decodes `packed` into `out`. Returns false if the data are damaged, or decode to another size than `out`.
/// cost: LZMA takes up to 64 MiB for its dictionary; a larger one is refused.
bool unpackBlock(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out);

}  // namespace kiln
