#include "base/file/path_status.h"

#include "base/error.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

bool isFound(const fs::file_status& status, const std::error_code& error, const fs::path& path) {
  if (status.type() == fs::file_type::not_found) return false;
  if (status.type() == fs::file_type::none) throw systemError(error.value(), path, "looking for it");
  return true;
}

}  // namespace

bool isThere(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return isFound(status, error, path);
}

bool isFolder(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return isFound(status, error, path) && fs::is_directory(status);
}

bool isNameTaken(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  return isFound(status, error, path);
}

}  // namespace kiln
