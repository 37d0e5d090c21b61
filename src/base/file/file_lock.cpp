#include "base/file/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/same_file.h"
#include "base/uninterrupted.h"
#include "base/work_count.h"

namespace kiln {
namespace fs = std::filesystem;
using namespace std::chrono_literals;
namespace {

// Start of the text in a lock file; a file with another start is no lock.
constexpr std::string_view kHolder = "kiln process ";
constexpr std::uint64_t kMostHolderBytes = 512;

// Returns the holder; empty if the lock file holds none.
std::string holderOf(const fs::path& lock) {
  try {
    const std::string text = readTextFile(lock, kMostHolderBytes);
    if (text.starts_with(kHolder)) return text.substr(0, text.find('\n'));
  } catch (const Error&) {
  }
  return "another process";
}

// Names the kind of a directory entry that is no regular file; null for a regular file or an unreadable entry.
const char* otherKindOf(const fs::path& path) {
  std::error_code unknown;
  switch (fs::symlink_status(path, unknown).type()) {
    case fs::file_type::symlink:
      return "a link";
    case fs::file_type::directory:
      return "a directory";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    default:
      return nullptr;
  }
}

// True for a lock file. An empty file is a lock whose holder has not signed yet.
bool isLock(int file, const fs::path& path) {
  std::array<char, kHolder.size()> begin;
  const ssize_t got = uninterrupted([&] { return ::pread(file, begin.data(), begin.size(), 0); });
  if (got < 0) throw systemError(errno, path, "reading the lock");
  return kHolder.starts_with(std::string_view(begin.data(), static_cast<std::size_t>(got)));
}

bool isEmpty(int file) {
  struct stat status;
  return ::fstat(file, &status) == 0 && status.st_size == 0;
}

}  // namespace

FileLock::FileLock(fs::path path, const std::function<void()>& waiting) : path_(std::move(path)) {
  for (Attempt last = attempt(); last != Attempt::kDone; last = attempt()) {
    if (last == Attempt::kAgain) continue;
    countWork();
    waiting();
    std::this_thread::sleep_for(100ms);
  }
  if (file_ >= 0) sign();
}

FileLock::Attempt FileLock::attempt() {
  constexpr int kFlags = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const auto open = [&](int flags) {
    return uninterrupted([&] { return ::open(path_.c_str(), flags | kFlags, 0666); });
  };
  file_ = open(O_RDWR | O_CREAT);
  if (file_ < 0) file_ = open(O_RDONLY);  // another user's
  // If the lock cannot be made for one of these reasons, making the output fails with a better error.
  constexpr std::array kNoPlace = {EACCES, EPERM, EROFS, ENOENT, ENOTDIR, ENAMETOOLONG, ENOSPC, EDQUOT};
  if (file_ < 0 && std::find(kNoPlace.begin(), kNoPlace.end(), errno) != kNoPlace.end()) return Attempt::kDone;
  const int error = file_ < 0 ? errno : 0;
  struct stat opened;
  if (file_ < 0 || ::fstat(file_, &opened) != 0 || !S_ISREG(opened.st_mode)) {
    const char* const kind = otherKindOf(path_);
    if (kind != nullptr && file_ >= 0) ::close(std::exchange(file_, -1));
    if (kind != nullptr)
      throw Error(ErrorCode::kExists, path_, "", fmt::format("is {} in the way of a lock; move it", kind));
  }
  if (file_ < 0) throw systemError(error, path_, "opening the lock");
  try {
    if (!isLock(file_, path_))
      throw Error(ErrorCode::kExists, path_, "", "has the name of a lock file, but is none; move it");
    const int failed = lockAtOnce(file_) ? 0 : errno;
    // The former holder may have removed the file; other processes then lock a new file of this name.
    if (failed == 0 && leadsTo(path_, file_)) return Attempt::kDone;
    disk_has_locks_ = failed == 0 || failed == EWOULDBLOCK;
    if (!disk_has_locks_ && isEmpty(file_)) removeIfStill(path_, file_);
    ::close(std::exchange(file_, -1));
    return failed == 0 ? Attempt::kAgain : failed == EWOULDBLOCK ? Attempt::kBusy : Attempt::kDone;
  } catch (const Error&) {
    if (isEmpty(file_) && lockAtOnce(file_)) removeIfStill(path_, file_);
    ::close(std::exchange(file_, -1));
    throw;
  }
}

// Writes the holder into the lock file, for error messages of other processes. Failure is harmless: the kernel holds
// the lock.
void FileLock::sign() const {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  const std::string text = fmt::format("{}{} on {}\n", kHolder, ::getpid(), host.data());
  if (isOwnFile(file_) && ::ftruncate(file_, 0) == 0 && ::pwrite(file_, text.data(), text.size(), 0) < 0) return;
}

FileLock::~FileLock() {
  if (file_ < 0) return;
  removeIfStill(path_, file_);
  ::close(file_);
}

fs::path lockOf(const fs::path& output) {
  const fs::path folder = output.has_parent_path() ? output.parent_path() : ".";
  std::error_code ignored;
  const bool inside = ::access(folder.c_str(), W_OK) != 0 && fs::is_directory(output, ignored);
  return inside ? output / kLockInside : fs::path(output.string() + ".lock");
}

std::function<void()> refusalOf(const fs::path& output) {
  return [output] {
    const fs::path lock = lockOf(output);
    throw Error(ErrorCode::kExists, output, "",
                fmt::format("is being written by {}, which holds {}; wait for its end, or name another output",
                            holderOf(lock), lock.string()));
  };
}

}  // namespace kiln
