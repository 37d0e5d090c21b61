#include "base/file/same_file.h"

#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "base/error.h"
#include "base/file/file_stamp.h"
#include "base/uninterrupted.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

bool isTrusted(uid_t owner) { return owner == ::geteuid() || owner == 0; }

struct stat directoryStatus(const fs::path& directory) {
  struct stat status {};
  if (::lstat(directory.c_str(), &status) != 0) throw systemError(errno, directory, "reading the directory's owner");
  if (!S_ISDIR(status.st_mode)) throw Error(ErrorCode::kIo, directory, "", "is no directory; name another output");
  if (!isTrusted(status.st_uid))
    throw Error(ErrorCode::kIo, directory, "",
                "belongs to another user, who could change the output; name another output");
  return status;
}

}  // namespace

bool leadsTo(const fs::path& path, int open_file) {
  struct stat open, named;
  if (::fstat(open_file, &open) != 0) throw systemError(errno, path, "looking at the file");
  if (open.st_nlink == 0) return false;
  if (::lstat(path.c_str(), &named) == 0) return open.st_dev == named.st_dev && open.st_ino == named.st_ino;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  throw systemError(errno, path, "looking at the file");
}

void removeIfStill(const fs::path& path, int open_file) noexcept {
  struct stat open, named;
  const auto known = [&] { return ::fstat(open_file, &open) == 0 && ::lstat(path.c_str(), &named) == 0; };
  // A failed call is repeated once. If the name leads to no file, the name is left alone: another process may use it
  // for its own file before an unlink.
  if (!known() && !known()) return;
  if (open.st_dev != named.st_dev || open.st_ino != named.st_ino) return;
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) ::unlink(path.c_str());
}

bool lockAtOnce(int open_file) {
  return uninterrupted([&] { return ::flock(open_file, LOCK_EX | LOCK_NB); }) == 0;
}

bool isOwnFile(int open_file) {
  struct stat status;
  return ::fstat(open_file, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 1 &&
         status.st_uid == ::geteuid();
}

std::optional<FileIdentity> identityOf(const fs::path& path) {
  struct stat status;
  if (uninterrupted([&] { return ::stat(path.c_str(), &status); }) == 0)
    return FileIdentity{status.st_dev, status.st_ino, nanosecondsOf(status.st_mtim)};
  if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
  throw systemError(errno, path, "looking at the file");
}

void requireOwnDirectory(const fs::path& directory) {
  if ((directoryStatus(directory).st_mode & S_IWOTH) != 0)
    throw Error(ErrorCode::kIo, directory, "",
                "is writable by every user, who could change the output; name a new directory inside it, or chmod o-w");
}

void requireOwner(const fs::path& directory) { directoryStatus(directory); }

bool mayBeFollowed(const fs::path& link) {
  struct stat status;
  return ::lstat(link.c_str(), &status) != 0 || isTrusted(status.st_uid);
}

}  // namespace kiln
