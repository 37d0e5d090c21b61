// Spellings of paths, without a look at the disk.
#pragma once

#include <filesystem>

namespace kiln {

/// Returns "a/b" for "a/b/" and "a/b".
inline std::filesystem::path withoutTrailingSlash(const std::filesystem::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace kiln
