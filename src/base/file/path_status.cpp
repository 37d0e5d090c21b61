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

void requireFolderOf(const fs::path& place, const fs::path& path) {
  const fs::path directory = place.has_parent_path() ? place.parent_path() : ".";
  std::error_code unknown;
  if (!fs::is_directory(directory, unknown))
    throw Error(ErrorCode::kNotFound, path, "", "cannot be made: there is no directory " + directory.string());
}

bool isNameTaken(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  return isFound(status, error, path);
}

}  // namespace kiln
