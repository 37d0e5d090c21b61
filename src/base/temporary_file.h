// A file that gets its name only when it is whole. It lies beside its destination under a slot name:
// `NAME.kiln-001.tmp`, `NAME.kiln-002.tmp`, …. A process owns a slot while it holds a lock (flock) on the slot's file.
// Invariant: two processes never write into one slot, and a slot that a killed process left is used again by the next
// one, so that leftovers do not accumulate. A slot is created exclusively: nobody's file or link is written through.
#pragma once

#include <filesystem>

#include "base/error.h"

namespace kiln {

class TemporaryFile {
 public:
  /// Takes the first slot beside `path` that no running process owns and makes it an empty file. requires: `path` is no
  /// link (behindLinks). throws: Error kIo, kNoSpace, kNotFound.
  explicit TemporaryFile(const std::filesystem::path& path);
  /// Removes the file, unless it was renamed.
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// The error of a failed write, with the name of the destination in place of the temporary name.
  Error named(const Error& error) const;
  /// Bytes that the name of a slot is longer than the name of its destination.
  static constexpr int kLongerBytes = 13;

 private:
  bool claim();
  const std::filesystem::path destination_;
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace kiln
