// Voxels that are written as text: decimal numbers, shares of 255, or the hexadecimal digits of their bytes.
#pragma once

#include "base/file/file.h"
#include "grid/voxel_type.h"
#include "ingest/bytes/byte_stream.h"

namespace kiln {

/// Reads the characters of a file forwards, one buffer at a time.
class TextStream : public ByteStream {
 public:
  TextStream(File file, std::uint64_t offset_bytes) : file_(std::move(file)), offset_bytes_(offset_bytes) {}
  std::vector<std::string> finish() override;
  std::uint64_t heldBytes() const override { return kBufferBytes; }

 protected:
  /// Returns the next character without taking it, or -1 at the end of the file. throws: Error kIo.
  int peek();
  void take() { ++at_; }
  /// Passes over spaces, line ends and commas.
  void skipBlanks();
  /// Throws an Error kFormat at the next character.
  [[noreturn]] void fail(const std::string& where, const std::string& what) const;
  const File& file() const { return file_; }

 private:
  static constexpr std::size_t kBufferBytes = 1 << 16;

  File file_;
  std::uint64_t offset_bytes_;  // of the buffer's first byte
  std::vector<std::byte> buffer_;
  std::size_t at_ = 0;
};

/// Decimal numbers, separated by blanks or commas, as values of `type` in the machine's byte order.
/// requires: reads of whole values.
class DecimalStream : public TextStream {
 public:
  DecimalStream(File file, std::uint64_t offset_bytes, VoxelType type)
      : TextStream(std::move(file), offset_bytes), type_(type) {}
  void read(std::span<std::byte> out, const std::string& where) override;
  std::vector<std::string> finish() override;

 protected:
  /// Returns the next number, as text. throws: Error kFormat at the end of the numbers.
  std::string_view word(const std::string& where);

 private:
  VoxelType type_;
  std::string word_;
};

/// Decimal numbers from 0 to 1, as shares of the bytes' largest value, 255.
class ShareStream final : public DecimalStream {
 public:
  ShareStream(File file, std::uint64_t offset_bytes) : DecimalStream(std::move(file), offset_bytes, VoxelType::u8) {}
  void read(std::span<std::byte> out, const std::string& where) override;
};

/// Two hexadecimal digits a byte, in the file's byte order.
class HexStream : public TextStream {
 public:
  using TextStream::TextStream;
  void read(std::span<std::byte> out, const std::string& where) override;
};

}  // namespace kiln
