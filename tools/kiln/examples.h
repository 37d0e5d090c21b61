// Examples of a command: the end of its help, and a section of its manual page. A test runs every line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace kiln::tool {

/// Ends the command's help with the lines.
void addExamples(CLI::App& command, const std::vector<std::string>& lines);

}  // namespace kiln::tool
