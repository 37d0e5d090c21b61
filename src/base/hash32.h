// The XXH32 hash, a checksum in files of other programs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace kiln {

std::uint32_t hash32Of(std::span<const std::byte> data, std::uint32_t seed);

}  // namespace kiln
