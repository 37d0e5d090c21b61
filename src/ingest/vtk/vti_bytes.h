// The bytes of one array of a VTK image file, at any place: raw, in base64, in compressed blocks, or both.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/file/file.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/codec/unpack_block.h"

namespace kiln {

/// A part of a file that holds bytes as they are or as base64 without spaces.
class VtiText {
 public:
  VtiText(File file, std::uint64_t begin, bool base64) : file_(std::move(file)), begin_(begin), base64_(base64) {}
  /// Fills `out` with the bytes from `offset` on. throws: Error kFormat for other characters, or if the file ends too
  /// early; kIo. thread: any.
  void read(std::uint64_t offset, std::span<std::byte> out) const;
  /// Returns the place behind `bytes` bytes that were encoded together. unit: bytes of the file.
  std::uint64_t after(std::uint64_t bytes) const;
  void moveTo(std::uint64_t begin) { begin_ = begin; }
  std::uint64_t begin() const { return begin_; }
  const File& file() const { return file_; }

 private:
  File file_;
  std::uint64_t begin_;
  bool base64_;
};

/// Encoding of the lengths in front of an array.
struct VtiLengths {
  bool wide = false, big_endian = false;
  std::size_t size() const { return wide ? 8 : 4; }
};

class VtiArrayBytes {
 public:
  /// Reads and checks the lengths in front of the array. throws: Error kFormat if they contradict `bytes`, the size of
  /// the array, or the file; kBudget if the table of blocks is larger than `memory_bytes`; kIo.
  VtiArrayBytes(VtiText text, VtiLengths lengths, BlockCodec codec, std::uint64_t bytes, std::uint64_t memory_bytes);
  /// thread: any.
  void read(std::uint64_t offset, std::span<std::byte> out);

  /// The place of a raw array without compression in its file.
  std::uint64_t begin() const { return text_.begin() + length_bytes_; }
  std::uint64_t decodeBytes() const;
  std::uint64_t heldBytes() const { return ends_.size() * sizeof(std::uint64_t); }
  void setCache(std::uint64_t bytes) { cache_.setCapacity(bytes); }

 private:
  static constexpr std::uint64_t kChunkBytes = 1 << 17;
  void readLength(VtiLengths lengths);
  void readBlockTable(VtiLengths lengths, std::uint64_t memory_bytes);
  std::vector<std::uint64_t> numbers(VtiLengths lengths, std::uint64_t offset, std::uint64_t count) const;
  BlockCache::Bytes decode(std::uint64_t block) const;
  [[noreturn]] void fail(const std::string& what) const;

  VtiText text_;
  BlockCodec codec_;
  std::uint64_t bytes_;
  std::uint64_t length_bytes_ = 0;                    // in front of an array without compression
  std::uint64_t block_bytes_ = 0, packed_bytes_ = 0;  // of the largest block
  std::vector<std::uint64_t> ends_;                   // of the packed blocks, from the first block's begin on
  BlockCache cache_;
};

}  // namespace kiln
