// Programs that users have installed.
#pragma once

#include <filesystem>
#include <string>

namespace kiln::tool {

/// The first of that name on PATH that may be run; empty where there is none.
std::filesystem::path findProgram(const std::string& name);

}  // namespace kiln::tool
