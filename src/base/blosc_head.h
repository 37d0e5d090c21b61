// The head of a frame of Blosc 1, for the readers and writers of frames.
// Source: README_CHUNK_FORMAT of c-blosc 1.21, and the rule of pieces ("splits") in its blosc.c.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kiln {

/// Little-endian. The place of each block follows, of 32 bits, then the blocks.
struct BloscHead {
  enum Flag : std::uint8_t { kBytePlanes = 1, kKept = 1 << 1, kBitPlanes = 1 << 2, kNotSplit = 1 << 4 };
  enum class Codec : std::uint8_t { kBloscLz, kLz4, kSnappy, kZlib, kZstd };

  /// The version of frames of Blosc 1.3 and later, and that of LZ4 and Zstandard in a frame.
  static constexpr std::uint8_t kVersion = 2, kCodecVersion = 1;
  /// Blosc compresses no fewer bytes, and splits a block into no shorter or more pieces.
  static constexpr std::size_t kFewestBytes = 128, kMostPieces = 16;
  static constexpr std::uint8_t flagOf(Codec codec) {
    return static_cast<std::uint8_t>(static_cast<unsigned>(codec) << 5);
  }

  std::uint8_t version, codec_version, flags, number_bytes;
  std::uint32_t bytes, block_bytes, frame_bytes;

  bool has(Flag flag) const { return (flags & flag) != 0; }
  Codec codec() const { return static_cast<Codec>(flags >> 5); }
  /// requires: block_bytes > 0.
  std::uint64_t blocks() const { return (std::uint64_t{bytes} + block_bytes - 1) / block_bytes; }
  /// The number of pieces, each compressed alone, of a block of `of_block` bytes. requires: number_bytes > 0.
  std::size_t pieces(std::size_t of_block) const {
    const bool split = !has(kNotSplit) && number_bytes <= kMostPieces && of_block == block_bytes &&
                       of_block / number_bytes >= kFewestBytes;
    return split ? number_bytes : 1;
  }
};
static_assert(sizeof(BloscHead) == 16);

}  // namespace kiln
