// Codecs of chunked formats (Zarr, N5, HDF5). The bytes of a chunk pass a chain of codecs: compressors, orders of
// bytes, checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kiln {

/// The place of a chunk, for errors.
struct ChunkPlace {
  std::filesystem::path file;
  /// "chunk 3 of the shard"; may be empty.
  std::string where;
  /// throws: Error kFormat, always.
  [[noreturn]] void fail(const std::string& what) const;
};

class ByteCodec {
 public:
  virtual ~ByteCodec() = default;
  /// Decodes all of `packed` to the front of `out` and returns the number of bytes. thread: any.
  /// throws: Error kFormat if `packed` is damaged or holds more bytes than `out` has room for.
  virtual std::size_t decode(std::span<const std::byte> packed, std::span<std::byte> out,
                             const ChunkPlace& place) const = 0;
  /// The room that the packed form of `bytes` bytes takes at most. unit: bytes.
  virtual std::uint64_t packedBytes(std::uint64_t bytes) const = 0;
  /// Memory of `decode` for `bytes` bytes, beside its arguments. unit: bytes.
  virtual std::uint64_t scratchBytes(std::uint64_t /*bytes*/) const { return 0; }
};

/// CRC-32C (Castagnoli).
std::uint32_t crc32cOf(std::span<const std::byte> data);

std::unique_ptr<ByteCodec> gzipCodec();
std::unique_ptr<ByteCodec> zlibCodec();
std::unique_ptr<ByteCodec> zstdCodec();
std::unique_ptr<ByteCodec> bzip2Codec();
/// One stream of xz.
std::unique_ptr<ByteCodec> xzCodec();
/// An LZ4 block behind four bytes of decoded size, the form of numcodecs.
std::unique_ptr<ByteCodec> lz4Codec();
/// Blocks with headers, as lz4-java's LZ4BlockOutputStream writes them for N5.
std::unique_ptr<ByteCodec> lz4StreamCodec();
std::unique_ptr<ByteCodec> bloscCodec();
/// Byte planes of numbers of `number_bytes` bytes. requires: number_bytes > 0.
std::unique_ptr<ByteCodec> shuffleCodec(std::size_t number_bytes);
/// CRC-32C (Castagnoli) in the four bytes behind the data, little-endian.
std::unique_ptr<ByteCodec> crc32cCodec();

/// The codecs of an array, in the order of encoding.
class CodecChain {
 public:
  void add(std::unique_ptr<ByteCodec> codec) { codecs_.push_back(std::move(codec)); }
  bool empty() const { return codecs_.empty(); }
  /// Decodes a chunk to exactly `out.size()` bytes. thread: any. throws: Error kFormat at `place`.
  void decode(std::span<const std::byte> packed, std::span<std::byte> out, const ChunkPlace& place) const;
  /// Size of the packed form of `bytes` bytes at most; larger chunks are damaged. unit: bytes.
  std::uint64_t packedBytes(std::uint64_t bytes) const;
  /// Memory of `decode` beside its arguments. unit: bytes.
  std::uint64_t scratchBytes(std::uint64_t bytes) const;

 private:
  std::vector<std::unique_ptr<ByteCodec>> codecs_;
};

}  // namespace kiln
