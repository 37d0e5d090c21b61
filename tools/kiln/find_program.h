// Programs that users have installed.
#pragma once

#include <filesystem>
#include <string>

namespace kiln::tool {

/// The first executable file `name` in the absolute folders of PATH; empty where there is none. Empty and relative
/// elements of PATH are the working directory or below it, where other users' files may lie: they are skipped.
/// throws: Error kIo where a disk fails, so that no other program of the name is taken.
std::filesystem::path findProgram(const std::string& name);

}  // namespace kiln::tool
