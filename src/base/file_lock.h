// Work that one process at a time may do, on one machine or on several that share a disk.
#pragma once

#include <filesystem>
#include <functional>

namespace kiln {

/// Held from when it is made until it goes: a file that is locked meanwhile and removed at the end, also if the process
/// is killed, when the next holder removes it. Where the disk knows no locks, or the file cannot be made, it holds
/// nothing: whatever cannot be written there says so itself.
class FileLock {
 public:
  /// Waits for whoever holds it, and asks `waiting` ten times a second, which may throw.
  FileLock(std::filesystem::path path, const std::function<void()>& waiting);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  // Whether there is nothing to wait for: it is held, or cannot be.
  bool taken();
  bool isStillThere() const;
  const std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace kiln
