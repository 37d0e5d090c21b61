// A file that is written piece by piece, at any place, and that gets its name when it is whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/file.h"

namespace kiln {

/// Holds what is written in a file without a name beside `path`. cost: disk space for the file twice while it is
/// published; no memory.
class ScratchOutput {
 public:
  /// throws: Error kNoSpace, kIo.
  ScratchOutput(std::filesystem::path path, FileSystem& disk);
  /// throws: Error kNoSpace, kIo.
  void write(std::uint64_t offset, std::span<const std::byte> data);
  std::uint64_t size() const { return size_; }
  /// Makes `path` this file: a reader sees the old file or the new one. throws: Error kNoSpace, kIo.
  void publish();

 private:
  const std::filesystem::path path_;
  FileSystem& disk_;
  const File scratch_;
  std::uint64_t size_ = 0;
};

}  // namespace kiln
