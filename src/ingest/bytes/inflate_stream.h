// A gzip or zlib stream inside a file, read forwards: the form of compressed NRRD, MetaImage and NIfTI data.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/file.h"
#include "ingest/bytes/byte_stream.h"

namespace kiln {

enum class StreamWrapper { kGzip, kZlib, kNone };

/// Decompresses from `offset_bytes` of `file` to its end. Consecutive members of a gzip stream are one stream (RFC 1952
/// §2.2). Zero bytes after the last member are padding, as for gzip(1).
/// cost: kHeldBytes, whatever the length.
class InflateStream : public ByteStream {
 public:
  /// The input buffer and the state of zlib (zlib.h: 44 KiB). unit: bytes.
  static constexpr std::uint64_t kHeldBytes = 320 << 10;

  /// throws: Error kIo if zlib has no memory.
  InflateStream(File file, std::uint64_t offset_bytes, StreamWrapper wrapper);
  ~InflateStream() override;

  /// Returns the number of bytes written to `out`: its size, or fewer if the stream ended with a verified checksum.
  /// throws: Error kFormat, with the byte of the file and `where` ("slice 3"), for a cut or damaged stream; kIo.
  std::size_t readSome(std::span<std::byte> out, const std::string& where);
  void read(std::span<std::byte> out, const std::string& where) override;
  std::vector<std::string> finish() override;
  std::uint64_t heldBytes() const override { return kHeldBytes; }

 private:
  struct Decoder;
  std::size_t step(std::span<std::byte> out, const std::string& where);
  bool refill();
  void endMember();
  [[noreturn]] void fail(const std::string& where, const std::string& what) const;

  File file_;
  std::uint64_t next_offset_bytes_;
  StreamWrapper wrapper_;
  std::vector<std::byte> input_;
  std::unique_ptr<Decoder> decoder_;
  bool ended_ = false;
};

}  // namespace kiln
