// Runs examples of the documentation as a user would.
#pragma once

#include <filesystem>
#include <string>

namespace kiln::test {

/// Runs `script` with bash in `directory`/work; `kiln` calls the program's main function in a child of the test's
/// server (tool_client/main.cpp). The first line that fails ends the script and fails the test, which prints the
/// output.
void runScript(const std::filesystem::path& directory, const std::string& script);

}  // namespace kiln::test
