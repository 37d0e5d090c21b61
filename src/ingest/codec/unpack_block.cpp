#include "ingest/codec/unpack_block.h"

#include <cassert>

#include "ingest/codec/block_codecs.h"

namespace kiln {

bool unpackBlock(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out) {
  switch (codec) {
    case BlockCodec::kZlib:
      return unpackDeflate(packed, DeflateWrapper::kZlib, out) == out.size();
    case BlockCodec::kLz4:
      return unpackLz4(packed, out) == out.size();
    case BlockCodec::kLzma:
      return unpackLzma(packed, out) == out.size();
    case BlockCodec::kNone:
      break;
  }
  assert(false);
  return false;
}

std::uint64_t unpackMemory(BlockCodec codec) { return codec == BlockCodec::kLzma ? kMostLzmaBytes : 0; }

}  // namespace kiln
