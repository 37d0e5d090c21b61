// Proposals for options that a command does not have, and for words beyond those that it takes.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kiln::tool {

/// Returns "--bg: is no option of kiln render; --background?" for the first unexpected option of a command, or
/// "convert: expected INPUT and OUT (found a b c); ..." for unexpected words; empty if all words were expected. Names
/// of other programs' options lead to the options of the same meaning.
std::string unknownOptionText(const CLI::App& app);

}  // namespace kiln::tool
