// Whether names exist on a disk that may fail.
#pragma once

#include <filesystem>

namespace kiln {

/// True where `path` names a file, a directory or a link to either; false for a link to nothing.
/// throws: Error kIo where the system cannot find out, so that a failing disk is not taken for an empty one.
bool isThere(const std::filesystem::path& path);
/// True where `path` names anything, a link to nothing included. throws: as isThere.
bool isNameTaken(const std::filesystem::path& path);

/// True where `path` names a directory or a link to a directory. throws: as isThere.
bool isFolder(const std::filesystem::path& path);

}  // namespace kiln
