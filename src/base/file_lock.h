// Work that one process at a time may do, on one machine or on several that share a disk.
//
// Method: a file with the holder's process and machine, locked with flock while the work goes on and removed at its
// end. The kernel drops the lock when a process ends, however it ends, so that no lock is stale; the next holder
// removes the file that a killed one left. On NFS, flock is a lock of the server (the file is open for writing, as that
// needs), and after locking, the client asks the server whether the file still exists: two machines exclude each other.
// A disk without locks (some Lustre and FUSE mounts) excludes nobody; `diskHasLocks` is then false.
#pragma once

#include <filesystem>
#include <functional>

namespace kiln {

class FileLock {
 public:
  /// Takes the lock. While another process holds it, calls `waiting` ten times a second, which may throw.
  FileLock(std::filesystem::path path, const std::function<void()>& waiting);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// False where the disk has no locks, so that this object excludes nobody.
  bool diskHasLocks() const { return disk_has_locks_; }

 private:
  enum class Attempt { kDone, kBusy, kAgain };
  Attempt attempt();
  void sign() const;
  const std::filesystem::path path_;
  int file_ = -1;  // -1 where nothing is held: no locks, or the file cannot be made
  bool disk_has_locks_ = true;
};

/// The lock on an output: `OUT.lock` beside it, or a file in the directory OUT where nothing can be made beside it.
std::filesystem::path lockOf(const std::filesystem::path& output);
/// The name of the second kind.
inline constexpr const char* kLockInside = "lock.tmp";

/// A function for FileLock that refuses to wait. throws, when called: Error kExists, naming `output`, the lock and, if
/// the lock says so, its holder.
std::function<void()> refusalOf(const std::filesystem::path& output);

}  // namespace kiln
