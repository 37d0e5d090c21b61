// Identity and ownership of files: device and inode decide, whatever names or links lead to a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace kiln {

/// True if `path` itself, and not the target of a link of that name, is the open file. throws: Error kIo.
bool leadsTo(const std::filesystem::path& path, int open_file);

/// Removes a file that this process has locked, unless the name has come to lead to another file.
void removeIfStill(const std::filesystem::path& path, int open_file) noexcept;

/// Locks an open file (flock) for this process alone. False, with errno, where that fails: EWOULDBLOCK where another
/// process holds it, another number on a disk without locks.
bool lockAtOnce(int open_file);

/// True if an open file is a regular file of this user with one name: writing changes nobody else's bytes.
bool isOwnFile(int open_file);

/// A file by its place on a disk and the time when it was written last (mtime), which a file of the same place that is
/// written later has not.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0;
  std::int64_t written_ns = 0;
  bool operator==(const FileIdentity&) const = default;
};

/// Of a link, its target's; nothing where there is no such file. throws: Error kIo.
std::optional<FileIdentity> identityOf(const std::filesystem::path& path);

/// The time of the last change of a file's bytes or attributes (ctime), of a link its target's. unit: ns since 1970.
/// throws: Error kIo or kNotFound.
std::int64_t changeTimeNs(const std::filesystem::path& path);

/// Checks that a directory belongs to this user or the administrator; refuses a link in its place. throws: Error kIo.
void requireOwner(const std::filesystem::path& directory);

/// Checks the owner (requireOwner), and that not everybody may write to the directory. throws: Error kIo.
void requireOwnDirectory(const std::filesystem::path& directory);

/// True if a link may be followed to write: this user or the administrator made it. Linux has a similar rule
/// (fs.protected_symlinks) for links that the system follows by itself.
bool mayBeFollowed(const std::filesystem::path& link);

}  // namespace kiln
