#include <lzma.h>

#include <cstdint>
#include <new>

#include "ingest/codec/block_codecs.h"

namespace kiln {

std::optional<std::size_t> unpackLzma(std::span<const std::byte> packed, std::span<std::byte> out) {
  std::uint64_t most_bytes = kMostLzmaBytes;
  std::size_t read = 0, written = 0;
  const lzma_ret code =
      lzma_stream_buffer_decode(&most_bytes, 0, nullptr, reinterpret_cast<const std::uint8_t*>(packed.data()), &read,
                                packed.size(), reinterpret_cast<std::uint8_t*>(out.data()), &written, out.size());
  if (code == LZMA_MEM_ERROR) throw std::bad_alloc();
  if (code != LZMA_OK || read != packed.size()) return std::nullopt;
  return written;
}

}  // namespace kiln
