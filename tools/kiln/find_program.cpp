#include "find_program.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace kiln::tool {
namespace fs = std::filesystem;

fs::path findProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder) / name;
    if (!program.is_absolute()) continue;
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored) && ::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

}  // namespace kiln::tool
