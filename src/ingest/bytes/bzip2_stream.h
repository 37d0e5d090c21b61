// A bzip2 stream inside a file, read forwards: a form of compressed NRRD data.
#pragma once

#include <memory>

#include "base/file.h"
#include "ingest/bytes/byte_stream.h"

namespace kiln {

/// Decompresses from `offset_bytes` of `file` to its end. Consecutive streams are one, as for bzip2(1).
class Bzip2Stream : public ByteStream {
 public:
  /// throws: Error kIo if the library has no memory.
  Bzip2Stream(File file, std::uint64_t offset_bytes);
  ~Bzip2Stream() override;

  void read(std::span<std::byte> out, const std::string& where) override;
  std::vector<std::string> finish() override;
  /// The input buffer and bzlib's state at its largest block (bzip2's manual, §2.5: 3.7 MB).
  std::uint64_t heldBytes() const override { return 4 << 20; }

 private:
  struct Decoder;
  std::size_t step(std::span<std::byte> out, const std::string& where);
  bool refill();
  void begin();
  [[noreturn]] void fail(const std::string& where, const std::string& what) const;

  File file_;
  std::uint64_t next_offset_bytes_;
  std::vector<std::byte> input_;
  std::unique_ptr<Decoder> decoder_;
  bool ended_ = false;
};

}  // namespace kiln
