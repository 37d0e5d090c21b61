// Identity and ownership of files. Device and inode identify a file, whatever names or links lead to it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kiln {

/// True if `path` itself, not the target of a link of this name, is the open file. throws: Error kIo.
bool leadsTo(const std::filesystem::path& path, int open_file);

/// Removes a file that this process has locked, unless the name now leads to another file.
void removeIfStill(const std::filesystem::path& path, int open_file) noexcept;

/// Locks an open file (flock) for this process alone, without waiting. Returns false and sets errno on failure:
/// EWOULDBLOCK if another process holds the lock, another number on a disk without locks.
bool lockAtOnce(int open_file);

/// True if an open file is a regular file of this user with a single name, so writing changes no other user's bytes.
bool isOwnFile(int open_file);

/// Identifies a version of a file: its place on a disk and the time of the last write (mtime). A later file at the same
/// place has a later time.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0;
  std::int64_t written_ns = 0;
  bool operator==(const FileIdentity&) const = default;
};

/// Returns the identity of a file, for a link of its target; nothing if there is no file. throws: Error kIo.
std::optional<FileIdentity> identityOf(const std::filesystem::path& path);

/// Checks that a directory belongs to this user or the administrator, and is no link. throws: Error kIo.
void requireOwner(const std::filesystem::path& directory);

/// Checks the owner (requireOwner), and that the directory is not writable by every user. throws: Error kIo.
void requireOwnDirectory(const std::filesystem::path& directory);

/// True if writing through a link is safe: this user or the administrator made the link. Linux has a similar rule
/// (fs.protected_symlinks) for links that the system follows.
bool mayBeFollowed(const std::filesystem::path& link);

}  // namespace kiln
