// Frames of Blosc 1: blocks of byte or bit planes, each compressed by BloscLZ, LZ4, Zstandard or zlib.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kiln {

/// Decompresses a frame to the front of `out`. Returns a text that names the fault, empty if there is none; `written`
/// is the number of bytes. Snappy is refused by name. thread: any. throws: std::bad_alloc.
std::string unpackBlosc(std::span<const std::byte> frame, std::span<std::byte> out, std::size_t& written);

}  // namespace kiln
