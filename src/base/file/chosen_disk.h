// The file system of an option that may be left out.
#pragma once

#include "base/file/file.h"

namespace kiln {

/// Returns `disk`, or the file system of the operating system if `disk` is null.
inline FileSystem& chosenDisk(FileSystem* disk) { return disk != nullptr ? *disk : FileSystem::real(); }

}  // namespace kiln
