// A file that gets its final name only when complete.
// Method. Until then the file lies beside its destination under a slot name: `NAME.kiln-001.tmp`, `NAME.kiln-002.tmp`,
// …. A process owns a slot while it holds a lock (flock) on the slot's file.
// Invariant. Two processes never write into one slot. The next process with the same destination removes the files of
// killed processes. A slot is created exclusively: no other file or link is written through.
#pragma once

#include <filesystem>

#include "base/error.h"

namespace kiln {

class TemporaryFile {
 public:
  /// Takes the first slot beside `path` that no running process owns, and empties its file. requires: `path` is no link
  /// (behindLinks). throws: Error kIo, kNoSpace, kNotFound.
  explicit TemporaryFile(const std::filesystem::path& path);
  /// Removes the file, unless it was renamed.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Removes files that killed processes left in slots beside `path`. Files of running processes and of other users
  /// stay, and so do all files on a disk without locks. requires: as the constructor.
  static void removeLeftovers(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  /// Returns the error of a failed write with the destination's name in place of the temporary name.
  Error named(const Error& error) const;
  /// Length of a slot name minus length of the destination's name. unit: bytes.
  static constexpr int kLongerBytes = 13;

 private:
  static void removeLeftovers(const std::filesystem::path& path, int first_slot);
  bool claim();
  const std::filesystem::path destination_;
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace kiln
