// A gzip or zlib stream inside a file, read forwards: the form of compressed NRRD, MetaImage and NIfTI data.
#pragma once

#include <memory>

#include "ingest/bytes/packed_stream.h"

namespace kiln {

enum class StreamWrapper { kGzip, kZlib, kNone };

/// Consecutive members of a gzip stream are one stream (RFC 1952 §2.2). Zero bytes after the last member are padding,
/// as for gzip(1). cost: kHeldBytes, whatever the length.
class InflateStream : public PackedStream {
 public:
  /// The input buffer and the state of zlib (zlib.h: 44 KiB). unit: bytes.
  static constexpr std::uint64_t kHeldBytes = kInputBytes + (64 << 10);

  /// throws: Error kIo if zlib has no memory.
  InflateStream(File file, std::uint64_t offset_bytes, StreamWrapper wrapper);
  ~InflateStream() override;

  std::uint64_t heldBytes() const override { return kHeldBytes; }

 private:
  struct Decoder;
  Step decode(std::span<const std::byte> packed, std::span<std::byte> out) override;
  bool beginAgain(std::byte first) override;
  bool mayBePadded() const override { return wrapper_ == StreamWrapper::kGzip; }

  StreamWrapper wrapper_;
  std::unique_ptr<Decoder> decoder_;
};

}  // namespace kiln
