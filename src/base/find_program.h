// Programs that users have installed.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

/// Returns the first executable file `name` in the absolute folders of PATH; an empty path if there is none. Skips
/// empty and relative folders of PATH, because other users may have put programs into the working directory.
/// throws: Error kIo if a disk fails, because a later folder may hold another program of the name.
std::filesystem::path findProgram(const std::string& name);

}  // namespace kiln
