#include <lz4.h>

#include <climits>

#include "ingest/codec/block_codecs.h"

namespace kiln {

std::optional<std::size_t> unpackLz4(std::span<const std::byte> packed, std::span<std::byte> out) {
  if (packed.size() > INT_MAX || out.size() > INT_MAX) return std::nullopt;
  const int written =
      LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(out.data()),
                          static_cast<int>(packed.size()), static_cast<int>(out.size()));
  if (written < 0) return std::nullopt;
  return static_cast<std::size_t>(written);
}

}  // namespace kiln
