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
namespace {

using namespace std::chrono_literals;

}  // namespace

FileLock::FileLock(std::filesystem::path path, const std::function<void()>& waiting) : path_(std::move(path)) {
  for (;;) {
    if (file_ < 0) file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) return;
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) {
      // Whoever held it before has removed it: then others lock another file of that name.
      if (isStillThere()) return;
    } else if (errno != EWOULDBLOCK && errno != EINTR) {
      break;
    } else {
      try {
        waiting();
      } catch (...) {
        ::close(file_);
        throw;
      }
      std::this_thread::sleep_for(100ms);
      continue;
    }
    ::close(std::exchange(file_, -1));
  }
  ::close(std::exchange(file_, -1));
}

FileLock::~FileLock() {
  if (file_ < 0) return;
  ::unlink(path_.c_str());
  ::close(file_);
}

bool FileLock::isStillThere() const {
  struct stat held, named;
  return ::fstat(file_, &held) == 0 && ::stat(path_.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino;
}

}  // namespace kiln
