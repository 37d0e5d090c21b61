#include "base/hash32.h"

#include <xxhash.h>

namespace kiln {

std::uint32_t hash32Of(std::span<const std::byte> data, std::uint32_t seed) {
  return XXH32(data.data(), data.size(), seed);
}

}  // namespace kiln
