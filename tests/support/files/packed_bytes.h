// Bytes packed by the compressors' own libraries, and checksums computed bit by bit, for the tests of codecs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kiln::test {

std::string bzipped(std::string_view bytes);
std::string xzStream(std::string_view bytes);
/// A frame with or without its content size.
std::string zstdFrame(std::string_view bytes, bool sized = true);
/// An LZ4 block alone.
std::string lz4Block(std::string_view bytes);
/// An LZ4 block behind its decoded size in four bytes, as numcodecs writes it.
std::string sizedLz4(std::string_view bytes);
/// Blocks of LZ4BlockOutputStream, each of `block_bytes` bytes, as N5 has them.
std::string lz4Stream(std::string_view bytes, std::size_t block_bytes);

struct BloscSpec {
  const char* codec = "lz4";
  /// 0 none, 1 bytes, 2 bits.
  int shuffle = 1;
  std::size_t number_bytes = 2;
  /// 0 for the library's choice.
  std::size_t block_bytes = 0;
  /// 0 stores the bytes as they are.
  int level = 5;
};
std::string bloscFrame(std::string_view bytes, const BloscSpec& spec);

/// Byte planes; the bytes behind the last whole number stay last.
std::string shuffled(std::string_view bytes, std::size_t number_bytes);

std::uint32_t crc32cOf(std::string_view bytes);
/// The bytes and their CRC-32C.
std::string withCrc32c(std::string_view bytes);

/// A number of `bytes` bytes, the lowest first.
std::string littleEndian(std::uint64_t number, std::size_t bytes);
/// A number of `bytes` bytes, the highest first.
std::string bigEndian(std::uint64_t number, std::size_t bytes);

/// `count` bytes: noise, or numbers that grow slowly and compress well.
std::string noiseBytes(std::size_t count, std::uint64_t seed);
std::string smoothBytes(std::size_t count);

}  // namespace kiln::test
