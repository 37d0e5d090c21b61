// Frames of Blosc with Zstandard and byte planes inside.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kiln {

/// Returns the frame of `numbers`, each of `number_bytes` bytes. Equal arguments give equal bytes. thread: any.
/// requires: whole numbers, at least one and below 2 GiB. throws: std::bad_alloc.
std::vector<std::byte> packBlosc(std::span<const std::byte> numbers, std::size_t number_bytes);

/// Upper bound of the frame of `bytes` bytes. unit: bytes.
std::uint64_t packedBloscBytes(std::uint64_t bytes);

/// Memory of a thread that packs frames of `bytes` bytes, with the result. unit: bytes.
std::uint64_t bloscWorkBytes(std::uint64_t bytes);

/// The name of the codec's level in metadata.
inline constexpr int kBloscLevel = 3;

}  // namespace kiln
