// A bzip2 stream inside a file, read forwards: a form of compressed NRRD data.
#pragma once

#include <memory>

#include "ingest/bytes/packed_stream.h"

namespace kiln {

/// Consecutive streams are one, as for bzip2(1).
class Bzip2Stream : public PackedStream {
 public:
  /// throws: Error kIo if the library has no memory.
  Bzip2Stream(File file, std::uint64_t offset_bytes);
  ~Bzip2Stream() override;

  /// The input buffer and bzlib's state at its largest block (bzip2's manual, §2.5: 3.7 MB).
  std::uint64_t heldBytes() const override { return 4 << 20; }

 private:
  struct Decoder;
  Step decode(std::span<const std::byte> packed, std::span<std::byte> out) override;
  bool beginAgain(std::byte first) override;
  void begin();

  std::unique_ptr<Decoder> decoder_;
};

}  // namespace kiln
