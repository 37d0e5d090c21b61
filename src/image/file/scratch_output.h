// An output file that is written in pieces at any offset and gets its name when complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/file/file.h"

namespace kiln {

/// Writes into a nameless file beside `path`. cost: disk space of twice the file while it is published; no memory.
class ScratchOutput {
 public:
  /// throws: Error kNoSpace, kIo.
  ScratchOutput(std::filesystem::path path, FileSystem& disk);
  /// throws: Error kNoSpace, kIo.
  void write(std::uint64_t offset, std::span<const std::byte> data);
  std::uint64_t size() const { return size_; }
  /// Copies the finished file to `path` atomically: a reader sees the old or the new file. throws: Error kNoSpace, kIo.
  void publish();

 private:
  const std::filesystem::path path_;
  FileSystem& disk_;
  const File scratch_;
  std::uint64_t size_ = 0;
};

}  // namespace kiln
