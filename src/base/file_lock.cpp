#include "base/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

namespace kiln {
using namespace std::chrono_literals;

FileLock::FileLock(std::filesystem::path path, const std::function<void()>& waiting) : path_(std::move(path)) {
  while (!taken()) {
    waiting();
    std::this_thread::sleep_for(100ms);
  }
}

bool FileLock::taken() {
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);  // another user's
  if (file_ < 0) return true;
  const int failed = ::flock(file_, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
  // Whoever held it before may have removed it: then others lock another file of that name.
  if (failed == 0 && isStillThere()) return true;
  const bool knows_no_locks = failed != 0 && failed != EWOULDBLOCK && failed != EINTR;
  if (knows_no_locks) ::unlink(path_.c_str());
  ::close(std::exchange(file_, -1));
  return knows_no_locks;
}

FileLock::~FileLock() {
  if (file_ < 0) return;
  if (isStillThere()) ::unlink(path_.c_str());
  ::close(file_);
}

bool FileLock::isStillThere() const {
  struct stat held, named;
  return ::fstat(file_, &held) == 0 && ::stat(path_.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino;
}

}  // namespace kiln
