// Decompressors of one block into memory of known size. Damaged input is reported, never written beyond the output.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kiln {

/// Each function decompresses all of `packed` to the front of `out` and returns the number of bytes written; nothing if
/// `packed` is damaged, is cut, or holds more bytes than `out` has room for. thread: any.
/// throws: std::bad_alloc if the library has no memory.
std::optional<std::size_t> unpackLz4(std::span<const std::byte> packed, std::span<std::byte> out);
/// A block of BloscLZ, which has no mark of its end.
std::optional<std::size_t> unpackBloscLz(std::span<const std::byte> packed, std::span<std::byte> out);
/// One or several Zstandard frames, with or without their content size.
std::optional<std::size_t> unpackZstd(std::span<const std::byte> packed, std::span<std::byte> out);
/// Memory of bzip2's largest block (bzip2's manual, section 2.5: 3.7 MB). unit: bytes.
inline constexpr std::uint64_t kBzip2Bytes = 4 << 20;
/// One stream of bzip2. requires: `packed` and `out` have less than 4 GiB. cost: kBzip2Bytes.
std::optional<std::size_t> unpackBzip2(std::span<const std::byte> packed, std::span<std::byte> out);
/// Memory of LZMA's dictionary at most. unit: bytes.
inline constexpr std::uint64_t kMostLzmaBytes = 64 << 20;
/// One stream of xz. cost: kMostLzmaBytes; a larger dictionary is refused.
std::optional<std::size_t> unpackLzma(std::span<const std::byte> packed, std::span<std::byte> out);

enum class DeflateWrapper { kGzip, kZlib };
/// A zlib stream (RFC 1950), or the members of a gzip stream (RFC 1952), with their checksums.
std::optional<std::size_t> unpackDeflate(std::span<const std::byte> packed, DeflateWrapper wrapper,
                                         std::span<std::byte> out);

}  // namespace kiln
