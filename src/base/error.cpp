#include "base/error.h"

#include <cerrno>
#include <cstring>

#include "base/text.h"

namespace kiln {
namespace {

std::string sentence(const std::filesystem::path& path, const std::string& place, const std::string& what) {
  std::string out = path.string();
  if (!place.empty()) out += (out.empty() ? "" : ": ") + place;
  out += (out.empty() ? "" : ": ") + what;
  // File names and messages of libraries may hold any bytes.
  return shown(out);
}

ErrorCode codeOf(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EFBIG:  // a limit on the size of files, the user's or the file system's
    case EDQUOT:
      return ErrorCode::kNoSpace;
    case ENOENT:
    case ENOTDIR:
      return ErrorCode::kNotFound;
    case EEXIST:
      return ErrorCode::kExists;
    default:
      return ErrorCode::kIo;
  }
}

}  // namespace

Error::Error(ErrorCode code, const std::filesystem::path& path, const std::string& place, const std::string& what)
    : std::runtime_error(sentence(path, place, what)), code_(code), path_(path) {}

Error::Error(ErrorCode code, const std::string& what) : Error(code, {}, {}, what) {}

Error systemError(int error_number, const std::filesystem::path& path, const std::string& doing) {
  const ErrorCode code = codeOf(error_number);
  std::string what = std::strerror(error_number);
  if (error_number == ENAMETOOLONG)
    what +=
        "; most file systems allow names of 255 bytes, and Kiln adds up to 13 while it writes, so give a shorter one";
  if (error_number == ELOOP) what += "; the links lead to one another, so mend them or name the file itself";
  if (error_number == EMFILE || error_number == ENFILE)
    what += "; allow more of them (ulimit -n 1024 is enough), then run the command again";
  if (code == ErrorCode::kNoSpace) what += "; free space or choose another place, then run the command again";
  return Error(code, path, doing, what);
}

}  // namespace kiln
