// The decoders write no byte beyond `out`, whatever the packed bytes are: each gets the size of `out` as its limit.
#include "ingest/bytes/unpack_block.h"

#include <lz4.h>
#include <lzma.h>
#include <zlib.h>

#include <algorithm>
#include <climits>
#include <cstdint>

namespace kiln {
namespace {

bool unpackZlib(std::span<const std::byte> packed, std::span<std::byte> out) {
  uLongf size = out.size();
  const int verdict = uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                                 reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  return verdict == Z_OK && size == out.size();
}

bool unpackLz4(std::span<const std::byte> packed, std::span<std::byte> out) {
  if (packed.size() > INT_MAX || out.size() > INT_MAX) return false;
  const int size =
      LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(out.data()),
                          static_cast<int>(packed.size()), static_cast<int>(out.size()));
  return size >= 0 && static_cast<std::size_t>(size) == out.size();
}

bool unpackLzma(std::span<const std::byte> packed, std::span<std::byte> out) {
  std::uint64_t most_bytes = 64 << 20;
  std::size_t in_at = 0, out_at = 0;
  const lzma_ret verdict =
      lzma_stream_buffer_decode(&most_bytes, 0, nullptr, reinterpret_cast<const std::uint8_t*>(packed.data()), &in_at,
                                packed.size(), reinterpret_cast<std::uint8_t*>(out.data()), &out_at, out.size());
  return verdict == LZMA_OK && out_at == out.size();
}

}  // namespace

bool unpackBlock(BlockCodec codec, std::span<const std::byte> packed, std::span<std::byte> out) {
  switch (codec) {
    case BlockCodec::kNone:
      break;
    case BlockCodec::kZlib:
      return unpackZlib(packed, out);
    case BlockCodec::kLz4:
      return unpackLz4(packed, out);
    case BlockCodec::kLzma:
      return unpackLzma(packed, out);
  }
  if (packed.size() != out.size()) return false;
  std::copy(packed.begin(), packed.end(), out.begin());
  return true;
}

}  // namespace kiln
