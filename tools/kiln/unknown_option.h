// Proposals for options that a command does not have.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kiln::tool {

/// Returns "--bg: is no option of kiln render; --background?" for the first unexpected word of a command; empty if all
/// words were expected. Names of other programs' options lead to the options of the same meaning.
std::string unknownOptionText(const CLI::App& app);

}  // namespace kiln::tool
