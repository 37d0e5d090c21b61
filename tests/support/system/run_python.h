// Runs scripts with libraries of Python, which judge files or write them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln::test {

/// Runs `script` in `directory` with `arguments`, by the first python3 on PATH or the system's Python, for which
/// packages install modules. A script that fails fails the test. Returns false, without running the script, if neither
/// Python has all `modules` ("json, numpy"): the test then skips and names the package.
bool runPython(const std::string& modules, const std::filesystem::path& directory, const std::string& script,
               const std::vector<std::string>& arguments);

}  // namespace kiln::test
