#include "base/find_program.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <system_error>

#include "base/error.h"

namespace kiln {
namespace fs = std::filesystem;

fs::path findProgram(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path program = fs::path(folder) / name;
    if (!program.is_absolute()) continue;
    // A failing disk must not lead to another program of the same name.
    std::error_code error;
    const bool found = fs::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0;
    if (found) return program;
    if (error == std::errc::io_error) throw systemError(error.value(), program, "looking for the program");
  }
  return {};
}

}  // namespace kiln
