// A compressed stream inside a file, read forwards. A derived class gives a library the bytes and returns its verdict.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "ingest/bytes/byte_stream.h"

namespace kiln {

class PackedStream : public ByteStream {
 public:
  /// Returns the number of bytes written to `out`: its size, or fewer if the stream ended with a verified checksum.
  /// throws: Error kFormat, with the byte of the file and `where` ("slice 3"), for a cut or damaged stream; kIo.
  std::size_t readSome(std::span<std::byte> out, const std::string& where);
  void read(std::span<std::byte> out, const std::string& where) override;
  std::vector<std::string> finish() override;

 protected:
  static constexpr std::size_t kInputBytes = 1 << 18;

  enum class Verdict { kGoesOn, kEnded, kDamaged, kNoMemory };
  struct Step {
    /// Bytes taken of the packed ones, and written. unit: bytes.
    std::size_t used = 0, made = 0;
    Verdict verdict = Verdict::kGoesOn;
    /// The library's words on damaged data; may be empty.
    std::string complaint;
  };

  /// Decompresses from `offset_bytes` of `file` to its end.
  PackedStream(File file, std::uint64_t offset_bytes)
      : file_(std::move(file)),
        next_offset_bytes_(offset_bytes),
        input_bytes_(inputBytesFor(file_.size(), offset_bytes)),
        input_(std::make_unique_for_overwrite<std::byte[]>(input_bytes_)) {}

  /// Decodes as much of `packed` as `out` has room for; `packed` is empty at the end of the file. The verdict is kEnded
  /// only if the library has verified the checksum.
  virtual Step decode(std::span<const std::byte> packed, std::span<std::byte> out) = 0;
  /// Prepares for another stream behind the ended one. Returns false if no stream begins with `first`.
  virtual bool beginAgain(std::byte first) = 0;
  /// True if zero bytes may follow the last stream.
  virtual bool mayBePadded() const { return false; }
  [[noreturn]] void failForMemory() const;

 private:
  std::size_t step(std::span<std::byte> out, const std::string& where);
  bool refill();
  void endStream();
  // A buffer for a short file is as long as the file.
  static std::size_t inputBytesFor(std::uint64_t file_bytes, std::uint64_t offset_bytes) {
    const std::uint64_t left = file_bytes > offset_bytes ? file_bytes - offset_bytes : 1;
    return static_cast<std::size_t>(std::min<std::uint64_t>(left, kInputBytes));
  }
  std::uint64_t offset() const { return next_offset_bytes_ - unread_.size(); }
  [[noreturn]] void fail(const std::string& where, const std::string& what) const;

  File file_;
  std::uint64_t next_offset_bytes_;
  std::size_t input_bytes_;
  std::unique_ptr<std::byte[]> input_;
  std::span<const std::byte> unread_;  // of `input_`
  bool ended_ = false;
};

}  // namespace kiln
