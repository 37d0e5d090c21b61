// The order of bytes and bits that compressors of numbers use: byte planes (shuffle) and bit planes (bitshuffle).
// Source: the filters of HDF5 and Blosc; Masui et al. 2015 (bitshuffle).
#pragma once

#include <cstddef>
#include <span>

namespace kiln {

/// Joins byte planes to numbers of `size` bytes; bytes behind the last whole number are copied. requires: equal
/// lengths, no overlap.
void joinBytePlanes(std::span<const std::byte> planes, std::size_t size, std::byte* out) noexcept;

/// Splits numbers of `size` bytes into byte planes, the reverse of joinBytePlanes. requires: as joinBytePlanes.
void splitBytePlanes(std::span<const std::byte> numbers, std::size_t size, std::byte* planes) noexcept;

/// Joins bit planes to numbers of `size` bytes. Plane 8·b + k has bit k of byte b of each number, eight numbers a byte,
/// the first in the lowest bit. requires: `planes` has a multiple of 8 numbers, and does not overlap `out`.
void joinBitPlanes(std::span<const std::byte> planes, std::size_t size, std::byte* out) noexcept;

}  // namespace kiln
