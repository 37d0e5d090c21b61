// A file that gets its final name only when complete.
// Method. Until then the file lies beside its destination under a slot name: `NAME.kiln-001.tmp`, `NAME.kiln-002.tmp`,
// …. A process owns a slot while it holds a lock (flock) on the slot's file.
// Invariant. Two processes never write into one slot. The slot of a killed process is used again by the next process,
// so leftovers do not accumulate. A slot is created exclusively: no other file or link is written through.
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

  const std::filesystem::path& path() const { return path_; }
  /// Returns the error of a failed write with the destination's name in place of the temporary name.
  Error named(const Error& error) const;
  /// Length of a slot name minus length of the destination's name. unit: bytes.
  static constexpr int kLongerBytes = 13;

 private:
  bool claim();
  const std::filesystem::path destination_;
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace kiln
