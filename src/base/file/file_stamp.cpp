#include "base/file/file_stamp.h"

#include <sys/stat.h>

#include <cerrno>

#include "base/error.h"
#include "base/uninterrupted.h"

namespace kiln {

std::int64_t nanosecondsOf(const std::timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

std::optional<FileStamp> stampOfFile(const std::filesystem::path& path) {
  struct stat status;
  if (uninterrupted([&] { return ::stat(path.c_str(), &status); }) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    throw systemError(errno, path, "looking at the file");
  }
  if (!S_ISREG(status.st_mode)) return std::nullopt;
  return FileStamp{static_cast<std::uint64_t>(status.st_size), nanosecondsOf(status.st_mtim),
                   nanosecondsOf(status.st_ctim)};
}

}  // namespace kiln
