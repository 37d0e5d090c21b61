// A lock for work that only one process at a time may do, on one machine or on several machines that share a disk.
//
// Method. A lock file holds process and machine of the holder. The holder locks the file with flock during the work and
// removes the file at the end.
// Invariant. The kernel drops the lock when the process ends, so no lock is stale; the next holder removes a leftover
// file.
// On NFS, flock locks on the server, for which the file must be open for writing. After locking, the client checks on
// the server that the file still exists, so two machines exclude each other.
// Limit. A disk without locks (some Lustre and FUSE mounts) excludes no process; `diskHasLocks` is then false.
#pragma once

#include <filesystem>
#include <functional>

namespace kiln {

class FileLock {
 public:
  /// Takes the lock. While another process holds the lock, calls `waiting` ten times a second; `waiting` may throw.
  FileLock(std::filesystem::path path, const std::function<void()>& waiting);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

  /// False on a disk without locks: this object then excludes no process.
  bool diskHasLocks() const { return disk_has_locks_; }

 private:
  enum class Attempt { kDone, kBusy, kAgain };
  Attempt attempt();
  void sign() const;
  const std::filesystem::path path_;
  int file_ = -1;  // -1 if no lock is held: the disk has no locks, or the file cannot be made
  bool disk_has_locks_ = true;
};

/// The lock file of an output: `OUT.lock` beside the output, or kLockInside in the directory OUT if no file can be made
/// beside it.
std::filesystem::path lockOf(const std::filesystem::path& output);
/// Name of the lock file inside an output directory.
inline constexpr const char* kLockInside = "lock.tmp";

/// Returns a `waiting` function for FileLock that throws at once. throws, when called: Error kExists, naming `output`,
/// the lock and, if the lock file holds it, the holder.
std::function<void()> refusalOf(const std::filesystem::path& output);

}  // namespace kiln
