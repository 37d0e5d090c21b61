// Tests whether names exist on a disk that may fail.
#pragma once

#include <filesystem>

namespace kiln {

/// True if `path` names a file, a directory or a link to either; false for a dangling link.
/// throws: Error kIo if the system cannot decide, so a failing disk does not count as an empty disk.
bool isThere(const std::filesystem::path& path);
/// True if `path` names any entry, including a dangling link. throws: as isThere.
bool isNameTaken(const std::filesystem::path& path);

/// True if `path` names a directory or a link to a directory. throws: as isThere.
bool isFolder(const std::filesystem::path& path);
/// Throws Error kNotFound if the directory of `place`, which is to be made, does not exist; the error names `path`.
void requireFolderOf(const std::filesystem::path& place, const std::filesystem::path& path);

}  // namespace kiln
