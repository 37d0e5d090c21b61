// A file of any size that is written in pieces under a temporary name, and gets its own name when whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/file/file.h"
#include "base/file/temporary_file.h"

namespace kiln {

class PendingFile {
 public:
  /// Takes a temporary name beside `path`. If `path` is a link, its target is replaced. throws: Error kIo, kNoSpace.
  PendingFile(const std::filesystem::path& path, FileSystem& disk);

  /// throws: Error kNoSpace, kIo, naming `path`.
  void writeAt(std::uint64_t offset, std::span<const std::byte> data);
  void append(std::span<const std::byte> data) { writeAt(size_, data); }
  /// The end of the last byte written. unit: bytes.
  std::uint64_t size() const { return size_; }
  /// Brings the file onto the disk.
  void sync();
  /// Gives the file its name, after `sync`. Without this call the destructor removes the file.
  void publish();

 private:
  std::filesystem::path place_;
  FileSystem& disk_;
  TemporaryFile temporary_;
  File file_;
  std::uint64_t size_ = 0;
};

}  // namespace kiln
