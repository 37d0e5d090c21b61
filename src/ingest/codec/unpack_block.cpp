#include "ingest/codec/unpack_block.h"

#include <algorithm>
#include <optional>

#include "ingest/codec/block_codecs.h"

namespace kiln {
namespace {

std::optional<std::size_t> unpackKept(std::span<const std::byte> kept, std::span<std::byte> out) {
  if (kept.size() != out.size()) return std::nullopt;
  std::copy(kept.begin(), kept.end(), out.begin());
  return kept.size();
}

std::optional<std::size_t> unpackBy(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out) {
  switch (codec) {
    case BlockCodec::kNone:
      break;
    case BlockCodec::kZlib:
      return unpackDeflate(packed, DeflateWrapper::kZlib, out);
    case BlockCodec::kLz4:
      return unpackLz4(packed, out);
    case BlockCodec::kLzma:
      return unpackLzma(packed, out);
  }
  return unpackKept(packed, out);
}

}  // namespace

bool unpackBlock(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out) {
  return unpackBy(codec, packed, out) == out.size();
}

}  // namespace kiln
